"""`bench`: frame times of this program beside the bare passes of everything and beside Blender's own engines, interleaved in one run.

What is compared is the same scene, size and moving camera. Ratios of medians are what counts: absolute times belong to a machine.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING

import numpy as np

from ...maths.view import Camera
from ...pipeline.job import Job
from ...studies.outputs import write_json
from ...studies.run import renderer
from ...studies.terminal import complain
from ..argument_types import positive
from ..command import Command
from ..shared_arguments import SECTIONS, add_inputs, add_method, add_reporting, add_view

try:
    from ...pipeline import bare_passes
except ImportError:  # the package leaves them out
    bare_passes = None

if TYPE_CHECKING:
    import bpy

    from ...blender.render_wish import RenderWish
    from ...pipeline.remote.renderer import RemoteRenderer
    from ...pipeline.renderer import Renderer

LEFT_OUT = "bare passes: left out, they come with the source only; from a checkout ./dev bench times them too"
ORBIT_STEP_RAD = np.radians(1.0)
RIVALS = ("workbench", "cycles", "eevee")
EXAMPLE_TRIANGLES = 1_000_000


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Everything about a picture, frames and rivals; without an input the example is drawn."""
    add_inputs(parser)
    parser.set_defaults(example=EXAMPLE_TRIANGLES)
    add_reporting(parser)
    add_view(parser)
    add_method(parser, *SECTIONS)
    group = parser.add_argument_group("benchmark")
    group.add_argument("--frames", type=positive, default=7, metavar="N", help="frames that count, one more warms up (default 7)")
    group.add_argument(
        "--rivals", type=rival_list, default=(), metavar="NAME[,NAME…]", help=f"Blender's engines to time too: {', '.join(RIVALS)}"
    )


def rival_list(text: str) -> tuple[str, ...]:
    """Comma-separated names of Blender's engines."""
    names = tuple(name.strip() for name in text.split(","))
    unknown = [name for name in names if name not in RIVALS]
    if unknown:
        raise argparse.ArgumentTypeError(f"unknown rival '{unknown[0]}': choose from {', '.join(RIVALS)}")
    return names


def cameras(job: Job, frames: int) -> list[Camera]:
    """One camera per frame, turned about the scene's middle by a degree each, plus one to warm up."""
    middle = job.scene.bounds_ws().mean(axis=0)
    return [job.camera.carried(middle, i * ORBIT_STEP_RAD) for i in range(frames + 1)]


def run(
    job: Job,
    frames: int,
    blender_scene: bpy.types.Scene | None,
    rivals: tuple[str, ...],
    renderer: Renderer | RemoteRenderer,
    say: Callable[[str], None],
) -> dict[str, object]:
    """Times in ms of every contestant for the job's picture, its camera moved every frame; their medians, and the medians' ratios to ours.

    The first frame is not counted.
    """
    times: dict[str, list[float]] = {}
    for number, camera in enumerate(cameras(job, frames)):
        measured = _own_times(replace(job, camera=camera), renderer)
        for rival in rivals:
            measured[rival] = _rival_time(blender_scene, rival, job, camera)
        if number:
            for name, value in measured.items():
                times.setdefault(name, []).append(value)
        say(
            f"frame {number}: " + ", ".join(f"{name} {value:.0f} ms" for name, value in measured.items()) + ("" if number else " (warm-up)")
        )
    if bare_passes is not None:
        renderer.submit(job, bare_passes.forget)[0].result()
    medians = {name: median(values) for name, values in times.items()}
    return {
        "triangles": job.scene.triangle_count,
        "instances": len(job.scene.instances),
        "size": list(job.size),
        "map_size": job.settings.fit.size,
        "frames": frames,
        "times_ms": times,
        "median_ms": medians,
        "left_out": [] if bare_passes else [LEFT_OUT],
        "ours_over": {name: medians["ours"] / value for name, value in medians.items() if name != "ours"},
    }


