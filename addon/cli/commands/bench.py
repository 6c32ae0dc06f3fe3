"""`bench`: what a frame of this program costs beside the bare passes of everything and beside Blender's own engines, in turns in one run.

What is compared is the same scene, size, samples, light with shadows, and moving camera; pipeline against bare passes, and F12 against F12.
Ratios of medians are what counts: absolute times belong to a machine. Processor time is that of all threads together.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING

import numpy as np

from ...maths.view import Camera
from ...pipeline.job import Job
from ...pipeline.timing import FrameCost, cost_of_frame, costing
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
OURS_F12 = "ours, F12"
NOTHING_F12 = "Blender alone, F12"
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
    """What every contestant costs for the job's picture, its camera moved every frame; the medians, and ours over those of the others.

    With `rivals` also the F12 of ours and one that draws nothing, in the same scene. The first frame is not counted.
    """
    from .. import rivals as others

    costs: dict[str, list[FrameCost]] = {}
    samples, origin = job.settings.shading.samples, job.scene.origin_ws
    with others.prepared(blender_scene, job.size, samples, job.light, origin) if rivals else nullcontext():
        for number, camera in enumerate(cameras(job, frames)):
            measured = _own_costs(replace(job, camera=camera), renderer)
            if rivals:
                measured[OURS_F12] = _own_f12(blender_scene, replace(job, camera=camera))
                measured[NOTHING_F12] = others.cost_of(blender_scene, others.NOTHING, camera, origin)
                measured |= {rival: others.cost_of(blender_scene, rival, camera, origin) for rival in rivals}
            if number:
                for name, cost in measured.items():
                    costs.setdefault(name, []).append(cost)
            line = ", ".join(f"{name} {cost.wall_ms:.0f} ms" for name, cost in measured.items())
            say(f"frame {number}: {line}{'' if number else ' (warm-up)'}")
    if bare_passes is not None:
        renderer.submit(job, bare_passes.release_kept)[0].result()
    return {
        "triangles": job.scene.triangle_count,
        "instances": len(job.scene.instances),
        "size": list(job.size),
        "samples": samples,
        "map_size": job.settings.fit.size,
        "frames": frames,
        **_summary(costs, "wall_ms", ""),
        **_summary(costs, "cpu_ms", "cpu_"),
        "left_out": [] if bare_passes else [LEFT_OUT],
    }


def _summary(costs: dict[str, list[FrameCost]], kind: str, prefix: str) -> dict[str, object]:
    """Times, medians and ratios of one kind of time; pipelines are compared with the pipeline, F12s with the F12."""
    times = {name: [getattr(cost, kind) for cost in own] for name, own in costs.items()}
    medians = {name: median(values) for name, values in times.items()}
    pipeline = ("ours", "bare passes")
    ratios = {name: medians["ours" if name in pipeline else OURS_F12] / value for name, value in medians.items() if value > 0.0}
    ratios = {name: ratio for name, ratio in ratios.items() if name not in ("ours", OURS_F12)}
    return {f"times_{prefix}ms": times, f"median_{prefix}ms": medians, f"ours_over{'_cpu' * bool(prefix)}": ratios}


def _own_costs(job: Job, renderer: Renderer | RemoteRenderer) -> dict[str, FrameCost]:
    """What our frame and, where they are at hand, the bare passes cost."""
    if bare_passes is None:
        return {"ours": renderer.submit(job, cost_of_frame)[0].result()}
    ours, plain = renderer.submit(job, bare_passes.timed)[0].result()
    return {"ours": ours, "bare passes": plain}


def _own_f12(scene: bpy.types.Scene, job: Job) -> FrameCost:
    """What an F12 with our engine costs: reading the scene, the picture, and handing it to Blender."""
    from ...blender.render_wish import RenderWish
    from ...blender.rendering import render
    from ..rivals import place_camera

    place_camera(scene, job.camera, job.scene.origin_ws)
    wish = RenderWish(job.name, ("combined",), settings=job.settings, size=job.size, light=lambda *_: job.light)
    with costing() as cost:
        render(scene, wish)
    return cost[0]


def text_table(result: dict[str, object]) -> str:
    """The result for people."""
    head = (
        f"{result['triangles']:,} triangles in {result['instances']:,} instances, {result['size'][0]}×{result['size'][1]}, "
        f"samples {result['samples']}, maps of {result['map_size']}², {result['frames']} frames, camera moved each frame"
    )
    rows = [f"{'':<20}{'wall ms':>10}{'processor ms':>14}   ours over it (wall, processor)"]
    for name, wall in result["median_ms"].items():
        ratios = [result[kind].get(name) for kind in ("ours_over", "ours_over_cpu")]
        told = "   " + ", ".join(f"{ratio:.2f}" for ratio in ratios) if None not in ratios else ""
        rows.append(f"{name:<20}{wall:>10.0f}{result['median_cpu_ms'][name]:>14.0f}{told}")
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
