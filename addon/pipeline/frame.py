"""What a render gives back: images (row 0 at the top) and numbers. Data only."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field

import numpy as np

from ..maths.relief.beta import Betas
from ..maths.relief.edges import ReliefEdges
from ..maths.shadow.projection import ShadowPlan


@dataclass(frozen=True, eq=False)
class Frame:
    """One rendered view.

    `passes` holds the images asked for, by their names: combined (h, w, 4), shadow (h, w), depth (h, w) view depth or inf,
    normal (h, w, 3) world, object (h, w) int32, partition (h, w) int32, aliasing (h, w, 3), and with 'texel' shadow_depth (k, N, N).
    `plan` the shadow projections used (None when there was no light); `timing_ms` and `geometry` as in the report;
    `gl` {"renderer", "version"}; `measured` the error statistics (maths.error.aliasing.aliasing_statistics).
    `impostors` one `ImpostorReport` per impostor asked for, `lights` one `LightReport` per light. `view_depth` (h, w), 0 where nothing is
    seen, where the job keeps it.
    """

    passes: dict[str, np.ndarray]
    plan: ShadowPlan | None
    timing_ms: dict[str, float | None]
    geometry: dict[str, float]
    gl: dict[str, str]
    measured: dict[str, object] | None
    warnings: tuple[str, ...] = field(default=())
    impostors: tuple[ImpostorReport, ...] = field(default=())
    view_depth: np.ndarray | None = None
    lights: tuple[LightReport, ...] = field(default=())


@dataclass(frozen=True, slots=True)
class LightReport:
    """One light of one frame. `strength` mean of its colour's channels; `samples` hard lights that stood for it; `ms` they took, None where
    nobody measured; `error` the standard error of its part of the picture, root mean square over pixels and channels, from the spread of
    its batches of samples: an upper bound, as even samples err less than independent ones. 0 of a hard light, None where unknown."""

    name: str
    kind: str
    strength: float | None
    samples: int
    ms: float | None = None
    error: float | None = None


@dataclass(frozen=True, eq=False)
class ImpostorReport:
    """One impostor in one frame. `errors` every predictor by name, as the frame found them (empty without a texture); `error` the error of
    what is shown now in the unit of `limit` (None without a texture). `size` texels, `triangles` it stands for.
    `edges` what the predictors keep of the texture: its frame and critical points. `waits`: a later frame will capture it. `captures` made
    in this frame, with those found wanting."""

    key: Hashable
    name: str
    stage: str
    reason: str
    age: int
    betas: Betas | None
    errors: dict[str, float]
    error: float | None
    limit: float
    tilt_rad: float
    size: tuple[int, int]
    bytes: int
    triangles: int
    edges: ReliefEdges | None = None
    waits: bool = False
    captures: int = 0