def _own_times(job: Job, renderer: Renderer | RemoteRenderer) -> dict[str, float]:
    """Milliseconds of our frame and, where they are at hand, of the bare passes."""
    if bare_passes is None:
        return {"ours": renderer.submit(job)[0].result().timing_ms["total"]}
    ours, plain = renderer.submit(job, bare_passes.timed)[0].result()
    return {"ours": ours, "bare passes": plain}


def _rival_time(scene: bpy.types.Scene, rival: str, job: Job, camera: Camera) -> float:
    """Milliseconds of one render of Blender's own engine, the camera moved first."""
    import bpy

    engines = {"workbench": ("BLENDER_WORKBENCH",), "cycles": ("CYCLES",), "eevee": ("BLENDER_EEVEE_NEXT", "BLENDER_EEVEE")}
    _prepare_rival(scene, rival, engines[rival], job.size)
    _place_camera(scene, camera, job.scene.origin_ws)
    begin = time.perf_counter()
    bpy.ops.render.render(scene=scene.name)
    return (time.perf_counter() - begin) * 1e3


def _prepare_rival(scene: bpy.types.Scene, rival: str, engines: tuple[str, ...], size: tuple[int, int]) -> None:
    known = scene.render.bl_rna.properties["engine"].enum_items.keys() if rival != "cycles" else ("CYCLES",)
    scene.render.engine = next((e for e in engines if e in known), engines[-1])
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = *size, 100
    if rival == "cycles":
        scene.cycles.samples, scene.cycles.use_denoising, scene.render.use_persistent_data = 1, False, True
    elif rival == "eevee":
        scene.eevee.taa_render_samples = 1
    else:
        scene.display.shading.show_shadows, scene.display.render_aa = True, "OFF"


def _place_camera(scene: bpy.types.Scene, camera: Camera, origin_ws: np.ndarray) -> None:
    """Put the scene's camera (made if there is none) where `camera` is."""
    import bpy
    from mathutils import Matrix

    ob = scene.camera
    if ob is None:
        ob = bpy.data.objects.new("Bench camera", bpy.data.cameras.new("Bench camera"))
        scene.collection.objects.link(ob)
        scene.camera = ob
    placed = camera.world_from_view.copy()
    placed[:3, 3] += origin_ws
    ob.matrix_world = Matrix(placed.tolist())
    ob.data.sensor_fit = "VERTICAL"
    ob.data.angle_y = 2.0 * camera.half_fov_rad
    ob.data.clip_start, ob.data.clip_end = camera.near, camera.far


def text_table(result: dict[str, object]) -> str:
    """The result for people."""
    head = (
        f"{result['triangles']:,} triangles in {result['instances']:,} instances, {result['size'][0]}×{result['size'][1]}, "
        f"maps of {result['map_size']}², {result['frames']} frames, camera moved each frame"
    )
    rows = [f"{'ours':<14}{result['median_ms']['ours']:>10.0f} ms"]
    rows += [f"{name:<14}{result['median_ms'][name]:>10.0f} ms   ours = {ratio:.2f} × this" for name, ratio in result["ours_over"].items()]
    return "\n".join([head, *rows, *result["left_out"]])


def bench_command(scene: bpy.types.Scene, wish: RenderWish, stem: Path, args: argparse.Namespace) -> tuple[dict[str, object], str]:
    """Time frames of a moving camera; one camera sample a pixel unless asked otherwise, as in a live view."""
    from ...blender.rendering import render

    if "option_samples" not in args:
        wish.settings = wish.settings.replaced(shading={"samples": 1})
    outcome = render(scene, wish)
    result = run(
        replace(outcome.job, passes=("combined",), measure=False, impostors=None),
        args.frames,
        scene,
        args.rivals,
        renderer(),
        lambda line: None if args.quiet else complain(line),
    )
    report = {**outcome.report, "bench": result}
    if args.output:
        write_json(stem.with_name(f"{stem.name}_bench.json"), report)
    return report, text_table(result)


ROW = Command(
    "bench",
    place=80,
    help="frame times, beside the bare passes and Blender's engines",
    description="Move the camera, time every frame, interleaved with the rivals; ratios of medians are what counts.",
    add_arguments=add_arguments,
    work=bench_command,
)
