"""What benchmarks.performance draws: scenes that grow, changes of a scene, and whole processes."""

from __future__ import annotations

import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from math import log
from pathlib import Path
from statistics import median

import numpy as np

from addon.maths import spaces
from addon.maths.view import Camera, Light
from addon.pipeline.job import Job
from addon.pipeline.renderer import Renderer
from addon.pipeline.timing import cost_of_frame
from addon.scene.records import Instances, Mesh, Scene
from addon.settings.groups import Settings
from benchmarks.models import CAD_DEV
from benchmarks.views import lights

ROOT = Path(__file__).resolve().parents[1]
RUNS = 3


def heap(parts: int, triangles: int, shapes: int | None = None) -> Scene:
    """So many blocks of so many triangles each on a square; `shapes` different meshes among them, None: each its own."""
    side = max(1, round((triangles / 12) ** 0.5))
    meshes = [_block(i, side) for i in range(shapes or parts)]
    placed, width = np.tile(np.eye(4), (parts, 1, 1)), round(parts**0.5)
    placed[:, 0, 3], placed[:, 1, 3] = np.arange(parts) % width, np.arange(parts) // width
    placed[:, 2, 3] = np.random.default_rng(1).random(parts)
    ids = np.arange(parts)
    colors = np.tile([0.6, 0.6, 0.6, 1.0], (parts, 1))
    return Scene(tuple(meshes), Instances(ids % len(meshes), placed, ids, np.zeros(parts), colors), tuple(map(str, ids)), np.zeros(3))


def _block(number: int, side: int) -> Mesh:
    """A block of 12·side² triangles, a little different for each number."""
    u, v = np.meshgrid(np.linspace(0.0, 0.8, side + 1), np.linspace(0.0, 0.8, side + 1))
    first = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    faces = np.concatenate([np.stack([first, first + 1, first + side + 2], -1), np.stack([first, first + side + 2, first + side + 1], -1)])
    positions, normals, triangles = [], [], []
    for axis in range(3):
        for end in (0.0, 0.8):
            points = np.empty((u.size, 3))
            points[:, axis], points[:, axis - 2], points[:, axis - 1] = end, u.ravel(), v.ravel()
            triangles.append((faces if end else faces[:, ::-1]) + sum(map(len, positions)))
            positions.append(points * (1.0 + 1e-4 * (number % 97)))
            normals.append(np.tile(np.eye(3)[axis] * (1.0 if end else -1.0), (len(points), 1)))
    return Mesh(("heap", number, side), np.concatenate(positions), np.concatenate(normals), np.concatenate(triangles))


def seen_from(scene: Scene, size: tuple[int, int]) -> tuple[Camera, Light]:
    """The whole from above, and a sun from the side."""
    bounds = scene.bounds_ws()
    middle, reach = bounds.mean(axis=0), float(np.linalg.norm(bounds[1] - bounds[0]))
    clip = spaces.perspective(0.35, size[0] / size[1], 0.01 * reach, 4.0 * reach)
    camera = Camera(spaces.look_at(middle + reach * np.array([0.7, -0.9, 0.6]), middle), clip, 0.01 * reach, 4.0 * reach)
    return camera, lights(camera)["side"]


def cpu(renderer: Renderer, jobs: list[Job]) -> float:
    """Median processor milliseconds of frames."""
    return median(renderer.submit(job, cost_of_frame)[0].result().cpu_ms for job in jobs)


def job_of(scene: Scene, size: tuple[int, int] = (1280, 720), **groups: object) -> Job:
    """A live picture of a scene."""
    camera, light = seen_from(scene, size)
    return Job(scene, camera, light, Settings().replaced(**({"shading": {"samples": 1}} | groups)), size, measure=False)


def changed(scene: Scene, **columns: np.ndarray) -> Scene:
    """The scene with other columns of its instances."""
    return replace(scene, instances=replace(scene.instances, **columns))


def updates() -> Iterator[tuple[str, dict[str, float]]]:
    """Processor milliseconds of the frame after each change, and of the first."""
    for label, scene in (
        ("2,000 unique", heap(2000, 108)),
        ("10,000 unique", heap(10_000, 108)),
        ("10,000 of 100", heap(10_000, 108, 100)),
    ):
        renderer, job = Renderer(), job_of(scene)
        row = {"first picture": cpu(renderer, [job])}
        row["nothing"] = cpu(renderer, [job] * RUNS)
        for name, make in CHANGES.items():
            steps = [make(job, i) for i in range(1, RUNS + 1)]
            row[name] = median(_after(renderer, job, step) for step in steps)
        renderer.worker.close()
        yield label, row


def _after(renderer: Renderer, before: Job, after: Job) -> float:
    renderer.submit(before)[0].result()
    return cpu(renderer, [after])


def _moved(job: Job, rows: slice, step: int) -> Job:
    matrices = np.array(job.scene.instances.world_from_object)
    matrices[rows, 2, 3] += 0.1 * step
    return replace(job, scene=changed(job.scene, world_from_object=matrices))


def _colored(job: Job, step: int) -> Job:
    colors = np.array(job.scene.instances.base_color)
    colors[step] = 0.1, 0.2, 0.9, 1.0
    return replace(job, scene=changed(job.scene, base_color=colors))


