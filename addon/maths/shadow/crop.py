"""One shadow map's matrix: the warp, cropped to its receivers in (s, t), and its depth range from receivers to casters.

In light space (`light_space.py`, the apex centred on the view axis) P is `w = 1 + κ (z − z₀)` with κ = 1/n' and z₀ its near plane, so that
`S = (x − x₀)/w`, `T = (z − z₀)/w` (T4 (20), (21) up to the crop) and uniform is κ = 0 without a special case. The crop is affine in (S, T):
it moves the map's edges, never the apex, so the spacing of texels stays the theory's. Where T = 1/κ lies the horizon (w = ∞).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import copysign, cos, inf, log2, sin, sqrt

import numpy as np

from ..choices import FitChoice
from ..frusta import box_corners, box_distances
from ..spaces import linear
from .light_space import LightSpace
from .projection import LogWarp

DEPTH_MARGIN = 1e-3  # of the depth range, on both sides
LEAST_SPAN = log2(1.0 + 1.0 / 64.0)  # of a bent log map's logarithm: below, float32 would cancel
HIGHEST = 16.0  # footprints above the highest receiver: casters beyond are flattened onto the near plane (depth clamp)
NEARER = 4.0  # times nearer to a lamp than the nearest receiver: likewise (depth is 1/R there, so digits are dearer)
LEAST_SHAPE = 1e-4  # the map's short side is never less than this share of its long side (a body seen edge on)


@dataclass(frozen=True, slots=True)
class Warp:
    """κ = 1/n' (0 = uniform) and z₀, the near plane of P, in light space; `log` None, or whether the log map divides s by w.

    `bend` of its t: texels at the far end grow by 1 + bend beside the logarithm's (`LogWarp`)."""

    kappa: float
    start: float
    log: bool | None = None
    bend: float = 0.0

    def w_at(self, t: float) -> float:
        """w where the projective coordinate is T (before the crop): 1/(1 − κ T)."""
        return 1.0 / (1.0 - self.kappa * t)


@dataclass(frozen=True, slots=True)
class Receivers:
    """K points to be covered: rows x, y, z of light space (3, K); `radius` (K,), half a pixel's footprint in the same units, or None."""

    rows: np.ndarray
    radius: np.ndarray | None = None


@dataclass(frozen=True, slots=True)
class Casters:
    """Light-space boxes of the casters: `centre`, `half` (I, 3), axes x, y, z."""

    centre: np.ndarray
    half: np.ndarray

    def top_above(self, x: tuple[float, float], z: tuple[float, float]) -> float:
        """Largest y of the boxes that overlap the rectangle x × z; −inf where there is none."""
        overlap = np.ones(len(self.centre), bool)
        for axis, (lo, hi) in ((0, x), (2, z)):
            overlap &= (self.centre[:, axis] + self.half[:, axis] >= lo) & (self.centre[:, axis] - self.half[:, axis] <= hi)
        return float((self.centre[:, 1] + self.half[:, 1])[overlap].max(initial=-inf))


def casters_in(space: LightSpace, boxes: np.ndarray) -> Casters:
    """The casters' boxes in light space: bounds of the turned boxes (sun), or of their images and nearest points."""
    if space.position is None:
        centre, half = boxes.mean(axis=1), 0.5 * (boxes[:, 1] - boxes[:, 0])
        axes = space.from_eye[:3, :3]
        return Casters(linear(axes, centre.T).T, linear(np.abs(axes), half.T).T)
    h = box_corners(boxes) @ space.from_eye[:, :3].T + space.from_eye[:, 3]
    ahead = h[..., 3].max(axis=1, initial=-inf) > space.least
    h, boxes = h[ahead], boxes[ahead]
    gap = box_distances(boxes, space.position)
    nearest = np.maximum(h[..., 3].min(axis=1), np.maximum(space.least, gap / sqrt(1.0 + 2.0 * space.slope**2)))
    beside = h[..., 3].min(axis=1) < space.least  # it reaches behind the light: its image is unbounded
    r = np.maximum(h[..., 3], space.least)
    lower = np.where(beside[:, None], -1e30, (h[..., :3] / r[..., None]).min(axis=1))
    upper = np.where(beside[:, None], 1e30, (h[..., :3] / r[..., None]).max(axis=1))
    lower[:, 1] = upper[:, 1] = 1.0 / nearest
    return Casters(0.5 * (lower + upper), 0.5 * (upper - lower))


@dataclass(frozen=True, slots=True)
class Cropped:
    """The result: `clip_from_eye` (4, 4) for points relative to the eye, the log step or None, and y of light space at depth −1 and +1."""

    clip_from_eye: np.ndarray
    log: LogWarp | None
    y_range: tuple[float, float]
    centre: tuple[float, float]


