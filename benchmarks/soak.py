"""Many previews with random edits in one process, and what grows meanwhile; for docs/reliability.md:

    python -m benchmarks.soak [--previews 2000] [--seed 1]     a row to benchmarks/results/soak.json; a quarter of an hour

After each edit the scene is rendered as F12 does. The first fifth is for caches to fill; the rest must not grow: memory's slope is told
with its 95 % interval, objects of OpenGL's, threads, handlers and temporary files as a difference.
"""

from __future__ import annotations

import argparse
import gc
import json
import os
import random
import tempfile
import threading
from collections import Counter
from pathlib import Path

import numpy as np

from benchmarks.gl_faults import names
from benchmarks.reliability import RESULTS, rows

SIZE = (96, 64)
TESTS, WARPS = ("triangle", "id-depth", "depth"), ("logpsm", "uniform", "lispsm")


def memory_mib() -> float:
    """What this process has of the computer's memory now (Linux)."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20


def slope(values: list[float]) -> tuple[float, float]:
    """MiB per 1,000 previews and half its 95 % interval, of a straight line; from means of runs of 20, since neighbours are alike."""
    runs = np.asarray(values[: len(values) // 20 * 20]).reshape(-1, 20).mean(axis=1)
    x = np.arange(len(runs)) * 20.0
    (steep, level), covariance = np.polyfit(x, runs, 1, cov=True)
    return 1000.0 * float(steep), 1960.0 * float(np.sqrt(covariance[0, 0]))


def edit(rng: random.Random) -> None:
    """Change something of the open scene, as a user does."""
    import bpy

    scene = bpy.context.scene
    settings, meshes = scene.cad_shadow, [one for one in scene.objects if one.type == "MESH"]
    change = rng.randrange(7)
    if change == 0 or len(meshes) < 4:
        bpy.ops.mesh.primitive_uv_sphere_add(segments=rng.randint(4, 24), location=[rng.uniform(-3, 3) for _ in range(3)])
    elif change == 1 and len(meshes) > 12:
        mesh = rng.choice(meshes[1:]).data
        bpy.data.meshes.remove(mesh)
    elif change == 2:
        rng.choice(meshes).location.z = rng.uniform(0, 2)
    elif change == 3:
        settings.test = rng.choice(TESTS)
    elif change == 4:
        settings.warp = rng.choice(WARPS)
    elif change == 5:
        scene.render.resolution_x = SIZE[0] + 8 * rng.randrange(4)
    else:
        scene.camera.location.x = rng.uniform(4, 8)


def state() -> dict[str, int]:
    """What must not grow."""
    import bpy

    from addon.pipeline.gl.context import shared_worker

    gc.collect()
    shared_worker().call(lambda context: None)
    kinds: Counter = shared_worker().call(names)
    handlers = sum(len(value) for value in (getattr(bpy.app.handlers, one) for one in dir(bpy.app.handlers)) if isinstance(value, list))
    return {
        "OpenGL objects": sum(kinds.values()),
        "threads": threading.active_count(),
        "handlers": handlers,
        "temporary files": len(os.listdir(tempfile.gettempdir())),
    }


def soaked(previews: int, seed: int) -> dict[str, object]:
    """The row of a run."""
    import bpy

    rng, values, begin = random.Random(seed), [], {}
    bpy.ops.object.camera_add(location=(6, -6, 5), rotation=(1.02, 0, 0.785))
    scene = bpy.context.scene
    scene.camera = bpy.context.object
    scene.render.engine, scene.cad_shadow.map_size = "CAD_SHADOW_PREVIEW", 128
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = *SIZE, 100
    for number in range(previews):
        if number == previews // 5:
            begin = most(scene)
        edit(rng)
        bpy.ops.render.render()
        if number >= previews // 5:
            values.append(memory_mib())
    end = most(scene)
    grown, half = slope(values)
    differences = {name: end[name] - begin[name] for name in begin}
    return {"previews": previews, "MiB at the end": round(values[-1]), "MiB per 1,000": round(grown, 2), "±": round(half, 2), **differences}


def most(scene: object) -> dict[str, int]:
    """`state` after the same three pictures: what is kept depends on the last one."""
    import bpy

    kept = scene.cad_shadow.test, scene.cad_shadow.warp, scene.render.resolution_x
    for test in TESTS:
        scene.cad_shadow.test, scene.cad_shadow.warp, scene.render.resolution_x = test, "uniform", SIZE[0]
        bpy.ops.render.render()
    found = state()
    scene.cad_shadow.test, scene.cad_shadow.warp, scene.render.resolution_x = kept
    return found


def section(found: list[dict[str, object]]) -> str:
    """The section of docs/reliability.md; nothing before there is a row."""
    if not found:
        return ""
    heads = list(found[-1])
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    lines += ["| " + " | ".join(f"{row[head]:,}" for head in heads) + " |" for row in found]
    return SECTION.replace("TABLE", "\n".join(lines))


SECTION = """
## Long use
Previews with random edits in one process (`python -m benchmarks.soak`): objects come, move and go, settings, sizes and the view change.
Memory is a straight line through what the process takes after the first fifth, with the 95 % interval of its slope; objects, threads,
handlers and temporary files as the difference over that time.

TABLE
"""


def main() -> None:
    """Run, and add the row."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--previews", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    choice = parser.parse_args()
    with tempfile.TemporaryDirectory() as own:
        tempfile.tempdir = own  # so that other programs' files are not counted
        import bpy

        import addon

        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        addon.register()
        row = soaked(choice.previews, choice.seed)
        addon.unregister()
        tempfile.tempdir = None
    print(json.dumps(row))
    kept = [one for one in rows("soak") if one["previews"] != row["previews"]]
    (RESULTS / "soak.json").write_text(json.dumps([*kept, row], indent=1) + "\n")


if __name__ == "__main__":
    main()
