"""`python -m benchmarks.files` → docs/files.md: this program, Blender's importers and trimesh on the same files, side by side.

The inputs are those of `../shared/field/files` (the right value of each in `benchmarks/files_cases.py`) and the dev models. Every reading
of a dev model is a process of its own: its time is the least of three, its memory the process's peak less that of an empty one.
`--checkout DIR` adds a column for the program in another checkout (kept in `benchmarks/results/files.json`).
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import time
from dataclasses import asdict
from pathlib import Path

import numpy as np

from benchmarks.files_cases import CASES, Found

ROOT = Path(__file__).resolve().parents[1]
FIELD, CAD_DEV = ROOT.parent / "shared" / "field" / "files", ROOT.parent / "shared" / "cad" / "dev"
RESULTS, PAGE = ROOT / "benchmarks" / "results" / "files.json", ROOT / "docs" / "files.md"
READERS = ("ours", "blender", "trimesh")
BLENDERS = {".obj": "obj_import", ".stl": "stl_import", ".ply": "ply_import", ".glb": "gltf", ".gltf": "gltf"}
TIMES = 3


def ours(path: Path) -> Found:
    """This program's reader."""
    from addon.errors import UserError
    from addon.scene import cad

    try:
        model = cad.read(path)
    except UserError as error:
        return Found(said=str(error), is_refused=True)
    found = Found(meshes=len(model.meshes), triangles=model.triangle_count, said=" ".join(model.warnings), bounds=model.bounds().tolist())
    for part, matrix in zip(model.parts, model.world_from_part(), strict=True):
        item = getattr(part, "item", None)
        if item is not None:
            found.items.append(getattr(item, "kind", "camera").upper())
        if getattr(part, "is_hidden", False) and part.mesh >= 0:
            found.hidden.append(part.name)
        if part.mesh >= 0:
            mesh = model.meshes[part.mesh]
            found.names.append(part.name)
            areas = _areas(mesh.positions.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3], mesh.triangles)
            found.area += float(areas.sum())
            colors = _colors(model, mesh)
            found.varies |= bool(np.ptp(colors.reshape(-1, 4), axis=0).max() > 0.1)
            found.colors.append(np.average(colors.mean(axis=1), axis=0, weights=np.maximum(areas, 1e-30)).tolist())
    found.items.sort()
    return found