def _edited(job: Job, step: int) -> Job:
    meshes = list(job.scene.meshes)
    old = meshes[step]
    meshes[step] = Mesh((*old.key, step), old.positions * 1.1, old.normals, old.triangles)
    return replace(job, scene=replace(job.scene, meshes=tuple(meshes)))


def _halved(job: Job, step: int) -> Job:
    columns = {name: np.array(getattr(job.scene.instances, name))[::2] for name in job.scene.instances.__dataclass_fields__}
    return replace(job, scene=replace(job.scene, instances=Instances(**columns)))


CHANGES: dict[str, Callable[[Job, int], Job]] = {
    "camera moved": lambda job, i: replace(job, camera=job.camera.carried(job.scene.bounds_ws().mean(axis=0), 0.02 * i)),
    "light moved": lambda job, i: replace(job, light=replace(job.light, direction_ws=_turned(job.light.direction_ws, 0.02 * i))),
    "one part moved": lambda job, i: _moved(job, slice(i, i + 1), i),
    "every other moved": lambda job, i: _moved(job, slice(None, None, 2), i),
    "one colour": _colored,
    "one mesh edited": _edited,
    "every other hidden": _halved,
}


def _turned(direction: np.ndarray, angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ direction


SMALL = 640, 360
CURVES: dict[str, tuple[tuple[float, ...], Callable[[float], Job]]] = {
    "triangles": ((25_000, 100_000, 400_000), lambda n: job_of(heap(400, int(n) // 400), SMALL)),
    "parts": ((500, 2_000, 8_000), lambda n: job_of(heap(int(n), 12), SMALL)),
    "pixels": ((57_600, 230_400, 921_600), lambda n: job_of(heap(400, 192), (round((n * 16 / 9) ** 0.5), round((n * 9 / 16) ** 0.5)))),
    "texels of a map": ((256**2, 512**2, 1024**2), lambda n: job_of(heap(400, 192), SMALL, fit={"size": round(n**0.5)})),
    "partitions": ((1, 2, 4), lambda n: job_of(heap(400, 1200), SMALL, partition={"kind": "z-log", "count": int(n)})),
}


def curves() -> Iterator[tuple[str, dict[str, float]]]:
    """Processor milliseconds of a frame with the camera moved, over what grows."""
    for name, (values, make) in CURVES.items():
        row = {}
        for value in values:
            renderer, job = Renderer(), make(value)
            row[f"{value:,.0f}"] = cpu(renderer, [CHANGES["camera moved"](job, i) for i in range(RUNS + 1)][1:])
            renderer.worker.close()
        yield name, row


def slope(row: dict[str, float]) -> float:
    """Of the last step, on logarithmic scales: 1 is in proportion."""
    (a, x), (b, y) = list(row.items())[-2:]
    return log(y / x) / log(float(b.replace(",", "")) / float(a.replace(",", "")))


PLAIN = """import sys, bpy
bpy.ops.wm.read_factory_settings(use_empty=True)
{load}(filepath=sys.argv[1])
scene = bpy.context.scene
from mathutils import Vector
corners = [o.matrix_world @ Vector(c) for o in scene.objects if o.type == 'MESH' for c in o.bound_box]
low, high = ([pick(c[i] for c in corners) for i in range(3)] for pick in (min, max))
middle, reach = (Vector(low) + Vector(high)) / 2, (Vector(high) - Vector(low)).length
camera = bpy.data.objects.new('c', bpy.data.cameras.new('c'))
camera.location = middle + Vector((0.7, -0.9, 0.6)) * reach
camera.rotation_euler = (middle - camera.location).to_track_quat('-Z', 'Y').to_euler()
camera.data.clip_end = 10 * reach
sun = bpy.data.objects.new('s', bpy.data.lights.new('s', 'SUN'))
sun.data.angle, sun.rotation_euler = 0.0, (0.6, 0.3, 0.0)
for o in (camera, sun):
    scene.collection.objects.link(o)
scene.camera = camera
scene.render.engine, scene.cycles.samples, scene.cycles.max_bounces, scene.cycles.use_denoising = 'CYCLES', 4, 0, False
scene.render.resolution_x, scene.render.resolution_y = 1280, 720
scene.render.filepath = sys.argv[2]
bpy.ops.render.render(write_still=True)
"""
LOADERS = {".glb": "bpy.ops.import_scene.gltf", ".stl": "bpy.ops.wm.stl_import"}
STARTED = ("tray_bottom_mm.stl", "amazing_hand.glb", "huldra_utilities.glb")


def start() -> Iterator[tuple[str, dict[str, float]]]:
    """Processor seconds of whole processes: `preview` of this program, and a plain script with Blender's importer and Cycles, 4 samples."""
    for name in (n for n in STARTED if (CAD_DEV / n).is_file()):
        path = CAD_DEV / name
        with tempfile.TemporaryDirectory() as folder:
            script = Path(folder) / "plain.py"
            script.write_text(PLAIN.format(load=LOADERS[path.suffix]))
            ours = [sys.executable, "-m", "addon", "preview", str(path), "--size", "1280x720", "-o", folder, "--quiet"]
            plain = [sys.executable, str(script), str(path), str(Path(folder) / "plain.png")]
            nothing = [sys.executable, "-c", "import bpy"]
            kinds = {"ours": ours, "Cycles, a plain script": plain, "import bpy": nothing}
            yield name, {kind: median(_process_s(command) for _ in range(RUNS)) for kind, command in kinds.items()}


def _process_s(command: list[str]) -> float:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