def crop(
    space: LightSpace, warp: Warp, receivers: Receivers, casters: Casters, fit: FitChoice, round_share: float, least: float = 0.0
) -> Cropped:
    """The map of `receivers`: s, t ∈ [−1, 1] on all of them, with `fit`'s margin; depth from the nearest caster above down to them.

    `least` is the least side of the map in light space, at its far edge.
    """
    s, t = _bounds(space, warp, receivers, round_share)
    floor = LEAST_SHAPE * max(s[1] - s[0], t[1] - t[0], 1e-6)
    grow = 1.0 / (1.0 - 2.0 * fit.margin_texels / fit.size)
    t = t[0], max(t[1], _advanced(warp, t[0], least))
    s = _widened(s, grow, max(floor, least if warp.log is False else least / warp.w_at(t[1])))
    t, log_step = _t_edges(warp, t, grow, floor)
    w_ends = warp.w_at(t[0]), warp.w_at(t[1])
    x_ends = [space.apex_x + edge * w for edge in s for w in (w_ends if warp.log is not False else (1.0, 1.0))]
    z_ends = warp.start + t[0] * w_ends[0], warp.start + t[1] * w_ends[1]
    y = receivers.rows[1]
    bottom, lit = float(y.min()), float(y.max())
    span = max(max(x_ends) - min(x_ends), z_ends[1] - z_ends[0])
    top = max(lit, min(casters.top_above((min(x_ends), max(x_ends)), z_ends), _highest(space, lit, span)))
    pad = DEPTH_MARGIN * (top - bottom) + 1e-6 * max(abs(top), abs(bottom), s[1] - s[0])
    bottom, top = bottom - pad, top + pad
    matrix, reach = _matrix(space, warp, s, t, (bottom, top), 1.0 if log_step else w_ends[0])
    t_mid = 0.5 * (t[0] + t[1])
    w_mid = 1.0 if log_step else warp.w_at(t_mid)
    middle = 0.5 * (bottom + top)
    centre = space.apex_x + 0.5 * (s[0] + s[1]) * w_mid, warp.start + t_mid * w_mid
    return Cropped(matrix, log_step, (middle + reach * w_mid, middle - reach * w_mid), centre)


def _highest(space: LightSpace, lit: float, span: float) -> float:
    """The y of light space beyond which casters need no depth of their own: each covers whatever it stands above.

    `HIGHEST` times the footprint `span` above the highest receiver `lit`, so that one far wall does not take the depth's digits from all
    others; for a finite light, where y = 1/R, at a `NEARER`th of the nearest receiver's distance.
    """
    return lit + HIGHEST * span if space.position is None else NEARER * lit


