"""docs/window.md's tables: `python -m benchmarks.window read` measures how long Blender's scene takes to be read; `python -m
benchmarks.window held|newcomer|stress` takes the numbers of the last `./dev gui-test held|newcomer|stress` from build/gui/result.json.

All are kept in benchmarks/results/window.json, and the page's tables are made anew from there. CPU time where it says so, so that a busy
machine does not count; the window's own times are wall-clock times.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
import time
from collections.abc import Callable
from pathlib import Path

from benchmarks.tables import table

ROOT = Path(__file__).resolve().parents[1]
PAGE, RESULTS, TAKEN = ROOT / "docs" / "window.md", ROOT / "benchmarks" / "results" / "window.json", ROOT / "build" / "gui" / "result.json"
MARKED = re.compile(r"(<!-- window: ([a-z]+) -->\n).*?(<!-- end -->)", re.DOTALL)
HELD = ("cpu", "lock", "events")
OBJECTS, MESHES, ROUNDS = (1_000, 10_000), 100, 40


def field(count: int) -> None:
    """An empty file with so many objects that share `MESHES` meshes of one material each."""
    import bpy

    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    bpy.ops.mesh.primitive_cube_add()
    base = bpy.context.object
    meshes = [base.data.copy() for _ in range(MESHES)]
    for i, mesh in enumerate(meshes):
        mesh.materials.append(bpy.data.materials.new(f"painted {i}"))
    for i in range(count - 1):
        ob = bpy.data.objects.new(f"part {i}", meshes[i % MESHES])
        ob.location = i % 100, i // 100, 0.0
        bpy.context.scene.collection.objects.link(ob)


def least_ms(function: Callable[[], object]) -> float:
    """The least CPU time of several calls, milliseconds."""
    times = []
    for _ in range(ROUNDS):
        start = time.process_time()
        function()
        times.append(time.process_time() - start)
    return round(1e3 * min(times), 1)


def reading() -> dict[str, dict[str, float]]:
    """CPU milliseconds for scenes that did not change since they were last read: Blender's part, on its main thread, and the rest; beside
    it the bare loop over Blender's instances that asks each for its object, mesh and name, and their matrices in one call."""
    import bpy

    from addon.blender.snapshot import SceneReader
    from addon.blender.snapshot.instances import read_matrices

    found = {}
    for count in OBJECTS:
        field(count)
        depsgraph, reader = bpy.context.evaluated_depsgraph_get(), SceneReader()
        reader.read(depsgraph)

        def bare(depsgraph: bpy.types.Depsgraph = depsgraph) -> None:
            for instance in depsgraph.object_instances:
                ob = instance.object
                _ = ob.data, ob.name

        collected = reader.collect(depsgraph)
        found[f"{count:,} objects"] = {
            "main thread": least_ms(lambda r=reader, d=depsgraph: r.collect(d)),
            "rest": least_ms(collected.scene),
            "bare loop": least_ms(bare),
            "matrices": least_ms(lambda d=depsgraph, n=count: read_matrices(d, n)),
        }
    return found


def read_table(found: dict[str, dict[str, float]]) -> str:
    """One row per number of objects."""
    head = ("", "main thread, ms", "rest, ms", "of it Blender's loop alone, ms", "its matrices, ms")
    return table(head, ((name, *(row[k] for k in ("main thread", "rest", "bare loop", "matrices"))) for name, row in found.items()))


def held_table(found: dict[str, dict[str, dict[str, object]]]) -> str:
    """One row per action, some numbers per scene."""
    actions = list(dict.fromkeys(action for rows in found.values() for action in rows))
    head = ["", *(f"{scene}: {what}" for scene in found for what in HELD)]

    def cells(action: str) -> list[str]:
        rows = [scene.get(action) for scene in found.values()]
        return [f"{row[key]:.0f}" if row else "–" for row in rows for key in HELD]

    return table(head, ([action, *cells(action)] for action in actions))


def newcomer_table(found: dict[str, object]) -> str:
    """One row per step of the README."""
    steps = {name: value for name, value in found.items() if isinstance(value, float)}
    return table(("Step", "seconds"), [*((name, f"{s:.1f}") for name, s in steps.items()), ("**all**", f"{sum(steps.values()):.1f}")])


def stress_table(found: dict[str, dict[str, object]]) -> str:
    """Before and after."""
    return table(("", "before", "after"), ((name, str(found["before"][name]), str(found["after"][name])) for name in found["before"]))


TABLES = {"read": read_table, "held": held_table, "newcomer": newcomer_table, "stress": stress_table}


def taken(what: str) -> dict[str, object]:
    """The numbers of the last GUI test; SystemExit when it was another one."""
    result = json.loads(TAKEN.read_text(encoding="utf-8")) if TAKEN.is_file() else {}
    found = result.get("held_up_ms" if what == "held" else "numbers")
    if not found or (what == "stress") != ("before" in found) or not all(step["ok"] for step in result["steps"]):
        raise SystemExit(f"{TAKEN} holds no numbers of it: run ./dev gui-test {what} first")
    return found


def main() -> int:
    """Measure or take the numbers, keep them, make the tables."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.window", description=__doc__.split("\n")[0])
    parser.add_argument("what", choices=TABLES, help="which table is made anew")
    what = parser.parse_args().what
    kept = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.is_file() else {}
    kept[what] = reading() if what == "read" else taken(what)
    RESULTS.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    page = PAGE.read_text(encoding="utf-8")
    made = MARKED.sub(lambda m: m[1] + (f"\n{TABLES[m[2]](kept[m[2]])}\n\n" if m[2] in kept else "\nNot measured yet.\n\n") + m[3], page)
    PAGE.write_text(made, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
