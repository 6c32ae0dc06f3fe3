"""Every option once: its name, the setting it feeds, its range and the words that explain it. No bpy.

Blender's properties (`properties.py`), the command line (`cli_options.py`) and settings files are made from this table.
Defaults, choices and checks stay in the frozen dataclasses of `maths.choices` and `pipeline.settings`; nothing here repeats them.
"""

from __future__ import annotations

from dataclasses import fields

from .errors import SettingsError
from .maths.choices import CONVERGENCES, CUTS, FITS, LOG_WARPS, PARTITIONS, WARPS
from .option import Option, choice
from .option_impostors import IMPOSTOR_APPLIES, IMPOSTOR_OPTIONS
from .option_words import (
    BIAS_WORDS,
    CONVERGENCE_WORDS,
    CUT_WORDS,
    DISPLAY_WORDS,
    FILTER_UNIT_WORDS,
    FIT_WORDS,
    PARTITION_WORDS,
    PCF_WORDS,
    SAMPLE_COUNTS,
    SAMPLE_WORDS,
    TEST_WORDS,
    WARP_WORDS,
)
from .pipeline.settings import BIASES, DISPLAYS, FILTER_UNITS, PCF_COUNTS, TESTS, Settings

OPTIONS: tuple[Option, ...] = (
    choice("warp", "warp", "kind", "Warp", "How texels are spread between near and far", WARPS, WARP_WORDS),
    Option(
        "eta",
        (("warp", "eta"),),
        "number",
        "η",
        "Sets the warp directly: −1 uniform, 0 equal error near and far, 1 strongest (T4 (32), (33))",
        low=-1.0,
        high=1.0,
        start=0.0,
    ),
    Option(
        "warp_parameter",
        (("warp", "parameter"),),
        "number",
        "n'",
        "Sets the warp directly: distance from the apex of the warping pyramid to its near plane; small is strong (T4 (26))",
        low=1e-6,
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
        low=1e-6,
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
        CONVERGENCES,
        CONVERGENCE_WORDS,
    ),
    choice("partition", "partition", "kind", "Partition", "How the view is divided among shadow maps", PARTITIONS, PARTITION_WORDS),
    Option(
        "partitions",
        (("partition", "count"),),
        "count",
        "Partitions",
        "Number of slices in depth, one shadow map each: more are sharper and cost more",
        low=1,
        high=8,
    ),
    choice("cut", "partition", "cut", "Cut", "Which way the borders between slices stand", CUTS, CUT_WORDS),
    Option(
        "split_weight",
        (("partition", "split_weight"),),
        "number",
        "Split Weight",
        "0 linear slices, 1 logarithmic ones (λ, LogPSM 5.60)",
        low=0.0,
        high=1.0,
    ),
    Option(
        "alpha",
        (("partition", "alpha"),),
        "numbers",
        "Seam α",
        "Each slice ends at 1/α of the next one's end when the light runs along the view; 2 to 4 hides the seams best (T4 (55))",
        low=1.001,
        soft=(2.0, 4.0),
    ),
    Option(
        "map_size",
        (("fit", "size"),),
        "count",
        "Map Size",
        "Texels per side of every shadow map: twice as many make the error m a quarter and need four times the memory",
        low=16,
        high=16384,
        soft=(256, 4096),
        unit="texel",
    ),
    choice("fit", "fit", "kind", "Fit", "What the shadow map's texels are spread over", FITS, FIT_WORDS),
    Option(
        "margin",
        (("fit", "margin_texels"),),
        "number",
        "Margin",
        "Texels kept free at the map's border for the filter",
        low=0.0,
        soft=(0.0, 16.0),
        unit="texel",
    ),
    choice("test", "test", "kind", "Shadow Test", "How a surface is compared with the shadow map", TESTS, TEST_WORDS),
    Option(
        "depths",
        (("test", "depths"),),
        "count",
        "Depths per Cell",
        "n-SM: depths each cell of the map holds; more give smoother edges from fewer samples (SMMVP §4.5)",
        low=1,
        high=8,
    ),
    choice(
        "pcf",
        "test",
        "pcf",
        "Filter",
        "Shadow tests averaged per pixel: more give softer, smoother edges (PCF(k, n))",
        PCF_COUNTS,
        PCF_WORDS,
    ),
    choice("filter_unit", "test", "filter_unit", "Filter Unit", "What the filter's width is measured in", FILTER_UNITS, FILTER_UNIT_WORDS),
    Option(
        "filter_width",
        (("test", "filter_width"),),
        "number",
        "Filter Width",
        "Width of the filter, in its unit: wider is softer (automatic: one unit per sample along a side)",
        low=1e-6,
        high=1e6,
        soft=(0.1, 16.0),
        start=3.0,
    ),
    choice("bias_strategy", "test", "bias_strategy", "Bias", "How self-shadowing (acne) is kept away", BIASES, BIAS_WORDS),
    Option(
        "bias",
        (("test", "bias"),),
        "number",
        "Bias Amount",
        "Metres along the light for a constant bias, texels for slope-scaled and "
        "normal offset: too little makes acne, too much detaches shadows",
        low=0.0,
        soft=(0.0, 4.0),
        start=1.0,
    ),
    Option(
        "epsilon",
        (("test", "epsilon"),),
        "number",
        "ε",
        "Depth difference below which nothing is in shadow (IDD §5.4)",
        low=0.0,
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
        low=0.0,
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
    choice("display", "shading", "display", "Show", "What the picture shows", DISPLAYS, DISPLAY_WORDS),
    choice(
        "samples",
        "shading",
        "samples",
        "Samples",
        "Camera samples per pixel: more make the edges of objects smoother",
        SAMPLE_COUNTS,
        SAMPLE_WORDS,
    ),
    Option(
        "light_strength",
        (("shading", "light_strength"),),
        "number",
        "Strength",
        "Scales the light that casts the shadows",
        low=0.0,
        high=100.0,
        soft=(0.0, 4.0),
    ),
    Option(
        "ambient_sky",
        (("shading", "ambient_sky"),),
        "color",
        "Sky",
        "Ambient light on surfaces that look up",
        low=0.0,
        high=100.0,
        soft=(0.0, 1.0),
    ),
    Option(
        "ambient_ground",
        (("shading", "ambient_ground"),),
        "color",
        "Ground",
        "Ambient light on surfaces that look down",
        low=0.0,
        high=100.0,
        soft=(0.0, 1.0),
    ),
    Option(
        "use_object_colors",
        (("shading", "use_object_colors"),),
        "switch",
        "Object Colours",
        "Paint objects in their own colours; off: all in clay",
    ),
    Option("clay", (("shading", "clay"),), "color", "Clay", "The one colour of all objects when their own are off", low=0.0, high=1.0),
    Option(
        "background",
        (("shading", "background"),),
        "color",
        "Background",
        "Colour and opacity behind everything",
        low=0.0,
        high=100.0,
        soft=(0.0, 1.0),
    ),
    *IMPOSTOR_OPTIONS,
)
BY_NAME: dict[str, Option] = {option.name: option for option in OPTIONS}


def with_options(settings: Settings, values: dict[str, object]) -> Settings:
    """A copy of `settings` with the options of `values` (by name, None = automatic) put in place; checks everything at once.

    Raises `SettingsError` for an unknown name, a value of the wrong type, or one out of range.
    """
    groups: dict[str, dict[str, object]] = {}
    for name, value in values.items():
        if name not in BY_NAME:
            raise SettingsError(f"There is no setting '{name}': choose one of {', '.join(BY_NAME)}.")
        for group, field in BY_NAME[name].targets:
            groups.setdefault(group, {})[field] = typed(BY_NAME[name], value)
    return settings.replaced(**groups)


def typed(option: Option, value: object) -> object:
    """`value` in the type that the option's dataclass field wants; raises `SettingsError` when it is of another kind."""
    if value is None and option.is_optional:
        return None
    try:
        if option.kind == "choice":
            return type(option.default)(value)
        if option.kind == "switch" and isinstance(value, bool):
            return value
        if option.kind == "count" and int(value) == value and not isinstance(value, bool):
            return int(value)
        if option.kind == "number" and not isinstance(value, bool):
            return float(value)
        if option.kind == "numbers":
            return tuple(float(v) for v in (value if isinstance(value, list | tuple) else (value,)))
        if option.kind == "color" and len(value) == len(option.default):
            return tuple(float(v) for v in value)
    except (TypeError, ValueError):
        pass
    raise SettingsError(f"'{value}' is not a value for '{option.name}' ({option.kind}).")


def values_of(settings: Settings) -> dict[str, object]:
    """The options' values in `settings`, by name: the inverse of `with_options` on the defaults."""
    return {option.name: getattr(getattr(settings, option.targets[0][0]), option.targets[0][1]) for option in OPTIONS}


def unreached_fields() -> set[tuple[str, str]]:
    """The (group, field) pairs of `Settings` that no option feeds; a test keeps it empty."""
    everything = {(group.name, field.name) for group in fields(Settings) for field in fields(getattr(Settings(), group.name))}
    return everything - {target for option in OPTIONS for target in option.targets}


def applies(name: str, values: object) -> bool:
    """Whether option `name` changes anything, given the other options as attributes of `values`; panels hide what does not."""
    rule = _APPLIES.get(name)
    return True if rule is None else rule(values)


def unsuited(name: str, identifier: str, light_type: str | None) -> str | None:
    """Why choosing `identifier` for option `name` means nothing under a light of Blender's type 'SUN', 'SPOT' or 'POINT'; None if it does.

    `light_type` None: there is no light, a sun will be made.
    """
    if light_type not in _FINITE:
        return None
    kind = light_type.capitalize()
    if name == "warp" and identifier in LOG_WARPS:
        return f"{kind} light: drawn as a perspective warp, a logarithm needs a sun"
    if name == "partition" and light_type == "POINT" and identifier != "none":
        return "Point light: six maps, one for each side of a cube, not divided further"
    if name == "partition" and identifier.startswith("faces"):
        return f"{kind} light: divided in depth only, faces need a sun"
    return None


_FADING = ("lispsm-general", "log", "logpsm")
_FINITE = ("SPOT", "POINT")
_APPLIES = {
    "eta": lambda v: v.warp != "uniform",
    "warp_parameter": lambda v: v.warp != "uniform",
    "pseudo_near": lambda v: v.warp != "uniform" or v.partition == "z-pseudo-near",
    "convergence": lambda v: v.warp in _FADING,
    "partitions": lambda v: v.partition not in ("none", "faces"),
    "cut": lambda v: v.partition not in ("none", "faces", "faces-z") and v.partitions > 1,
    "split_weight": lambda v: v.partition == "z-pssm",
    "alpha": lambda v: v.partition == "z-adaptive" and v.partitions > 1,
    "depths": lambda v: v.test != "triangle",
    "filter_unit": lambda v: str(v.pcf) != "1",
    "filter_width": lambda v: str(v.pcf) != "1",
    "bias_strategy": lambda v: v.test == "depth",
    "bias": lambda v: v.test == "depth" and v.bias_strategy != "automatic",
    "epsilon": lambda v: v.test == "id-depth",
    "epsilon_far": lambda v: v.test != "depth",
    "id_per_material": lambda v: v.test == "id-depth",
    "clay": lambda v: not v.use_object_colors,
    **IMPOSTOR_APPLIES,
}
