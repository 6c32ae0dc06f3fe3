"""The one record of what is chosen for relief impostors: read by their maths, the renderer, the options and the doors."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians

from ..domains import one_of, require_fields, within

USES = ("automatic", "manual", "off")
PROJECTIONS = ("perspective", "orthographic")
WARPS = ("inverse", "forward")
CASTERS = ("geometry", "impostor")
LIMITS = {
    "critical": 200.0,
    "critical_px": 12.0,
    "regions_sum": 800.0,
    "regions_max": 200.0,
    "regions_sum_px": 60.0,
    "regions_max_px": 12.0,
    "regions_share": 0.6,
    "edge_written_px": 1000.0,
    "edge_sum_px": 0.0165,
    "edge_fast_px": 0.0165,
}
"""The usual limit of every predictor in its own unit; the edge sums are judged as a share of the pixels that the impostor covers."""
ALL_AT_ONCE = 10000
"""More captures than there are impostors in any picture."""


@dataclass(frozen=True, slots=True)
class ImpostorSettings:
    """How objects marked as impostors are captured, drawn and renewed (RI; `life.py`, `frame.py`).

    `use` 'automatic': the life cycle renews them; 'manual': the user does; 'off': all is drawn as geometry. `fresh`: every final render
    captures anew, so that a picture does not depend on those before it. `projection` 'perspective': captured by rays from the camera's own
    eye (the warp is the identity there); 'orthographic' as in RI. `warp` 'inverse' follows view rays, 'forward' is the texts' pre-warp.
    `limit` of the `predictor`, in its unit (None: its usual one), decides the second critical moment. `texels_per_pixel` of the screen at
    capture; `max_texels` upper bound of either side (above it the texels grow).
    `max_tilt_deg` beyond which an impostor is renewed in any case. `regenerations` per picture of a view, `memory_mib` for all textures.
    A sprite is kept while β ≤ `sprite_px` pixels (RI: 1; docs/laboratory.md says what that costs on thin parts). `ahead`: for an eye that
    moves on steadily, a capture is made from where the eye will be; this share of the limit is what it may be wrong by until then (0: from
    where the eye is, as RI; `ahead.py`). `fade_frames` of crossfade after a renewal (0: the old texture, whose error was at the limit, is
    never mixed in; the jump measured is small, docs/impostors.md).
    `break_even`: what is cheaper as geometry is drawn as geometry ('automatic'). `views` captures at most are drawn together, where one
    alone is over the limit: the last ones or, with `directions` n > 0, those nearest of n × n directions round the object, which are
    captured when first needed and kept. `fill`: what lay hidden behind a nearer part at capture is taken to go on there.
    `casters` 'impostor': what is drawn as impostor casts its shadow as one.
    """

    use: str = one_of("automatic", "Impostors", USES)
    fresh: bool = True
    projection: str = one_of("perspective", "Impostor projection", PROJECTIONS)
    back_layer: bool = True
    warp: str = one_of("inverse", "Impostor warp", WARPS)
    predictor: str = one_of("edge_fast_px", "Impostor predictor", tuple(LIMITS))
    limit: float | None = within(None, "The impostors' error limit", 1e-6, 1e9)
    texels_per_pixel: float = within(2.0, "Impostor texels per pixel", 0.125, 8.0)
    max_texels: int = within(1024, "The largest impostor texture (texels)", 16, 8192)
    max_tilt_deg: float = within(45.0, "The impostors' largest tilt (degrees)", 1.0, 85.0)
    regenerations: int = within(1, "The impostors captured per picture", 0, ALL_AT_ONCE)
    memory_mib: int = within(1024, "The impostors' texture memory (MiB)", 1, 1 << 20)
    sprite_px: float = within(0.2, "The pixels up to which an impostor is a sprite", 0.0, 16.0)
    ahead: float = within(0.75, "The share of the limit for captures ahead", 0.0, 0.95)
    fade_frames: int = within(0, "The impostors' crossfade (pictures)", 0, 60)
    break_even: bool = True
    views: int = within(1, "The captures of an impostor that are drawn together", 1, 4)
    directions: int = within(0, "The directions of an impostor per side (0: none)", 0, 64)
    fill: bool = True
    casters: str = one_of("geometry", "Impostor casters", CASTERS)

    def __post_init__(self) -> None:
        require_fields(self)

    @property
    def is_perspective(self) -> bool:
        """Whether captures are made by rays from the camera's eye."""
        return self.projection == "perspective"

    @property
    def max_tilt_rad(self) -> float:
        """The largest tilt in radians."""
        return radians(self.max_tilt_deg)

    @property
    def memory_bytes(self) -> int:
        """The memory of all textures in bytes."""
        return self.memory_mib << 20

    @property
    def effective_limit(self) -> float:
        """The limit in the predictor's unit."""
        return LIMITS[self.predictor] if self.limit is None else self.limit


USUAL = ImpostorSettings()
"""What holds unless something else is chosen."""
