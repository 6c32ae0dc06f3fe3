"""Surfaces close behind one another: which one shows, against float64 rays. `python -m benchmarks.depth` writes docs/scale_plates.md.

    python -m benchmarks.depth --cases 20      fewer plates drawn at random
    python -m benchmarks.depth --print         the tables only, nothing is written

Three ways on the same cases (`tests/plates.py`): *before* is a 24-bit depth buffer, the camera's own near and far and one float32 matrix;
*now* is the program with clip control; *now, without* is the program as it draws where the driver has none (macOS).
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable
from pathlib import Path
from statistics import fmean

import moderngl
import numpy as np

from addon.pipeline.bare_passes import merged
from addon.pipeline.device import Device, device_of
from addon.pipeline.gl.context import GpuWorker
from addon.pipeline.gl.gl_raw import raw_gl
from addon.pipeline.gl.programs import matrix_bytes, set_uniforms
from addon.pipeline.gl.readback import read_texture
from addon.pipeline.passes.gbuffer import draw_gbuffer
from benchmarks.tables import table
from tests import plates
from tests.plates import PlateCase

PAGE = Path(__file__).resolve().parents[1] / "docs" / "scale_plates.md"
ALLOWED = 0.003
KINDS = {"up to 5 times as large as the picture shows of them": 0.7, "up to 5,000 times as large": 3.7}
INTRO = """# Surfaces close behind one another

Made by `python -m benchmarks.depth`; do not edit. Pixels that show another surface than the one that a float64 ray through their centre
meets first, in per cent of the pixels that show any, 320×180, llvmpipe. Pixels where the next surface lies within 1e-6 of the distance are
left out. **Before**: a 24-bit depth buffer, the camera's own near and far, one float32 matrix. **Now**: 32-bit float depths with their
digits where they are needed, near and far fitted to what is seen, places relative to an anchor near it, huge triangles cut to the view in
float64; with clip control, and without it as on macOS, where the fragments write their depth.
"""
TAIL = """Plates drawn at random: 0.1 m to 10 km away, 1.2e-6 to 1e-3 of that apart, tilted up to 75°, far/near 1e2 to 1e8, through 10 to
2000 mm or in parallel, off the origin by up to three times their distance.
"""
Draw = Callable[[moderngl.Context, Device, PlateCase], np.ndarray]


def drawn_before(context: moderngl.Context, device: Device, case: PlateCase) -> np.ndarray:
    """(h, w) objects as a plain camera pass shows them."""
    program = device.programs.get("bare.vert", "bare.frag", COLOR=1)
    positions, normals, slots, indices = (context.buffer(array.tobytes()) for array in merged(case.scene))
    colors = [context.texture(plates.SIZE, n, dtype=kind) for n, kind in ((1, "f4"), (2, "f2"), (2, "u4"))]
    depth = context.depth_texture(plates.SIZE)
    target = context.framebuffer(colors, depth)
    content = [(positions, "3f4", "in_position"), (normals, "3f4", "in_normal"), (slots, "1u4", "in_slot")]
    array = context.vertex_array(program, content, index_buffer=indices)
    target.use()
    target.clear()
    context.enable_only(moderngl.DEPTH_TEST)
    row = np.asarray(-case.camera.view_from_world[2], np.float32).tobytes()
    set_uniforms(program, u_clip_from_world=matrix_bytes(case.camera.clip_from_world), u_view_depth_from_world=row)
    array.render()
    objects = np.where(read_texture(colors[0]) > 0.0, read_texture(colors[2])[..., 0].astype(int), -1)
    device.unbind()
    for thing in (array, target, depth, *colors, positions, normals, slots, indices):
        thing.release()
    return objects


def drawn_now(context: moderngl.Context, device: Device, case: PlateCase) -> np.ndarray:
    """(h, w) objects as the program's camera pass shows them."""
    draw_list, target = device.store.sync(case.scene), device.gbuffer(plates.SIZE)
    draw_gbuffer(context, device.programs, target, draw_list, case.camera)
    slots = read_texture(target.ids)[..., 0].astype(int)
    return np.where(slots > 0, case.scene.instances.object_id[draw_list.rows_of_slot[slots - 1]], -1)


def without_clip_control(context: moderngl.Context, device: Device, case: PlateCase) -> np.ndarray:
    """The same as on a driver without."""
    raw = raw_gl(context)
    control, raw.ClipControl = raw.ClipControl, None
    objects = drawn_now(context, device, case)
    raw.ClipControl = control
    return objects


WAYS: dict[str, Draw] = {"before": drawn_before, "now": drawn_now, "now, without": without_clip_control}


def shares(worker: GpuWorker, case: PlateCase) -> tuple[float, ...]:
    """The share of wrong pixels by each of `WAYS`."""
    return worker.call(lambda context: tuple(case.wrong_share(draw(context, device_of(context, worker), case)) for draw in WAYS.values()))


def named_table(worker: GpuWorker) -> str:
    """A line for each named case, per cent."""
    return table(["case", *WAYS], ([case.name, *(_percent(s) for s in shares(worker, case))] for case in plates.named()))


def drawn_table(worker: GpuWorker, count: int) -> str:
    """Mean, worst, and how many of `count` are above `ALLOWED`, for each kind of plates drawn at random."""
    lines = []
    for kind, largest in KINDS.items():
        found = [shares(worker, plates.drawn(seed, largest=largest)) for seed in range(count)]
        columns = list(zip(*found, strict=True))
        for what, of in _SUMMARIES.items():
            lines.append([f"{kind}: {what}", *(of(column) for column in columns)])
    return table([f"{count} drawn at random", *WAYS], lines)


def _percent(share: float) -> str:
    return f"{100.0 * share:.2f}"


_SUMMARIES: dict[str, Callable[[Iterable[float]], str]] = {
    "mean %": lambda column: f"{100.0 * fmean(column):.4f}",
    "worst %": lambda column: _percent(max(column)),
    f"above {100.0 * ALLOWED:g} %": lambda column: str(sum(share > ALLOWED for share in column)),
}


def main() -> None:
    """Measure, print and write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=100)
    parser.add_argument("--print", action="store_true", dest="prints_only")
    choice = parser.parse_args()
    worker = GpuWorker()
    text = "\n".join([INTRO, named_table(worker), "", drawn_table(worker, choice.cases), "", TAIL])
    worker.close()
    print(text)
    if not choice.prints_only:
        PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
