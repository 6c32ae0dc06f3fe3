"""`compare`: the pixels of each input's picture whose shadow differs from traced rays."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ...images.png import encode_png
from ...studies.outputs import write_bytes, write_json
from ...studies.truth.against import against_truth, sentence
from ...studies.truth.compare import COMPARED_PASSES
from ..command import Command
from ..shared_arguments import SECTIONS, add_batch, add_inputs, add_method, add_reporting, add_view

if TYPE_CHECKING:
    import bpy

    from ...blender.render_wish import RenderWish


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Everything about a picture but its passes."""
    add_inputs(parser)
    add_reporting(parser)
    add_view(parser)
    add_method(parser, *SECTIONS)
    add_batch(parser)


def compare(scene: bpy.types.Scene, wish: RenderWish, stem: Path, args: argparse.Namespace) -> tuple[dict[str, object], str]:
    """Render, trace rays through the same pixel centres, count the differences."""
    from ...blender.rendering import render

    wish.passes = COMPARED_PASSES
    outcome = render(scene, wish)
    difference = against_truth(outcome)
    write_bytes(stem.with_name(f"{stem.name}_difference.png"), encode_png(difference))
    write_json(stem.with_name(f"{stem.name}_report.json"), outcome.report)
    return outcome.report, sentence(outcome.report["truth"])


ROW = Command(
    "compare",
    place=30,
    help="against ray-traced truth",
    description="Count the pixels whose shadow differs from traced rays.",
    add_arguments=add_arguments,
    work=compare,
)