def _bounds(space: LightSpace, warp: Warp, receivers: Receivers, round_share: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Least and largest S and T of the receivers, with half a pixel's footprint; towards γ = 0 blended into the circle's square."""
    x, _, z = receivers.rows
    along = z - warp.start
    w = 1.0 + warp.kappa * along if warp.kappa else None
    if w is None:
        s, t = x - space.apex_x, along
    else:
        t = along / w
        s = x - space.apex_x if warp.log is False else (x - space.apex_x) / w
    edges = []
    for values, power in ((s, 0 if warp.log is False else 1), (t, 2)):
        lo, hi = int(values.argmin()), int(values.argmax())
        pads = [_pad(receivers.radius, w, power, i) for i in (lo, hi)]
        edges.append((float(values[lo]) - pads[0], float(values[hi]) + pads[1]))
    if round_share > 0.0:
        centre, radius = _circle(s, t, space.upright)
        radius += 0.0 if receivers.radius is None else float(receivers.radius.max())
        edges = [_rounded(edge, c, radius, round_share) for edge, c in zip(edges, centre, strict=True)]
    (s0, s1), (t0, t1) = edges
    return (s0, s1), (t0, min(t1, 0.5 * (float(t.max()) + 1.0 / warp.kappa)) if warp.kappa else t1)


def _pad(radius: np.ndarray | None, w: np.ndarray | None, power: int, i: int) -> float:
    """Half a pixel's footprint at receiver i, in S (dS/dx = 1/w) or T (dT/dz = 1/w²)."""
    return 0.0 if radius is None else float(radius[i]) / (1.0 if w is None else float(w[i]) ** power)


def _circle(s: np.ndarray, t: np.ndarray, upright: float) -> tuple[tuple[float, float], float]:
    """A circle round the points that does not depend on the azimuth of the axes: centred on their box along the camera's own axes."""
    c, n = cos(upright), sin(upright)
    u, v = c * s + n * t, c * t - n * s
    u_mid, v_mid = 0.5 * float(u.min() + u.max()), 0.5 * float(v.min() + v.max())
    u -= u_mid
    v -= v_mid
    return (c * u_mid - n * v_mid, n * u_mid + c * v_mid), float(np.sqrt((u * u + v * v).max()))


def _rounded(edge: tuple[float, float], centre: float, radius: float, share: float) -> tuple[float, float]:
    """`edge` moved towards centre ± radius so that its length goes geometrically from the one's to the other's; it never shrinks."""
    lo, hi = min(edge[0], centre - radius), max(edge[1], centre + radius)
    length, full = edge[1] - edge[0], hi - lo
    if not full > length:
        return edge
    wanted = max(length, 1e-3 * full) ** (1.0 - share) * full**share
    u = min(1.0, max(0.0, (wanted - length) / (full - length)))
    return edge[0] + u * (lo - edge[0]), edge[1] + u * (hi - edge[1])


def _advanced(warp: Warp, t: float, length: float) -> float:
    """T of the point `length` further along z than T = t."""
    along = t * warp.w_at(t) + length
    return along / (1.0 + warp.kappa * along)


def _widened(edge: tuple[float, float], grow: float, floor: float) -> tuple[float, float]:
    """`edge` scaled about its middle, at least `floor` long."""
    middle, half = 0.5 * (edge[0] + edge[1]), 0.5 * max((edge[1] - edge[0]) * grow, floor)
    return middle - half, middle + half


def _t_edges(warp: Warp, t: tuple[float, float], grow: float, floor: float) -> tuple[tuple[float, float], LogWarp | None]:
    """The map's edges in T with the margin, which a log map has on its log axis; never beyond half the way to the horizon."""
    if warp.log is None:
        lo, hi = _widened(t, grow, floor)
        return (lo, min(hi, 0.5 * (t[1] + 1.0 / warp.kappa)) if warp.kappa else hi), None
    ends = warp.w_at(t[0]), warp.w_at(t[1])
    bend, base, slope = bent(warp.bend, *ends)
    unit = LogWarp(1.0 / warp.kappa, ends[1] / warp.kappa, copysign(1.0, base), 0.0, warp.log, bend, base, slope)
    lo, hi = _widened((float(unit.t_at(ends[0])), float(unit.t_at(ends[1]))), grow, log2(1.0 + warp.kappa * floor))
    first, last = float(unit.w_at(lo)), float(unit.w_at(hi))
    if slope and not 0.0 < last < 2.0 * ends[1]:
        last = 2.0 * ends[1]
        hi = float(unit.t_at(last))
    scale = 2.0 / (hi - lo)
    edges = (1.0 - 1.0 / first) / warp.kappa, (1.0 - 1.0 / last) / warp.kappa
    return edges, replace(unit, scale=scale * unit.scale, offset=-0.5 * (lo + hi) * scale)


def bent(bend: float, near: float, far: float) -> tuple[float, float, float]:
    """`bend`, base and slope of a log map from w = `near` to `far`; moved off the place where its logarithm would vanish (the
    perspective map, far/near = 1 + bend), to the nearest one that float32 can draw."""
    ratio = far / near
    if bend == 0.0 or not ratio > 1.0:
        return 0.0, 1.0, 0.0
    if abs(log2(ratio / (1.0 + bend))) < LEAST_SPAN:
        bend = ratio * 2.0**-LEAST_SPAN - 1.0
    slope = bend / (far - near)
    return bend, 1.0 - slope * near, slope


def _matrix(
    space: LightSpace, warp: Warp, s: tuple[float, float], t: tuple[float, float], y: tuple[float, float], least_w: float
) -> tuple[np.ndarray, float]:
    """`clip_from_eye`, and the metres of y per unit of depth where w = 1. Depth is ±1 at the ends of `y` where w = `least_w`."""
    w_row = np.array([0.0, 0.0, warp.kappa, 1.0 - warp.kappa * warp.start])
    s_divisor = np.array([0.0, 0.0, 0.0, 1.0]) if warp.log is False else w_row
    s_mid, s_half, t_mid, t_half = 0.5 * (s[0] + s[1]), 0.5 * (s[1] - s[0]), 0.5 * (t[0] + t[1]), 0.5 * (t[1] - t[0])
    reach = 0.5 * (y[1] - y[0]) / least_w
    rows = np.array(
        [
            (np.array([1.0, 0.0, 0.0, -space.apex_x]) - s_mid * s_divisor) / s_half,
            (np.array([0.0, 0.0, 1.0, -warp.start]) - t_mid * w_row) / t_half,
            np.array([0.0, -1.0, 0.0, 0.5 * (y[0] + y[1])]) / reach,
            w_row,
        ]
    )
    return rows @ space.from_eye, reach
