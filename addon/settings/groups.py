"""What a render is asked to do: frozen dataclasses, checked on creation. The only place where defaults are written."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field

from ..maths.choices import FitChoice, PartitionChoice, WarpChoice
from ..maths.domains import one_of, require, require_fields, within
from ..maths.relief.settings import ImpostorSettings
from .lighting import LightsChoice
from .shadowing import SHADOW_TESTS
from .sky import SkyChoice
from .stage import EdgeLines, GroundChoice, SectionChoice

TESTS = tuple(SHADOW_TESTS)
BIASES = ("automatic", "constant", "slope-scaled", "normal-offset", "receiver-plane")
PCF_COUNTS = (1, 4, 9, 16, 25)
SMOOTHINGS = (1, 5, 9, 13)
SAMPLE_COUNTS = (1, 4, 9, 16)
CASTERS = ("full", "live", "coarse")
FILTER_UNITS = ("texel", "pixel", "metre")
DISPLAYS = ("shaded", "shadow", "aliasing", "partitions")
LONGEST_M = 1e9
BRIGHTEST = 100.0


@dataclass(frozen=True, slots=True)
class ShadowTestChoice:
    """How a receiver is compared with the map: `kind` one of `shadowing.SHADOW_TESTS`.

    `depths` n of the n-SM (SMMVP §4.5); `pcf` k of PCF(k, n). `bias` in metres of light depth for 'constant', in texel footprints for
    'slope-scaled', 'normal-offset' and 'receiver-plane' (None: that strategy's usual value; 'automatic' needs none). `epsilon`,
    `epsilon_far` (IDD §5.4) in metres, None = automatic per pixel. `id_per_material`: faces of different material slots get different ids.
    `filter_width` is the width of the filter's square of k taps, in `filter_unit`: texels of the map (its softness follows the warp),
    pixels of the picture, or metres across the light's ray (both independent of the warp); None = one unit per tap (metres: must be given).
    `smoothing`: the places of a camera sample's footprint that the triangle test tests where a shadow's edge may pass.
    `outlines`: the triangle test also looks for triangles whose edges cross the texels round the place (thin parts far away).
    `casters` 'coarse': maps are drawn with coarser meshes whose error is at most `caster_error` of their texels, and name the triangles of
    the meshes themselves, which the test then tests; 'live': only in the live view, as soon as they are made; 'full': never.
    """

    kind: str = one_of("triangle", "Shadow test", TESTS)
    depths: int = within(1, "The number of depths per cell (n-SM)", 1, 8)
    pcf: int = one_of(1, "The number of samples of PCF", PCF_COUNTS)
    bias_strategy: str = one_of("automatic", "Bias strategy", BIASES)
    bias: float | None = within(None, "The bias", 0.0, LONGEST_M)
    epsilon: float | None = within(None, "epsilon (metres)", 0.0, LONGEST_M)
    epsilon_far: float | None = within(None, "epsilon_far (metres)", 0.0, LONGEST_M)
    id_per_material: bool = False
    filter_unit: str = one_of("texel", "Filter unit", FILTER_UNITS)
    filter_width: float | None = within(None, "The filter's width", 1e-6, 1e6)
    outlines: bool = False
    smoothing: int = one_of(5, "The smoothing of shadow edges", SMOOTHINGS)
    casters: str = one_of("live", "Casters", CASTERS)
    caster_error: float = within(1.0, "The casters' error (texels)", 0.0, 1.0)

    def __post_init__(self) -> None:
        require_fields(self)
        require(self.filter_width is not None or self.filter_unit != "metre", "A filter in metres needs its width.")
        test = SHADOW_TESTS[self.kind]
        require(
            self.depths == 1 or "depths" in test.options,
            f"The {self.kind} test stores {test.stored.words}, not depths: set the depths per cell to 1.",
        )

    @property
    def places(self) -> int:
        """The most places of a sample's footprint that are tested: `smoothing` where the test has it and no filter is chosen."""
        return self.smoothing if "smoothing" in SHADOW_TESTS[self.kind].options and self.pcf == 1 else 1

    @property
    def has_outlines(self) -> bool:
        """Whether the maps keep the triangles of outlines: only where the test asks for them."""
        return self.outlines and "outlines" in SHADOW_TESTS[self.kind].options

    def has_coarse_casters(self, is_live: bool) -> bool:
        """Whether maps may be drawn with coarser meshes: only where the test asks for no more than a triangle nearby."""
        return self.casters in (("live", "coarse") if is_live else ("coarse",)) and "casters" in SHADOW_TESTS[self.kind].options


@dataclass(frozen=True, slots=True)
class ShadingChoice:
    """How the picture is lit and what it shows. Colours are linear RGB.

    `ambient_sky`, `ambient_ground` hemispheric ambient light; None is the scene's world. `light_strength` scales all light but that;
    at 1 a light of irradiance E shows a diffuse surface as E·albedo/π. `own_sun` is what a white surface shows that faces a sun which is
    no light of the scene, at a strength of 1. `use_object_colors` False paints all in clay; `display` is what `combined` shows; `samples`
    camera samples per pixel of `combined` (the data passes stay at pixel centres); `background` RGBA behind everything, None the world's;
    `exposure` in stops, of all that `combined` shows.
    """

    ambient_sky: tuple[float, float, float] | None = within(None, "Every number of ambient_sky", 0.0, BRIGHTEST)
    ambient_ground: tuple[float, float, float] | None = within(None, "Every number of ambient_ground", 0.0, BRIGHTEST)
    light_strength: float = within(1.0, "The light strength", 0.0, BRIGHTEST)
    own_sun: float = within(0.85, "The own sun's brightness", 0.0, BRIGHTEST)
    exposure: float = within(0.0, "The exposure (stops)", -20.0, 20.0)
    use_object_colors: bool = True
    clay: tuple[float, float, float] = within((0.6, 0.6, 0.6), "Every number of clay", 0.0, 1.0)
    background: tuple[float, float, float, float] | None = within(None, "Every number of background", 0.0, BRIGHTEST)
    display: str = one_of("shaded", "Display", DISPLAYS)
    samples: int = one_of(4, "The number of camera samples per pixel", SAMPLE_COUNTS)

    def __post_init__(self) -> None:
        require_fields(self)

    def under(self, world: ShadingWorld) -> ShadingChoice:
        """The choice with `world` in the place of what is left to the scene."""
        return dataclasses.replace(
            self,
            ambient_sky=world.sky if self.ambient_sky is None else self.ambient_sky,
            ambient_ground=world.ground if self.ambient_ground is None else self.ambient_ground,
            background=world.background if self.background is None else self.background,
        )


@dataclass(frozen=True, slots=True)
class ShadingWorld:
    """What surrounds a scene: the mean radiance of its upper and its lower half, and the colour and opacity behind everything.

    The default surrounds what has no world: CAD files.
    """

    sky: tuple[float, float, float] = (0.32, 0.36, 0.42)
    ground: tuple[float, float, float] = (0.16, 0.15, 0.14)
    background: tuple[float, float, float, float] = (0.78, 0.83, 0.90, 1.0)


@dataclass(frozen=True, slots=True)
class Settings:
    """Everything a render needs beside the scene, the camera and the light."""

    warp: WarpChoice = field(default_factory=WarpChoice)
    partition: PartitionChoice = field(default_factory=PartitionChoice)
    fit: FitChoice = field(default_factory=FitChoice)
    test: ShadowTestChoice = field(default_factory=ShadowTestChoice)
    shading: ShadingChoice = field(default_factory=ShadingChoice)
    lights: LightsChoice = field(default_factory=LightsChoice)
    sky: SkyChoice = field(default_factory=SkyChoice)
    impostor: ImpostorSettings = field(default_factory=ImpostorSettings)
    edges: EdgeLines = field(default_factory=EdgeLines)
    ground: GroundChoice = field(default_factory=GroundChoice)
    section: SectionChoice = field(default_factory=SectionChoice)

    def as_dict(self) -> dict[str, object]:
        """Every effective value, nested, JSON-ready (the report's `settings`)."""
        return dataclasses.asdict(self)

    def replaced(self, **groups: dict[str, object]) -> Settings:
        """A copy with fields changed, group by group: `settings.replaced(fit={"size": 2048}, warp={"kind": "psm"})`."""
        changed = {name: dataclasses.replace(getattr(self, name), **values) for name, values in groups.items()}
        return dataclasses.replace(self, **changed)
