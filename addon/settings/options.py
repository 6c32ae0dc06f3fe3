"""Every option once: its name, the setting it feeds and the words that explain it. No bpy.

Blender's properties (`blender/properties.py`), the command line (`cli/parser.py`) and settings files are made from this table.
Defaults, ranges, choices and checks stay in the frozen dataclasses of `maths.choices` and `settings.groups`; nothing here repeats them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..errors import SettingsError
from ..maths.partitioning import PARTITION_SCHEMES
from ..maths.warping import WARP_METHODS
from .groups import Settings, ShadingWorld, ShadowTestChoice
from .impostor_options import IMPOSTOR_OPTIONS
from .light_options import LIGHT_OPTIONS
from .option import Option, choice, words_of
from .shadowing import SHADOW_TESTS
from .sky_options import SKY_OPTIONS
from .stage_options import STAGE_OPTIONS
from .words import (
    BIAS_WORDS,
    CASTER_WORDS,
    CONVERGENCE_WORDS,
    CUT_WORDS,
    DISPLAY_WORDS,
    FILTER_UNIT_WORDS,
    FIT_WORDS,
    PCF_WORDS,
    SAMPLE_WORDS,
    SMOOTHING_WORDS,
)

OPTIONS: tuple[Option, ...] = (
    choice("warp", "warp", "kind", "Warp", "How texels are spread between near and far", words_of(WARP_METHODS)),
    Option(
        "eta",
        (("warp", "eta"),),
        "number",
        "η",
        "Sets the warp directly: −1 uniform, 0 equal error near and far, 1 strongest (T4 (32), (33))",
        start=0.0,
    ),
    Option(
        "warp_parameter",
        (("warp", "parameter"),),
        "number",
        "n'",
        "Sets the warp directly: distance from the apex of the warping pyramid to its near plane; small is strong (T4 (26))",
        soft=(0.01, 1e4),
        unit="m",
        start=1.0,
    ),
    Option(
        "pseudo_near",
        (("warp", "pseudo_near"), ("partition", "pseudo_near")),
        "number",
        "Pseudo-Near",
        "View depth from which shadows shall be sharp; nearer ones may be coarser (LogPSM §5.1.8, 5.64)",
        soft=(0.01, 1e4),
        unit="m",
        start=1.0,
    ),
    choice(
        "convergence",
        "warp",
        "convergence",
        "Fading",
        "How the warp fades to uniform as the light turns into the view's direction, below γ_lim",
        CONVERGENCE_WORDS,
    ),
    Option(
        "log_bend",
        (("warp", "log_bend"),),
        "number",
        "Log Bend",
        "0: texels grow evenly along the view; above: more of them near the eye; below: more far away (1/b of LogPSM 5.47)",
        soft=(-0.9, 4.0),
    ),
    choice("partition", "partition", "kind", "Partition", "How the view is divided among shadow maps", words_of(PARTITION_SCHEMES)),
    Option(
        "partitions",
        (("partition", "count"),),
        "count",
        "Partitions",
        "Number of slices in depth, one shadow map each: more are sharper and cost more",
    ),
    choice("cut", "partition", "cut", "Cut", "Which way the borders between slices stand", CUT_WORDS),
    Option(
        "split_weight",
        (("partition", "split_weight"),),
        "number",
        "Split Weight",
        "0 linear slices, 1 logarithmic ones (λ, LogPSM 5.60)",
    ),
    Option(
        "alpha",
        (("partition", "alpha"),),
        "numbers",
        "Seam α",
        "Each slice ends at 1/α of the next one's end when the light runs along the view; 2 to 4 hides the seams best (T4 (55)). "
        "Automatic: 3 with the cut across the view, logarithmic slices along the light",
        soft=(2.0, 4.0),
        start=3.0,
    ),
    Option(
        "map_size",
        (("fit", "size"),),
        "count",
        "Map Size",
        "Texels per side of every shadow map: twice as many make the error m a quarter and need four times the memory",
        soft=(256, 4096),
        unit="texel",
    ),
    choice("fit", "fit", "kind", "Fit", "What the shadow map's texels are spread over", FIT_WORDS),
    Option(
        "margin",
        (("fit", "margin_texels"),),
        "number",
        "Margin",
        "Texels kept free at the map's border for the filter",
        soft=(0.0, 16.0),
        unit="texel",
    ),
    choice("test", "test", "kind", "Shadow Test", "How a surface is compared with the shadow map", words_of(SHADOW_TESTS)),
    Option(
        "depths",
        (("test", "depths"),),
        "count",
        "Depths per Cell",
        "n-SM: depths each cell of the map holds; more give smoother edges from fewer samples (SMMVP §4.5)",
    ),
    choice(
        "pcf",
        "test",
        "pcf",
        "Filter",
        "Shadow tests averaged per pixel: more give softer, smoother edges (PCF(k, n))",
        PCF_WORDS,
    ),
    choice("filter_unit", "test", "filter_unit", "Filter Unit", "What the filter's width is measured in", FILTER_UNIT_WORDS),
    Option(
        "filter_width",
        (("test", "filter_width"),),
        "number",
        "Filter Width",
        "Width of the filter, in its unit: wider is softer (automatic: one unit per sample along a side)",
        soft=(0.1, 16.0),
        start=3.0,
    ),
    choice("bias_strategy", "test", "bias_strategy", "Bias", "How self-shadowing (acne) is kept away", BIAS_WORDS),
    Option(
        "bias",
        (("test", "bias"),),
        "number",
        "Bias Amount",
        "Metres along the light for a constant bias, texels for slope-scaled and "
        "normal offset: too little makes acne, too much detaches shadows",
        soft=(0.0, 4.0),
        start=1.0,
    ),
    Option(
        "epsilon",
        (("test", "epsilon"),),
        "number",
        "ε",
        "Depth difference below which nothing is in shadow (IDD §5.4)",
        soft=(0.0, 1.0),
        unit="m",
        start=0.001,
    ),
    Option(
        "epsilon_far",
        (("test", "epsilon_far"),),
        "number",
        "ε far",
        "Depth difference above which everything is in shadow, whatever its number (IDD §5.4)",
        soft=(0.0, 10.0),
        unit="m",
        start=0.1,
    ),
    Option(
        "id_per_material",
        (("test", "id_per_material"),),
        "switch",
        "ID per Material",
        "Faces of different material slots of one object count as different objects in the ID test",
    ),
    Option(
        "outlines",
        (("test", "outlines"),),
        "switch",
        "Thin Parts",
        "The exact test also finds parts too thin for the map's texels, by drawing the outlines of all triangles once more: slower",
    ),
    choice(
        "smoothing",
        "test",
        "smoothing",
        "Smooth Edges",
        "How smooth the edges of shadows are: the exact test is done several times for a pixel, but only where an edge passes",
        SMOOTHING_WORDS,
    ),
    choice("casters", "test", "casters", "Casters", "Which meshes the exact test's maps are drawn with", CASTER_WORDS),
    Option(
        "caster_error",
        (("test", "caster_error"),),
        "number",
        "Caster Error",
        "How far coarser meshes may lie from what they stand for: a texel at most, since the test looks a texel round each place",
        unit="texel",
    ),
    choice("display", "shading", "display", "Show", "What the picture shows", DISPLAY_WORDS),
    choice(
        "samples",
        "shading",
        "samples",
        "Samples",
        "Camera samples per pixel: more make the edges of objects smoother",
        SAMPLE_WORDS,
    ),
    Option(
        "light_strength",
        (("shading", "light_strength"),),
        "number",
        "Strength",
        "Scales the light that casts the shadows; at 1 lights are as bright as Cycles and EEVEE show them",
        soft=(0.0, 4.0),
    ),
    Option(
        "own_sun",
        (("shading", "own_sun"),),
        "number",
        "Own Sun",
        "How bright a white surface looks that faces a sun which is no light of the scene: one made up, or given by a direction or a time",
        soft=(0.0, 4.0),
    ),
    Option(
        "exposure",
        (("shading", "exposure"),),
        "number",
        "Exposure",
        "Brightness of the whole picture in stops: 1 is twice as bright, −1 half as bright; beside the exposure in Color Management",
        soft=(-4.0, 4.0),
    ),
    Option(
        "ambient_sky",
        (("shading", "ambient_sky"),),
        "color",
        "Sky",
        "Ambient light on surfaces that look up (automatic: the scene's world)",
        soft=(0.0, 1.0),
        start=ShadingWorld().sky,
    ),
    Option(
        "ambient_ground",
        (("shading", "ambient_ground"),),
        "color",
        "Ground",
        "Ambient light on surfaces that look down (automatic: the scene's world)",
        soft=(0.0, 1.0),
        start=ShadingWorld().ground,
    ),
    Option(
        "use_object_colors",
        (("shading", "use_object_colors"),),
        "switch",
        "Object Colours",
        "Paint objects in their own colours; off: all in clay",
    ),
    Option("clay", (("shading", "clay"),), "color", "Clay", "The one colour of all objects when their own are off"),
    Option(
        "background",
        (("shading", "background"),),
        "color",
        "Background",
        "Colour and opacity behind everything (automatic: the scene's world)",
        soft=(0.0, 1.0),
        start=ShadingWorld().background,
    ),
    *LIGHT_OPTIONS,
    *SKY_OPTIONS,
    *STAGE_OPTIONS,
    *IMPOSTOR_OPTIONS,
)
PLAIN_TEST = SHADOW_TESTS["depth"]
BY_NAME: dict[str, Option] = {option.name: option for option in OPTIONS}


FROM_SCENE = "scene"
"""What a colour is called that is left to the scene's world."""


