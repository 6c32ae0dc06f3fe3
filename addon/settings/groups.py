"""What a render is asked to do: frozen dataclasses, checked on creation. The only place where defaults are written."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from math import degrees

from ..maths.choices import FitChoice, PartitionChoice, WarpChoice, require, require_choice, require_types
from ..maths.relief.frame import CaptureChoice
from ..maths.relief.life import LIMITS, LifeSettings

TESTS = ("depth", "id-depth", "triangle")
BIASES = ("automatic", "constant", "slope-scaled", "normal-offset", "receiver-plane")
PCF_COUNTS = (1, 4, 9, 16, 25)
FILTER_UNITS = ("texel", "pixel", "metre")
PASSES = ("combined", "shadow", "depth", "normal", "object", "partition", "aliasing", "texel")
DISPLAYS = ("shaded", "shadow", "aliasing", "partitions")
IMPOSTOR_USES = ("automatic", "manual", "off")
IMPOSTOR_PROJECTIONS = ("perspective", "orthographic")
IMPOSTOR_WARPS = ("inverse", "forward")
IMPOSTOR_CASTERS = ("geometry", "impostor")
LONGEST_M = 1e9
BRIGHTEST = 100.0
_LIFE, _CAPTURE = LifeSettings(), CaptureChoice()


@dataclass(frozen=True, slots=True)
class TestChoice:
    """How a receiver is compared with the map.

    `depths` n of the n-SM (SMMVP §4.5); `pcf` k of PCF(k, n). `bias` in metres of light depth for 'constant', in texel footprints for
    'slope-scaled', 'normal-offset' and 'receiver-plane' (None: that strategy's usual value; 'automatic' needs none). `epsilon`,
    `epsilon_far` (IDD §5.4) in metres, None = automatic per pixel. `id_per_material`: faces of different material slots get different ids.
    `filter_width` is the width of the filter's square of k taps, in `filter_unit`: texels of the map (its softness follows the warp),
    pixels of the picture, or metres across the light's ray (both independent of the warp); None = one unit per tap (metres: must be given).
    `outlines`: the triangle test also looks for triangles whose edges cross the texels round the place (thin parts far away).
    """

    __test__ = False  # not a pytest class

    kind: str = "depth"
    depths: int = 1
    pcf: int = 1
    bias_strategy: str = "automatic"
    bias: float | None = None
    epsilon: float | None = None
    epsilon_far: float | None = None
    id_per_material: bool = False
    filter_unit: str = "texel"
    filter_width: float | None = None
    outlines: bool = False

    def __post_init__(self) -> None:
        require_types(self)
        require_choice("Shadow test", self.kind, TESTS)
        require_choice("Bias strategy", self.bias_strategy, BIASES)
        require(1 <= self.depths <= 8, "The number of depths per cell (n-SM) must lie between 1 and 8.")
        require(self.pcf in PCF_COUNTS, "PCF takes 1, 4, 9, 16 or 25 samples.")
        for name in ("bias", "epsilon", "epsilon_far"):
            value = getattr(self, name)
            require(value is None or 0.0 <= value <= LONGEST_M, f"{name} must be a distance from 0 to {LONGEST_M:g} m.")
        require_choice("Filter unit", self.filter_unit, FILTER_UNITS)
        require(self.filter_width is None or 0.0 < self.filter_width < 1e6, "The filter's width must be greater than 0.")
        require(self.filter_width is not None or self.filter_unit != "metre", "A filter in metres needs its width.")
        require(
            self.kind != "triangle" or self.depths == 1, "The triangle test stores triangles, not depths: set the depths per cell to 1."
        )

    @property
    def has_outlines(self) -> bool:
        """Whether the maps keep the triangles of outlines: only the triangle test asks for them."""
        return self.outlines and self.kind == "triangle"


@dataclass(frozen=True, slots=True)
class ShadingChoice:
    """How the picture is lit and what it shows. Colours are linear RGB.

    `ambient_sky`, `ambient_ground` hemispheric ambient light; `light_strength` scales the light; `use_object_colors` False paints all
    in clay; `display` is what `combined` shows; `samples` camera samples per pixel of `combined` (the data passes stay at pixel centres);
    `background` RGBA behind everything.
    """

    ambient_sky: tuple[float, float, float] = (0.32, 0.36, 0.42)
    ambient_ground: tuple[float, float, float] = (0.16, 0.15, 0.14)
    light_strength: float = 0.85
    use_object_colors: bool = True
    clay: tuple[float, float, float] = (0.6, 0.6, 0.6)
    background: tuple[float, float, float, float] = (0.78, 0.83, 0.90, 1.0)
    display: str = "shaded"
    samples: int = 4

    def __post_init__(self) -> None:
        require_types(self)
        require_choice("Display", self.display, DISPLAYS)
        for name in ("ambient_sky", "ambient_ground", "clay", "background"):
            usable = all(0.0 <= c <= BRIGHTEST for c in getattr(self, name))
            require(usable, f"Every number of {name} must lie between 0 and {BRIGHTEST:g}.")
        require(0.0 <= self.light_strength <= BRIGHTEST, "The light strength must lie between 0 and 100.")
        require(self.samples in (1, 4, 9, 16), "Camera samples per pixel: 1, 4, 9 or 16.")


@dataclass(frozen=True, slots=True)
class ImpostorSettings:
    """How objects marked as impostors are captured, drawn and renewed (RI; `maths/relief/life.py`, `maths/relief/frame.py`).

    `use` 'automatic': the life cycle renews them; 'manual': the user does; 'off': all is drawn as geometry. `fresh`: every final render
    captures anew, so that a picture does not depend on those before it. `limit` of the `predictor`, in its unit (None: its usual one).
    `sprite_px` pixels of Schaufler's β up to which they are shown unwarped; `ahead` the share of the limit that a capture made ahead of a
    moving view may be wrong by.
    `max_tilt_deg` beyond which an impostor is renewed in any case. `regenerations` per picture of a view, `memory_mib` for all textures.
    `break_even`: what is cheaper as geometry is drawn as geometry ('automatic'). `views` captures are drawn together, the last ones or,
    with `directions` n > 0, those nearest of n × n directions round the object. `fill`: what lay hidden at capture is taken to go on.
    `casters` 'impostor': what is drawn as impostor casts its shadow as one.
    """

    use: str = "automatic"
    fresh: bool = True
    projection: str = "perspective"
    back_layer: bool = True
    warp: str = "inverse"
    predictor: str = _LIFE.predictor
    limit: float | None = _LIFE.limit
    texels_per_pixel: float = 2.0
    max_texels: int = _CAPTURE.max_texels
    max_tilt_deg: float = round(degrees(_LIFE.max_tilt_rad), 6)
    regenerations: int = _LIFE.regenerations
    memory_mib: int = _LIFE.memory_bytes >> 20
    sprite_px: float = _LIFE.sprite_px
    ahead: float = _LIFE.ahead
    fade_frames: int = _LIFE.fade_frames
    break_even: bool = True
    views: int = 1
    directions: int = 0
    fill: bool = True
    casters: str = "geometry"

    def __post_init__(self) -> None:
        require_types(self)
        require_choice("Impostors", self.use, IMPOSTOR_USES)
        require_choice("Impostor projection", self.projection, IMPOSTOR_PROJECTIONS)
        require_choice("Impostor warp", self.warp, IMPOSTOR_WARPS)
        require_choice("Impostor predictor", self.predictor, tuple(LIMITS))
        require(self.limit is None or 0.0 < self.limit < 1e12, "The impostors' error limit must be positive.")
        require(0.125 <= self.texels_per_pixel <= 8.0, "Impostor texels per pixel must lie between 1/8 and 8.")
        require(16 <= self.max_texels <= 8192, "The largest impostor texture must lie between 16 and 8192 texels.")
        require(0.0 < self.max_tilt_deg <= 85.0, "The impostors' largest tilt must lie above 0° and not above 85°.")
        require(0 <= self.regenerations <= 10000, "Impostor captures per picture: 0 to 10000.")
        require(1 <= self.memory_mib <= 1 << 20, "The impostors' texture memory must be 1 MiB or more.")
        require(0.0 <= self.sprite_px <= 16.0, "The pixels up to which an impostor is a sprite must lie between 0 and 16.")
        require(0.0 <= self.ahead <= 0.95, "The share of the limit for captures ahead must lie between 0 and 0.95.")
        require(0 <= self.fade_frames <= 60, "The impostors' crossfade takes 0 to 60 pictures.")
        require_choice("Impostor casters", self.casters, IMPOSTOR_CASTERS)
        require(1 <= self.views <= 4, "1 to 4 captures of an impostor can be drawn together.")
        require(0 <= self.directions <= 64, "The directions of an impostor per side: 0 (none) to 64.")


@dataclass(frozen=True, slots=True)
class Settings:
    """Everything a render needs beside the scene, the camera and the light."""

    warp: WarpChoice = field(default_factory=WarpChoice)
    partition: PartitionChoice = field(default_factory=PartitionChoice)
    fit: FitChoice = field(default_factory=FitChoice)
    test: TestChoice = field(default_factory=TestChoice)
    shading: ShadingChoice = field(default_factory=ShadingChoice)
    impostor: ImpostorSettings = field(default_factory=ImpostorSettings)

    def as_dict(self) -> dict[str, object]:
        """Every effective value, nested, JSON-ready (the report's `settings`)."""
        return dataclasses.asdict(self)

    def replaced(self, **groups: dict[str, object]) -> Settings:
        """A copy with fields changed, group by group: `settings.replaced(fit={"size": 2048}, warp={"kind": "psm"})`."""
        changed = {name: dataclasses.replace(getattr(self, name), **values) for name, values in groups.items()}
        return dataclasses.replace(self, **changed)
