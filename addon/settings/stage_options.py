"""The options of feature edges, ground and sections, and when each of them changes anything. No bpy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .option import Option, choice
from .words import CAP_WORDS, GROUND_WORDS

STAGE_OPTIONS: tuple[Option, ...] = (
    Option(
        "edges",
        (("edges", "width"),),
        "number",
        "Edges",
        "Width of the lines along sharp edges, outlines and where parts meet, in pixels; 0 draws none",
        soft=(0.0, 4.0),
    ),
    Option("edge_color", (("edges", "color"),), "color", "Edge Color", "Color of the lines"),
    Option("edge_strength", (("edges", "strength"),), "number", "Edge Strength", "How strongly the lines cover what is below them"),
    Option(
        "edge_angle",
        (("edges", "crease_deg"),),
        "number",
        "Edge Angle",
        "Faces that meet at more than this angle have a line between them, in degrees",
        soft=(1.0, 90.0),
    ),
    choice("ground", "ground", "kind", "Ground", "An unseen floor under the model that catches its shadows", GROUND_WORDS),
    Option(
        "ground_height",
        (("ground", "height"),),
        "number",
        "Height",
        "Where the ground lies, in the world",
        soft=(-100.0, 100.0),
        unit="m",
    ),
    Option("ground_strength", (("ground", "strength"),), "number", "Strength", "How dark the shadows on the ground are"),
    choice("section_caps", "section", "caps", "Caps", "How closed bodies look where a section cuts them", CAP_WORDS),
    Option("section_color", (("section", "cap_color"),), "color", "Cap Color", "Color of the cut faces"),
    Option(
        "section_whole",
        (("section", "casts_whole"),),
        "switch",
        "Uncut Shadows",
        "What a section cuts away still casts its shadow",
    ),
)


def _has_edges(v: Any) -> bool:
    return v.edges > 0.0


STAGE_APPLIES: dict[str, Callable[[Any], bool]] = {
    "ground_height": lambda v: v.ground == "height",
    "ground_strength": lambda v: v.ground != "off",
    "section_color": lambda v: v.section_caps != "none",
    "edge_color": _has_edges,
    "edge_strength": _has_edges,
    "edge_angle": _has_edges,
}