def _areas(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2.0


def _colors(model: object, mesh: object) -> np.ndarray:
    """(T, 3, 4) of the corners of a mesh."""
    count = len(mesh.triangles)
    slots = np.zeros(count, int) if mesh.triangle_slots is None else mesh.triangle_slots
    base = np.array([model.materials[i].base_color for i in mesh.materials] or [(0.8, 0.8, 0.8, 1.0)])[slots][:, None, :]
    own = getattr(mesh, "corner_colors", None)
    return np.broadcast_to(base, (count, 3, 4)) * (1.0 if own is None else own)


def blender(path: Path) -> Found:
    """Blender's own importer; Y up and Z up as its defaults say."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    suffix, found = path.suffix.lower(), Found()
    if suffix not in BLENDERS:
        return Found(said="no importer", is_refused=True)
    try:
        operator = bpy.ops.import_scene.gltf if BLENDERS[suffix] == "gltf" else getattr(bpy.ops.wm, BLENDERS[suffix])
        operator(filepath=str(path))
    except RuntimeError as error:
        return Found(said=" ".join(str(error).split()), is_refused=True)
    objects = [ob for ob in bpy.context.scene.objects if ob.type in ("MESH", "LIGHT", "CAMERA")]
    bpy.context.view_layer.update()
    corners = []
    for ob in objects:
        if ob.type != "MESH":
            found.items.append(ob.data.type if ob.type == "LIGHT" else "CAMERA")
            continue
        mesh, matrix = ob.data, np.array(ob.matrix_world)
        mesh.calc_loop_triangles()
        triangles = np.empty(3 * len(mesh.loop_triangles), np.int32)
        mesh.loop_triangles.foreach_get("vertices", triangles)
        points = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", points)
        points = points.reshape(-1, 3).astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
        if len(triangles):
            found.names.append(ob.name)
            found.triangles += len(triangles) // 3
            found.area += float(_areas(points, triangles.reshape(-1, 3)).sum())
            found.colors.append(_blender_color(mesh))
            found.varies |= bool(mesh.color_attributes)
            corners.append(points)
    found.meshes = len({ob.data for ob in objects if ob.type == "MESH"})
    if corners:
        every = np.concatenate(corners)
        found.bounds = [every.min(axis=0).tolist(), every.max(axis=0).tolist()]
    found.items.sort()
    return found if found.names else Found(said="nothing imported", is_refused=True)


def _blender_color(mesh: object) -> list[float]:
    material = mesh.materials[0] if mesh.materials else None
    nodes = [] if material is None or material.node_tree is None else material.node_tree.nodes
    shader = next((node for node in nodes if node.type == "BSDF_PRINCIPLED"), None)
    if shader is None:
        return [0.8, 0.8, 0.8, 1.0]
    return [*shader.inputs["Base Color"].default_value[:3], shader.inputs["Alpha"].default_value]


def trimesh(path: Path) -> Found:
    """trimesh's loader, as a scene."""
    import trimesh as library

    try:
        scene = library.load_scene(path, process=False)
    except BaseException as error:  # as many kinds as formats
        return Found(said=f"{type(error).__name__}: {error}"[:200], is_refused=True)
    found = Found(meshes=len(scene.geometry))
    for node in scene.graph.nodes_geometry:
        matrix, name = scene.graph[node]
        mesh = scene.geometry[name]
        if hasattr(mesh, "faces") and len(mesh.faces):
            points = mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3]
            if path.suffix.lower() in (".glb", ".gltf", ".obj"):
                points = points @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]], float)
            found.names.append(str(node))
            found.triangles += len(mesh.faces)
            found.area += float(_areas(points, mesh.faces).sum())
            found.colors.append(
                [float(c) / 255.0 for c in np.atleast_2d(mesh.visual.to_color().vertex_colors)[0]] if mesh.visual.defined else []
            )
            found.bounds.append(points)
    if not found.names:
        return Found(said="nothing loaded", is_refused=True)
    every = np.concatenate(found.bounds)
    found.bounds = [every.min(axis=0).tolist(), every.max(axis=0).tolist()]
    return found


def index(reader: str) -> dict[str, bool]:
    """Which of the inputs a reader has right."""
    right = {}
    for name, (_, check) in CASES.items():
        if not (FIELD / name).exists():
            continue
        try:
            right[name] = bool(check(globals()[reader](FIELD / name)))
        except Exception as error:
            print(f"{reader} {name}: {error!r}", file=sys.stderr)
            right[name] = False
    return right


def one(reader: str, path: Path) -> dict:
    """A dev model read `TIMES` times: what was found, the least seconds, and the peak of memory above that before, MiB."""
    _read_only(reader, FIELD / "same_names.obj")  # what is loaded only once
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    seconds = []
    for _ in range(TIMES):
        _empty(reader)
        start = time.process_time()
        _read_only(reader, path)
        seconds.append(time.process_time() - start)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    found = globals()[reader](path)
    return {**asdict(found), "seconds": min(seconds), "mib": (peak - before) / 1024.0, "colors": [], "names": len(found.names)}


def _empty(reader: str) -> None:
    """Let Blender have nothing of the reading before."""
    if reader != "trimesh":
        import bpy

        bpy.ops.wm.read_factory_settings(use_empty=True)


def _read_only(reader: str, path: Path) -> None:
    """What a user waits for: the objects in Blender; for trimesh its scene."""
    if reader == "trimesh":
        import trimesh as library

        library.load_scene(path, process=False)
        return
    import bpy

    if reader == "ours":
        from addon.blender.cad_import import to_blender
        from addon.scene import cad

        to_blender(cad.read(path), bpy.context.scene.collection)
    else:
        operator = bpy.ops.import_scene.gltf if BLENDERS[path.suffix] == "gltf" else getattr(bpy.ops.wm, BLENDERS[path.suffix])
        operator(filepath=str(path))


