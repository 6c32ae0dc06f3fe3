"""The options about impostors: part of `options.OPTIONS`, here for their number. No bpy."""

from __future__ import annotations

from typing import Any

from .option import Kind, Option, choice
from .words import IMPOSTOR_CASTER_WORDS, IMPOSTOR_PROJECTION_WORDS, IMPOSTOR_USE_WORDS, IMPOSTOR_WARP_WORDS, PREDICTOR_WORDS

GROUP = "impostor"


def _one(name: str, field: str, kind: Kind, label: str, text: str, **rest: Any) -> Option:
    return Option(name, ((GROUP, field),), kind, label, text, **rest)


IMPOSTOR_OPTIONS: tuple[Option, ...] = (
    choice(
        "impostor_use",
        GROUP,
        "use",
        "Impostors",
        "When objects marked as impostors are captured and drawn from a texture with depth",
        IMPOSTOR_USE_WORDS,
    ),
    _one(
        "impostor_fresh",
        "fresh",
        "switch",
        "Fresh in Renders",
        "Final renders capture their impostors anew in each picture, which then depends on no other; off: they live on from frame to frame",
    ),
    choice(
        "impostor_projection",
        GROUP,
        "projection",
        "Projection",
        "From where the texture's rays come at capture",
        IMPOSTOR_PROJECTION_WORDS,
    ),
    _one(
        "impostor_back",
        "back_layer",
        "switch",
        "Back Layer",
        "Keep where the solids end behind the first surface: side walls that come into view are closed instead of missing",
    ),
    _one(
        "impostor_fill",
        "fill",
        "switch",
        "Fill Hidden",
        "What lay hidden behind a nearer part at capture is taken to go on there; off: holes where it comes into view",
    ),
    _one(
        "impostor_views",
        "views",
        "count",
        "Views",
        "Captures kept, and drawn together where the nearest alone is over the error limit or one of a set of directions: the nearest two "
        "dithered, the others where those have holes",
    ),
    _one(
        "impostor_directions",
        "directions",
        "count",
        "Directions",
        "0: captured from the eye; n: from n × n directions round the object, each when first needed and then kept, for whole orbits",
        soft=(0, 16),
    ),
    choice(
        "impostor_warp",
        GROUP,
        "warp",
        "Impostor Warp",
        "How the texture follows the moving eye",
        IMPOSTOR_WARP_WORDS,
    ),
    choice(
        "impostor_predictor",
        GROUP,
        "predictor",
        "Predictor",
        "Which predicted error decides when an impostor is captured anew",
        PREDICTOR_WORDS,
    ),
    _one(
        "impostor_limit",
        "limit",
        "number",
        "Error Limit",
        "Predicted error above which an impostor is captured anew, in the predictor's unit; with Edge Sum, fast or not, the share of its "
        "pixels that are wrong",
        soft=(0.005, 0.5),
        start=0.03,
    ),
    _one(
        "impostor_texels",
        "texels_per_pixel",
        "number",
        "Texels per Pixel",
        "Texture resolution at capture as a multiple of the picture's (RI 5-1): more texels stay sharp longer on approach",
        soft=(0.5, 4.0),
    ),
    choice(
        "impostor_casters",
        GROUP,
        "casters",
        "Shadows From",
        "What casts the shadows of objects that are drawn as impostors",
        IMPOSTOR_CASTER_WORDS,
    ),
    _one(
        "impostor_max_texels",
        "max_texels",
        "count",
        "Largest Texture",
        "Texels of the longer side at most; above that the texels grow",
        soft=(128, 4096),
        unit="texel",
    ),
    _one(
        "impostor_tilt",
        "max_tilt_deg",
        "number",
        "Largest Tilt (°)",
        "Degrees by which the view of an impostor may turn before it is captured anew, whatever the predicted error",
        soft=(5.0, 60.0),
    ),
    _one(
        "impostor_captures",
        "regenerations",
        "count",
        "Captures",
        "Impostors captured for one picture of a view at most: fewer keep the view smooth, the others wait or are drawn as geometry",
        soft=(1, 16),
    ),
    _one(
        "impostor_memory",
        "memory_mib",
        "count",
        "Memory (MiB)",
        "MiB for all impostors together: beyond it the least needed become geometry",
        soft=(64, 4096),
    ),
    _one(
        "impostor_fade",
        "fade_frames",
        "count",
        "Crossfade",
        "Pictures over which a new texture replaces the old one, dithered; 0 changes at once",
        soft=(0, 10),
    ),
    _one(
        "impostor_sprite",
        "sprite_px",
        "number",
        "Sprite up to (px)",
        "Pixels (Schaufler's β) up to which the texture is shown as captured, not warped; 1 is RI's, which shows on thin parts",
        soft=(0.0, 2.0),
    ),
    _one(
        "impostor_ahead",
        "ahead",
        "number",
        "Capture Ahead",
        "A view that moves on is met ahead, where its texture will be right: by this share of the error limit it may be wrong until then; "
        "0 captures from the view itself, as RI",
        soft=(0.0, 0.9),
    ),
    _one(
        "impostor_break_even",
        "break_even",
        "switch",
        "Geometry if Cheaper",
        "Marked objects with so few triangles that drawing them costs less than their texture are drawn as geometry",
    ),
)


def _is_used(values: Any) -> bool:
    return values.impostor_use != "off"


def _is_automatic(values: Any) -> bool:
    return values.impostor_use == "automatic"


IMPOSTOR_APPLIES = {
    **{option.name: _is_used for option in IMPOSTOR_OPTIONS if option.name != "impostor_use"},
    **dict.fromkeys(
        (
            "impostor_fresh",
            "impostor_predictor",
            "impostor_limit",
            "impostor_captures",
            "impostor_memory",
            "impostor_fade",
            "impostor_ahead",
        ),
        _is_automatic,
    ),
    "impostor_break_even": _is_automatic,
}
"""What changes nothing with the other choices."""
