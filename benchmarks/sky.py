"""Light from all round against Cycles: white surfaces under a white world, no bounces, which is ambient occlusion (docs/sky.md).

Cycles samples the pixels' centres with faces flat, as the pass `ao` does. Also how much the same places differ between two views.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

import bpy
import numpy as np

from addon.blender.cad_import import to_blender
from addon.blender.snapshot import SceneReader
from addon.cli import rivals
from addon.images.contact_sheet import contact_sheet
from addon.images.png import encode_png
from addon.images.srgb import srgb
from addon.maths.view import Camera
from addon.pipeline.job import Job
from addon.pipeline.passes.gbuffer import seen_surface
from addon.pipeline.renderer import shared_renderer
from addon.scene.cad import read
from addon.scene.default_view import camera_for_view
from addon.scene.platform_deck import build
from addon.scene.records import Scene
from addon.settings.groups import Settings
from benchmarks import models

SIZE = (320, 200)
COUNTS = (16, 64, 256)
CYCLES_SAMPLES = 256


def opened(name: str) -> Scene:
    """The model in Blender's file, as objects, and as arrays."""
    model = build(triangles=100_000, seed=1) if name == "deck" else read(models.CAD_DEV / name)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    to_blender(model, bpy.context.scene.collection)
    for mesh in bpy.data.meshes:
        if "custom_normal" in mesh.attributes:
            mesh.attributes.remove(mesh.attributes["custom_normal"])
        mesh.shade_flat()
    return SceneReader().read(bpy.context.evaluated_depsgraph_get())


def white() -> bpy.types.Material:
    """A diffuse white."""
    made = bpy.data.materials.new("white")
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    surface, out = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("BsdfDiffuse", "OutputMaterial"))
    surface.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    tree.links.new(surface.outputs[0], out.inputs["Surface"])
    return made


def by_cycles(scene: Scene, camera: Camera, samples: int) -> tuple[np.ndarray, float]:
    """(h, w) what a white world lights, and the seconds it took."""
    blender = bpy.context.scene
    world = blender.world = bpy.data.worlds.new("white")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    bpy.context.view_layer.material_override = white()
    with rivals.prepared(blender, SIZE, samples, None, scene.origin_ws), TemporaryDirectory() as folder:
        blender.render.engine, blender.cycles.filter_width = "CYCLES", 0.01
        blender.render.film_transparent = False
        rivals.place_camera(blender, camera, scene.origin_ws)
        image = blender.render.image_settings
        image.file_format, image.color_depth = "OPEN_EXR", "32"
        blender.render.filepath = str(Path(folder, "ao.exr"))
        begin = perf_counter()
        bpy.ops.render.render(write_still=True)
        seconds = perf_counter() - begin
        loaded = bpy.data.images.load(blender.render.filepath)
        pixels = np.array(loaded.pixels[:], np.float32).reshape(SIZE[1], SIZE[0], -1)[::-1, :, 0]
        bpy.data.images.remove(loaded)
    return pixels, seconds


def ours(scene: Scene, camera: Camera, count: int) -> tuple[dict[str, np.ndarray], float]:
    """The passes with so many samples, and the seconds they took."""
    settings = Settings().replaced(sky={"samples": count}, shading={"samples": 1})
    job = Job(scene, camera, None, settings, SIZE, ("ao", "depth", "object"), measure=False)
    begin = perf_counter()
    return shared_renderer().submit(job)[0].result().passes, perf_counter() - begin


def between_views(scene: Scene, camera: Camera, count: int) -> float:
    """Mean difference of the pass at the places that two views, a tenth of the way round from each other, both see."""
    other = camera.carried(scene.bounds_ws().mean(axis=0), np.radians(20.0))
    (one, _), (two, _) = ours(scene, camera, count), ours(scene, other, count)
    seen, points = seen_surface(one["depth"], camera, np.float64)
    clip = np.concatenate([points, np.ones((len(points), 1))], axis=1) @ other.clip_from_world.T
    column = np.rint((clip[:, 0] / clip[:, 3] + 1.0) * SIZE[0] / 2.0 - 0.5).astype(int)
    row = np.rint((clip[:, 1] / clip[:, 3] + 1.0) * SIZE[1] / 2.0 - 0.5).astype(int)
    inside = (column >= 0) & (column < SIZE[0]) & (row >= 0) & (row < SIZE[1])
    column, row = column[inside], row[inside]
    depth = two["depth"][::-1][row, column]
    same = np.abs(depth - clip[inside, 3]) < 0.002 * clip[inside, 3]
    return float(np.abs(one["ao"][::-1][seen][inside][same] - two["ao"][::-1][row, column][same]).mean())


def rows_of(name: str, counts: tuple[int, ...], sheet: list[np.ndarray]) -> list[str]:
    """The model's rows of the table; its pictures go to the sheet."""
    scene = opened(name)
    camera = camera_for_view(scene, SIZE)
    truth, cycles_seconds = by_cycles(scene, camera, CYCLES_SAMPLES)
    rows = []
    for count in counts:
        passes, seconds = ours(scene, camera, count)
        seen = passes["object"] >= 0
        off = passes["ao"][seen] - np.clip(truth[seen], 0.0, 1.0)
        views = between_views(scene, camera, count)
        numbers = f"{off.mean():+.4f} | {np.abs(off).mean():.4f} | {np.sqrt((off**2).mean()):.4f} | {views:.4f}"
        rows.append(f"| `{name}` | {scene.triangle_count:,} | {count} | {numbers} | {seconds:.1f} | {cycles_seconds:.1f} |")
    sheet += [np.repeat(np.clip(image, 0.0, 1.0)[..., None], 3, axis=-1) for image in (passes["ao"], np.where(seen, truth, 1.0))]
    return rows


def main() -> None:
    """Print the table; with --sheet also our pictures beside Cycles'."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("models", nargs="*", default=models.available())
    parser.add_argument("--counts", type=lambda text: tuple(map(int, text.split(","))), default=COUNTS)
    parser.add_argument("--sheet", type=Path)
    args = parser.parse_args()
    print("| Model | Triangles | Samples | Mean | Mean absolute | RMS | Between views | Seconds | Cycles |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    sheet: list[np.ndarray] = []
    for name in args.models:
        print(*rows_of(name, args.counts, sheet), sep="\n", flush=True)
    if args.sheet:
        captions = [f"{name}, {whose}" for name in args.models for whose in ("ours", "Cycles")]
        picture = srgb(contact_sheet(sheet, captions, columns=2))
        args.sheet.write_bytes(encode_png(np.rint(255.0 * picture[..., :3]).astype(np.uint8)))


if __name__ == "__main__":
    main()
