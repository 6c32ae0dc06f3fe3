"""`advise`: for each input, the frames are read through Blender's render, the search runs, its table is printed and its report written."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import bpy

from ...blender.render_wish import RenderWish
from ...blender.rendering import render
from ...blender.sources import render_size
from ...studies.advice import Advice, Goal, Shot, advice_report, advice_table, advise
from ...studies.advice.shots import small_size
from ...studies.outputs import write_json

HEAD = ("input", "version", "gl", "settings", "warnings", "errors")


def advise_command(scene: bpy.types.Scene, wish: RenderWish, stem: Path, args: argparse.Namespace) -> tuple[dict[str, object], str]:
    """Search and report; `--output` also writes the report there."""
    shots, head = read_shots(scene, wish, args.frames)
    advice = searched(shots, Goal(args.texels, args.error), args.seconds)
    report = {**head, "advice": advice_report(advice)}
    if args.output:
        write_json(stem.with_name(f"{stem.name}_advice.json"), report)
    return report, f"{advice.tried} combinations over {len(shots)} frame{'s' * (len(shots) > 1)}\n{advice_table(advice)}\n{summary(advice)}"


def read_shots(scene: bpy.types.Scene, wish: RenderWish, frames: tuple[int, ...]) -> tuple[list[Shot], dict[str, object]]:
    """One shot per frame (none given: the current one) as a render sees it, and the report's head. The scene's frame is put back."""
    size = wish.size or render_size(scene)
    kept, outcomes = scene.frame_current, []
    try:
        for frame in frames or (kept,):
            if frames:
                scene.frame_set(frame)
            outcomes.append(render(scene, replace(wish, size=small_size(size))))
    finally:
        if frames:
            scene.frame_set(kept)
    numbers = frames or (0,)
    shots = [Shot(replace(outcome.job, size=size), number) for outcome, number in zip(outcomes, numbers, strict=True)]
    report = outcomes[0].report
    return shots, {key: report[key] for key in HEAD}


def searched(shots: list[Shot], goal: Goal, seconds: float) -> Advice:
    """The search run to its end."""
    search = advise(shots, goal, seconds)
    while True:
        try:
            next(search)
        except StopIteration as stop:
            return stop.value


def summary(advice: Advice) -> str:
    """The proposal as options of the command line, and what it changes."""
    if advice.best is None:
        return "no proposal"
    words = {**advice.best.candidate.options, "map_size": advice.best.size}
    options = " ".join(f"--{name.replace('_', '-')} {_word(value)}" for name, value in words.items())
    now, then = advice.confirmed_current, advice.confirmed
    return f"{options}\nm p95 {then['m_p95']:.3g} (now {now['m_p95']:.3g}), {then['total_ms']:.0f} ms a picture (now {now['total_ms']:.0f})"


def _word(value: object) -> str:
    return ",".join(f"{v:g}" for v in value) if isinstance(value, tuple) else str(value)
