"""`preview`, `analyse`, `compare`: one picture, written and reported."""

from __future__ import annotations

import argparse
from pathlib import Path

import bpy

from ...blender.render_wish import RenderWish
from ...blender.rendering import render
from ...images.png import encode_png
from ...images.whole import check_picture
from ...pipeline.render_passes import USUAL_PASSES
from ...studies.light_view import SIZE as LIGHT_VIEW_SIZE
from ...studies.light_view import light_picture
from ...studies.outputs import write_bytes, write_json, write_npz, write_pass, written
from ...studies.run import Outcome
from ...studies.truth.against import against_truth, sentence
from ...studies.truth.compare import COMPARED_PASSES


def preview(scene: bpy.types.Scene, wish: RenderWish, stem: Path, args: argparse.Namespace) -> tuple[dict[str, object], str]:
    """Render and write the passes and the report."""
    wanted = args.passes or (USUAL_PASSES if args.format == "npz" else ("combined",))
    wish.passes = wanted
    written_files = []
    if args.format != "npz" and "combined" in wanted:
        path = stem.with_name(f"{stem.name}_combined.{args.format}")
        with written(path, check_picture) as temporary:
            outcome = render(scene, wish, temporary)
        written_files.append(path.name)
    else:
        outcome = render(scene, wish)
    written_files += write_data(outcome, stem, wanted, args.format)
    if args.light_view:
        path = stem.with_name(f"{stem.name}_light_view.png")
        write_bytes(path, encode_png(light_picture(outcome.job, outcome.frame.plan, LIGHT_VIEW_SIZE)))
        written_files.append(path.name)
    write_json(stem.with_name(f"{stem.name}_report.json"), outcome.report)
    return outcome.report, f"{outcome.report['timing_ms']['total'] / 1e3:.2f} s, wrote {', '.join(written_files)} to {stem.parent}"


def write_data(outcome: Outcome, stem: Path, wanted: tuple[str, ...], kind: str) -> list[str]:
    """Write what is not the combined picture; gives the files' names."""
    if kind == "npz":
        path = stem.with_name(f"{stem.name}.npz")
        write_npz(path, outcome, wanted)
        return [path.name]
    paths = {name: stem.with_name(f"{stem.name}_{name}.{kind}") for name in wanted if name != "combined"}
    for name, path in paths.items():
        write_pass(path, name, outcome)
    return [path.name for path in paths.values()]


def analyse(scene: bpy.types.Scene, wish: RenderWish, stem: Path, args: argparse.Namespace) -> tuple[dict[str, object], str]:
    """Render without a picture; the report is written where --output or --report say."""
    outcome = render(scene, wish)
    if args.output:
        write_json(stem.with_name(f"{stem.name}_report.json"), outcome.report)
    return outcome.report, summary(outcome.report)


def summary(report: dict[str, object]) -> str:
    """The report in a line."""
    measured = report["measured"]
    if not measured or measured["m_max"] is None:
        return "nothing measured: no lit surface in view"
    share = 100.0 * measured["share_above_1"]
    return (
        f"m median {measured['m_median']:.3g}, 95 % {measured['m_p95']:.3g}, max {measured['m_max']:.3g}; {share:.1f} % of pixels above 1"
    )


def compare_command(scene: bpy.types.Scene, wish: RenderWish, stem: Path, args: argparse.Namespace) -> tuple[dict[str, object], str]:
    """Render, trace rays through the same pixel centres, count the differences."""
    wish.passes = COMPARED_PASSES
    outcome = render(scene, wish)
    difference = against_truth(outcome)
    write_bytes(stem.with_name(f"{stem.name}_difference.png"), encode_png(difference))
    write_json(stem.with_name(f"{stem.name}_report.json"), outcome.report)
    return outcome.report, sentence(outcome.report["truth"])
