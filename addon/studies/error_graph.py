"""The error m over view depth, as curves: what the theory predicts for every map, what the picture has, and where the maps meet. No bpy.

Predictions are those of the report (T4 (25), (15), (19)), on the view axis; measured is m of the pixels seen, by depth.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..maths.error.aliasing import beam_error_z, error_x
from ..maths.error.theory import Resolution
from ..maths.error.warped_map import WarpedMap
from .report import warped_map
from .run import Outcome

GRAPHED = "depth", "aliasing"
"""The passes that a graph is made of."""
BINS, POINTS = 40, 48
FEWEST_IN_BIN = 12
MOST_PIXELS = 200_000
ROOM = 1.4  # by what factor (a perspective view) the depths shown reach beyond those seen


@dataclass(frozen=True, eq=False)
class Prediction:
    """m_x(z), across the view, and m_z(z), along it, of one map at depths z; each (P,)."""

    index: int
    z: np.ndarray
    m_x: np.ndarray
    m_z: np.ndarray


@dataclass(frozen=True, eq=False)
class Measured:
    """Median and 95 % quantile of m at depths z (bin centres), each (B,); `share` of the pixels seen in that bin."""

    z: np.ndarray
    median: np.ndarray
    p95: np.ndarray
    share: np.ndarray


@dataclass(frozen=True, eq=False)
class ErrorGraph:
    """All there is to draw. `near`, `far` are the ends of the depth axis, which is logarithmic unless the view is orthographic."""

    near: float
    far: float
    is_logarithmic: bool
    predictions: tuple[Prediction, ...]
    measured: Measured
    splits: tuple[float, ...]

    def along(self, z: np.ndarray | float) -> np.ndarray:
        """Depth as 0…1 along the axis."""
        if self.is_logarithmic:
            return np.log(np.maximum(z, 1e-30) / self.near) / np.log(self.far / self.near)
        return (np.asarray(z) - self.near) / (self.far - self.near)

    def ticks(self) -> list[float]:
        """Round depths inside the axis, ascending: two to eight of them."""
        if self.is_logarithmic and self.far > 20.0 * self.near:
            decades = range(int(np.floor(np.log10(self.near))), int(np.ceil(np.log10(self.far))) + 1)
            found = [float(f"{digit}e{decade}") for decade in decades for digit in ((1, 2, 5) if len(decades) < 5 else (1,))]
        else:
            size = 10.0 ** np.floor(np.log10(self.far - self.near))
            step = size * next(s for s in (1.0, 0.5, 0.2) if (self.far - self.near) / (s * size) >= 4.0)
            found = (np.arange(np.ceil(self.near / step), np.floor(self.far / step) + 1) * step).tolist()
        inside = [z for z in found if 0.03 <= self.along(z) <= 0.97]
        return inside[:: max(1, -(-len(inside) // 8))]


def error_graph(outcome: Outcome) -> ErrorGraph | None:
    """The graph of an outcome with the passes depth and aliasing and a light; None when there is nothing to measure."""
    passes, plan, camera = outcome.frame.passes, outcome.frame.plan, outcome.job.camera
    if plan is None or not passes.keys() >= set(GRAPHED):
        return None
    depth, m = passes["depth"].ravel(), passes["aliasing"][..., 0].ravel()
    seen = np.flatnonzero(np.isfinite(depth) & np.isfinite(m) & (m >= 0.0))
    seen = seen[:: max(1, len(seen) // MOST_PIXELS)]
    if len(seen) < FEWEST_IN_BIN:
        return None
    z, m = depth[seen].astype(np.float64), m[seen].astype(np.float64)
    is_logarithmic = not camera.is_orthographic and bool(z.min() > 0.0)
    near, far = _reach(float(z.min()), float(z.max()), is_logarithmic)
    edges = np.geomspace(near, far, BINS + 1) if is_logarithmic else np.linspace(near, far, BINS + 1)
    ends = {float(p.depth_range[1]) for p in plan.projections if not p.is_empty}
    splits = sorted(end for end in ends if near < end < far)
    return ErrorGraph(near, far, is_logarithmic, _predictions(outcome, near, far), _measured(z, m, edges), tuple(splits))


def _reach(low: float, high: float, is_logarithmic: bool) -> tuple[float, float]:
    if is_logarithmic:
        return low / ROOM, high * ROOM
    room = max(0.1 * (high - low), 1e-3)
    return low - room, high + room


def _predictions(outcome: Outcome, near: float, far: float) -> tuple[Prediction, ...]:
    job, plan = outcome.job, outcome.frame.plan
    rx, rz = Resolution(job.settings.fit.size, job.size).terms
    found = []
    for index, projection in enumerate(plan.projections):
        theory: WarpedMap | None = warped_map(job, plan, projection)
        low, high = max(near, projection.depth_range[0]), min(far, projection.depth_range[1])
        if theory is None or projection.face >= 0 or low >= high:
            continue
        z = np.geomspace(low, high, POINTS)
        found.append(Prediction(index, z, error_x(theory, z, rx), beam_error_z(theory, z, rz)))
    return tuple(found)


def _measured(z: np.ndarray, m: np.ndarray, edges: np.ndarray) -> Measured:
    """Quantiles per bin; bins with too few pixels are left out."""
    order = np.argsort(z, kind="stable")
    z, m = z[order], m[order]
    starts = np.searchsorted(z, edges)
    rows = []
    for i in range(len(edges) - 1):
        inside = m[starts[i] : starts[i + 1]]
        if len(inside) >= FEWEST_IN_BIN:
            median, p95 = np.quantile(inside, (0.5, 0.95))
            rows.append((0.5 * (edges[i] + edges[i + 1]), median, p95, len(inside) / len(z)))
    columns = np.array(rows).reshape(-1, 4).T
    return Measured(*columns)
