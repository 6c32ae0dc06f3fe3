"""What a render gives back: images (row 0 at the top) and numbers. Data only."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from ..maths.shadow.projection import ShadowPlan

if TYPE_CHECKING:
    from .impostors.life import ImpostorReport


@dataclass(frozen=True, eq=False)
class Frame:
    """One rendered view.

    `passes` holds the images asked for, by the contract's names: combined (h, w, 4), shadow (h, w), depth (h, w) view depth or inf,
    normal (h, w, 3) world, object (h, w) int32, partition (h, w) int32, aliasing (h, w, 3), and with 'texel' shadow_depth (k, N, N).
    `plan` the shadow projections used (None when there was no light); `timing_ms` and `geometry` as in the contract's report;
    `gl` {"renderer", "version"}; `measured` the error statistics (maths.error.aliasing.aliasing_statistics).
    `impostors` one `ImpostorReport` (pipeline.impostors.life) per impostor asked for.
    """

    passes: dict[str, np.ndarray]
    plan: ShadowPlan | None
    timing_ms: dict[str, float | None]
    geometry: dict[str, int]
    gl: dict[str, str]
    measured: dict[str, object] | None
    warnings: tuple[str, ...] = field(default=())
    impostors: tuple[ImpostorReport, ...] = field(default=())