def with_options(settings: Settings, values: dict[str, object]) -> Settings:
    """A copy of `settings` with the options of `values` (by name, None = automatic) put in place; checks everything at once.

    Raises `SettingsError` for an unknown name, a value of the wrong type, or one out of range.
    """
    groups: dict[str, dict[str, object]] = {}
    for name, value in with_its_test(values, "test", settings).items():
        if name not in BY_NAME:
            raise SettingsError(f"There is no setting '{name}': choose one of {', '.join(BY_NAME)}.")
        for group, field in BY_NAME[name].targets:
            groups.setdefault(group, {})[field] = typed(BY_NAME[name], value)
    return settings.replaced(**groups)


def with_its_test(values: Mapping[str, object], key: str, settings: Settings) -> dict[str, object]:
    """`values`, and under `key` the depth test where only it has what they set (an n-SM, a bias) and nobody has chosen another.

    It was the default: what was written for it goes on to mean it.
    """
    set_by_hand = {name for name in values if name in PLAIN_TEST.options and values[name] not in (None, BY_NAME[name].default)}
    is_asked = key not in values and settings.test.kind == ShadowTestChoice().kind
    return dict(values) | ({key: PLAIN_TEST.name} if is_asked and set_by_hand - SHADOW_TESTS[settings.test.kind].options else {})