def child(*arguments: str, checkout: Path = ROOT) -> dict:
    """This module in a process of its own, with the add-on of a checkout."""
    code = (
        f"import sys; sys.path.insert(0, {str(ROOT)!r}); from benchmarks.files import main; sys.path.insert(0, {str(checkout)!r});"
        "main(sys.argv[1:])"
    )
    done = subprocess.run([sys.executable, "-P", "-c", code, *arguments], capture_output=True, text=True, errors="replace", check=False)
    line = done.stdout.rstrip().rpartition("\n")[2]
    if not line.startswith("{"):
        raise RuntimeError(done.stderr[-2000:])
    return json.loads(line)


def page(results: dict) -> str:
    """The documentation's page."""
    columns = [name for name in ("before", *READERS) if name in results["index"]]
    titles = {"before": "this program at b3797fc", "ours": "this program", "blender": "Blender's importer", "trimesh": "trimesh"}
    mark = {True: "right", False: "–", None: "no reader"}
    rows = [
        f"| `{name}` | {right} | " + " | ".join(mark[results["index"][column].get(name)] for column in columns) + " |"
        for name, (right, _) in CASES.items()
    ]
    counts = " | ".join(f"**{sum(results['index'][column].values())} of {len(CASES)}**" for column in columns)
    lines = [
        "# Files, measured",
        "",
        "Made by `python -m benchmarks.files`; do not edit. Small files that stand for kinds of trouble, with what is right of each; the",
        "checks are in `benchmarks/files_cases.py`. A reader that has no importer for a format counts as not right.",
        "",
        "| File | Right | " + " | ".join(titles[column] for column in columns) + " |",
        "| --- | --- |" + " --- |" * len(columns),
        *rows,
        f"| | | {counts} |",
        "",
        "## Real models",
        "",
        "From the file to objects in Blender (trimesh: to its scene): least processor time of three in seconds, peak of memory above that",
        "of the loaded program in MiB; parts and area as each reader has them, in the file's unit.",
        "",
        "| Model | Reader | Parts | Triangles | Area | Seconds | MiB |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for model, readers in results["models"].items():
        for reader, got in readers.items():
            if got["is_refused"]:
                continue
            numbers = f"{got['names']:,} | {got['triangles']:,} | {got['area']:.5g} | {got['seconds']:.2f} | {got['mib']:.0f}"
            lines.append(f"| {model} | {titles[reader]} | {numbers} |")
    return "\n".join(lines) + "\n"


def measure(results: dict, only_missing: bool) -> None:
    """Everything, or what is not there yet; kept as it comes."""
    for reader in READERS:
        if not (only_missing and reader in results["index"]):
            results["index"][reader] = child("--index", reader)
    for path in sorted(CAD_DEV.glob("*.*")):
        own = results["models"].setdefault(path.name, {}) if path.suffix in (*BLENDERS, ".step") else {}
        for reader in READERS if path.suffix in BLENDERS else ("ours", "trimesh") if path.suffix == ".step" else ():
            if not (only_missing and reader in own):
                own[reader] = child("--one", reader, str(path))
                RESULTS.write_text(json.dumps(results, indent=1) + "\n")


def main(arguments: list[str]) -> None:
    """Measure, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--index", choices=READERS, help="only print which inputs this reader has right")
    parser.add_argument("--one", nargs=2, metavar=("READER", "FILE"), help="only print what one reading costs")
    parser.add_argument("--checkout", type=Path, help="another checkout, for the column before")
    parser.add_argument("--missing", action="store_true", help="measure only what has not been measured")
    parser.add_argument("--page-only", action="store_true", help="write the page from what was measured")
    asked = parser.parse_args(arguments)
    if asked.index or asked.one:
        print(json.dumps(index(asked.index) if asked.index else one(asked.one[0], Path(asked.one[1]))))
        return
    results = json.loads(RESULTS.read_text()) if RESULTS.exists() else {"index": {}, "models": {}}
    if asked.checkout:
        results["index"]["before"] = child("--index", "ours", checkout=asked.checkout.resolve())
    elif not asked.page_only:
        measure(results, asked.missing)
    RESULTS.write_text(json.dumps(results, indent=1) + "\n")
    PAGE.write_text(page(results), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
