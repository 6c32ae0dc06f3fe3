"""`advise`: for each input, the frames are read through Blender's render, the search runs, its table is printed and its report written."""

from __future__ import annotations

import argparse
import re
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ...studies.advice import Advice, Goal, SampledFrame, advice_report, advice_table, advise
from ...studies.advice.goal import MOST_FRAMES, picked_frames
from ...studies.advice.report import proposed_options
from ...studies.advice.sampled_frame import small_size
from ...studies.outputs import write_json
from ..argument_types import positive, positive_number
from ..command import Command
from ..shared_arguments import SECTIONS, add_inputs, add_method, add_reporting, add_view

if TYPE_CHECKING:
    import bpy

    from ...blender.render_wish import RenderWish

HEAD = ("input", "version", "gl", "settings", "warnings", "errors")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """A goal, how long to search for it, and everything about a picture."""
    group = parser.add_argument_group("what is wanted").add_mutually_exclusive_group(required=True)
    group.add_argument("--texels", type=positive, metavar="N", help="the least error with this many texels in all maps together")
    group.add_argument(
        "--error", type=positive_number, metavar="M", help="the fewest texels with which 95 %% of the pixels have an error m below this"
    )
    search = parser.add_argument_group("search")
    search.add_argument(
        "--frames",
        type=frame_list,
        default=(),
        metavar="A-B",
        help=f"frames of the animation, {MOST_FRAMES} of them are looked at (default: one)",
    )
    search.add_argument(
        "--seconds", type=positive_number, default=120.0, metavar="S", help="decide after this time at the latest (default 120)"
    )
    add_inputs(parser)
    add_reporting(parser)
    add_view(parser)
    add_method(parser, *SECTIONS)


def frame_list(text: str) -> tuple[int, ...]:
    """A-B as `picked_frames` has it; a single frame as itself."""
    match = re.fullmatch(r"(-?\d+)(?:-(-?\d+))?", text)
    if not match:
        raise ValueError(text)
    first, last = int(match[1]), int(match[2] or match[1])
    if last < first:
        raise argparse.ArgumentTypeError(f"{text}: the last frame comes before the first")
    return picked_frames(first, last)


def advise_command(scene: bpy.types.Scene, wish: RenderWish, stem: Path, args: argparse.Namespace) -> tuple[dict[str, object], str]:
    """Search and report; `--output` also writes the report there."""
    frames, head = read_frames(scene, wish, args.frames)
    advice = searched(frames, Goal(args.texels, args.error), args.seconds)
    report = {**head, "advice": advice_report(advice)}
    if args.output:
        write_json(stem.with_name(f"{stem.name}_advice.json"), report)
    return (
        report,
        f"{advice.tried} combinations over {len(frames)} frame{'s' * (len(frames) > 1)}\n{advice_table(advice)}\n{summary(advice)}",
    )


def read_frames(scene: bpy.types.Scene, wish: RenderWish, numbers: tuple[int, ...]) -> tuple[list[SampledFrame], dict[str, object]]:
    """These frames (none: the current one) as a render sees them, and the report's head; the scene's frame is put back."""
    from ...blender.rendering import render
    from ...blender.sources import render_size

    size = wish.size or render_size(scene)
    kept, outcomes = scene.frame_current, []
    try:
        for number in numbers or (kept,):
            if numbers:
                scene.frame_set(number)
            outcomes.append(render(scene, replace(wish, size=small_size(size))))
    finally:
        if numbers:
            scene.frame_set(kept)
    frames = [SampledFrame(replace(outcome.job, size=size), number) for outcome, number in zip(outcomes, numbers or (0,), strict=True)]
    report = outcomes[0].report
    return frames, {key: report[key] for key in HEAD}


def searched(frames: list[SampledFrame], goal: Goal, seconds: float) -> Advice:
    """The search run to its end."""
    search = advise(frames, goal, seconds)
    while True:
        try:
            next(search)
        except StopIteration as stop:
            return stop.value


def summary(advice: Advice) -> str:
    """The proposal as options of the command line, and what it changes."""
    if advice.best is None:
        return "no proposal"
    options = " ".join(_as_argument(name.replace("_", "-"), value) for name, value in proposed_options(advice).items())
    now, then = advice.confirmed_current, advice.confirmed
    return f"{options}\nm p95 {then['m_p95']:.3g} (now {now['m_p95']:.3g}), {then['total_ms']:.0f} ms a picture (now {now['total_ms']:.0f})"


def _as_argument(name: str, value: object) -> str:
    if isinstance(value, bool):
        return f"--{name}" if value else f"--no-{name}"
    return f"--{name} {_word(value)}"


def _word(value: object) -> str:
    return ",".join(f"{v:g}" for v in value) if isinstance(value, tuple) else str(value)


ROW = Command(
    "advise",
    place=70,
    help="the best warp, partition, fit, map size and shadow test",
    description="Try the combinations on each input, measure them, and propose the best for a budget of texels or a wanted error.",
    add_arguments=add_arguments,
    work=advise_command,
)