def typed(option: Option, value: object) -> object:
    """`value` in the type that the option's dataclass field wants; raises `SettingsError` when it is of another kind."""
    if value is None and option.is_optional:
        return None
    try:
        return _CONVERTERS[option.kind](option, value)
    except (TypeError, ValueError, OverflowError) as error:
        raise SettingsError(f"'{value}' is not a value for '{option.name}' ({option.kind}).") from error


def _choice(option: Option, value: Any) -> object:
    return type(option.default)(value)


def _switch(option: Option, value: object) -> bool:
    if not isinstance(value, bool):
        raise TypeError(value)
    return value


def _count(option: Option, value: Any) -> int:
    if isinstance(value, bool) or int(value) != value:
        raise TypeError(value)
    return int(value)


def _number(option: Option, value: Any) -> float:
    if isinstance(value, bool):
        raise TypeError(value)
    return float(value)


def _numbers(option: Option, value: object) -> tuple[float, ...]:
    return tuple(float(v) for v in (value if isinstance(value, list | tuple) else (value,)))


def _color(option: Option, value: Any) -> tuple[float, ...] | None:
    if option.is_optional and value == FROM_SCENE:
        return None
    if len(value) != option.width:
        raise ValueError(value)
    return tuple(float(v) for v in value)


_CONVERTERS = {"choice": _choice, "switch": _switch, "count": _count, "number": _number, "numbers": _numbers, "color": _color}


def values_of(settings: Settings) -> dict[str, object]:
    """The options' values in `settings`, by name: the inverse of `with_options` on the defaults."""
    return {option.name: getattr(getattr(settings, option.targets[0][0]), option.targets[0][1]) for option in OPTIONS}
