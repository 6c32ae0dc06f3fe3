"""Which planes part the view among its z partitions: across the view (T4 §4.3.2), or along the light's rays.

The schemes of `partitions.py` say how many maps a stretch of the view axis deserves; T4 parts the view by planes of constant view depth.
Unless the light is at right angles to the view, the slabs between them overlap in the light's picture, and every map pays for the common
ground again: k maps of 1/k of the texels are then worse than one map. Planes that contain the light's direction part that picture itself,
so that nothing is paid for twice. Both are planes across a direction between the view's and the light space's z (`Slices.normal`).

Along the rays the cuts are quantiles of the scheme's density as it is seen along that direction: what lies between two view depths weighs
as many maps as the scheme gives it, spread over the heights that it covers. With the light at right angles to the view both are the same.

A slice is short along the view and as wide as ever across it, and a map is square: k slices have texels up to k times as long as one map's,
and a shadow's edge is as wrong as they are long. The cut 'halves' makes of an even number of maps, from four on, two halves side by side of
half as many slices, never worse than one map by more than a few per cent. Near γ = 0 the line between halves stands upright in the picture.
Along what is long and narrow slices are better: the cut 'auto' takes the one or the other by what is seen (`suited_cut.py`).

A partition's texels must not jump while the camera moves. Towards γ = 0, where light space's z has no direction, the planes turn until they
stand across the view (`tilt_of`). In a deep view they also never turn so far that a side of the frustum runs back behind the eye: there the
first partition, as thin as the near plane is near, would grow by the far distance times the change of γ.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import log, pi, radians, sin

import numpy as np

from ..choices import PartitionChoice
from ..frusta import Body
from ..spaces import smoothstep
from .light_space import LightSpace, round_core

PER_PARTITION = 4  # slices of a partition in which its density is spread evenly
MOST_SAMPLES = 32_768  # receivers that the density is taken from
SLACK = 1e-6  # of the heights: what is this near to a cut along the light counts on both sides, as rounding may decide
SHALLOW, DEEP = 2.0, 8.0  # f/n up to which a view is shallow, from which it is deep
TURNED = radians(28), radians(35)  # γ from which the planes are turned as far as they go, in a shallow and in a deep view
UPRIGHT_BELOW = radians(30)  # γ below which the line between halves turns upright
CLEAR = radians(8.0)  # angle that they keep from the side of a deep frustum


@dataclass(frozen=True, eq=False)
class Slices:
    """k partitions between the k+1 `bounds` of a height, `normal` · p (p relative to the eye), of unit `normal`.

    `weights` make the height of a view depth and a z of light space. `splits` are the scheme's view depths; if the cuts are `along` the
    light, every partition may reach from the first to the last of them.
    """

    normal: np.ndarray
    weights: tuple[float, float]
    bounds: np.ndarray
    splits: np.ndarray
    along: bool

    @property
    def count(self) -> int:
        """k."""
        return len(self.bounds) - 1

    def heights(self, depths: np.ndarray, z_ls: np.ndarray) -> np.ndarray:
        """Heights of points by their view depths and z of light space."""
        return depths * np.float32(self.weights[0]) + z_ls * np.float32(self.weights[1])

    def holds(self, i: int, heights: np.ndarray) -> np.ndarray:
        """Which `heights` (P,) belong to partition i: [lower, upper), the last one closed."""
        lower, upper = np.float32(self.bounds[i]), np.float32(self.bounds[i + 1])
        if self.along:
            room = np.float32(SLACK) * np.abs(heights)
            return (heights >= lower - room) & (heights <= upper + room)
        return (heights >= lower) & ((heights <= upper) if i + 1 == self.count else (heights < upper))

    def planes(self, i: int) -> np.ndarray:
        """(0 … 2, 4) inward planes between partition i and its neighbours, relative to the eye, with unit normals."""
        inner = [(1.0, self.bounds[i])] * (i > 0) + [(-1.0, self.bounds[i + 1])] * (i + 1 < self.count)
        return np.array([np.append(side * self.normal, -side * bound) for side, bound in inner]).reshape(-1, 4)

    def region(self, i: int) -> np.ndarray:
        """(P, 4) those of the planes that `depths` does not say already."""
        return self.planes(i) if self.along else np.empty((0, 4))

    def depths(self, i: int) -> tuple[float, float]:
        """View depths that bound partition i, with a little room at the ends of the view."""
        first, last = (0, -1) if self.along else (i, i + 1)
        slack = 1e-5 * (self.splits[-1] - self.splits[0])
        near, far = float(self.splits[first]), float(self.splits[last])
        return near - slack * (first == 0), far + slack * (self.along or last == self.count)


def slice_count(choice: PartitionChoice) -> int:
    """Slices along the view for the choice's maps: with the cut 'halves' half as many, where their number is even and at least 4."""
    return choice.z_count // 2 if choice.cut == "halves" and choice.z_count >= 4 and choice.z_count % 2 == 0 else choice.z_count


def across_view(splits: np.ndarray, view: np.ndarray) -> Slices:
    """T4's slabs: partition i lies between the view depths i and i + 1 of `splits`."""
    return Slices(view, (1.0, 0.0), splits, splits, along=False)


def tilt_of(space: LightSpace, gamma_lim: float, side: float, depth_ratio: float) -> float:
    """Angle from the view axis to the planes' normal: 0 across the view, π/2 − γ along the light's rays.

    `side` is the frustum's half angle in the plane of light and view.
    """
    full = 0.5 * pi - space.gamma_rad
    deep = smoothstep(log(depth_ratio), log(SHALLOW), log(DEEP))
    most = 0.5 * pi - deep * (side + CLEAR)
    return min(full, most) * smoothstep(space.gamma_rad, round_core(gamma_lim), TURNED[0] + deep * (TURNED[1] - TURNED[0]))


def along_light(
    splits: np.ndarray, view: np.ndarray, space: LightSpace, gamma_lim: float, side: float, contents: Body | tuple[np.ndarray, np.ndarray]
) -> Slices:
    """As many partitions along the sun's rays as `splits` bound; `contents` is what they are fitted to: a body, or the receivers' (view
    depths, z of light space). Without contents the slabs of the view, which are as empty.
    """
    full = 0.5 * pi - space.gamma_rad
    tilt = tilt_of(space, gamma_lim, side, splits[-1] / splits[0] if splits[0] > 0.0 else 1.0)
    weights = (sin(full - tilt) / sin(full), sin(tilt) / sin(full)) if full > 1e-6 else (0.0, 1.0)
    normal = weights[0] * view + weights[1] * space.from_eye[2, :3]
    fine = _finer(splits)
    found = _of_body(contents, fine, view, normal) if isinstance(contents, Body) else _of_samples(*contents, fine, weights)
    if found is None:
        return across_view(splits, view)
    heights, share = found
    count = len(splits) - 1
    cuts = np.interp(np.arange(1, count) / count, share, heights)
    return Slices(normal, weights, np.concatenate([[-np.inf], cuts, [np.inf]]), splits, along=True)


def _finer(splits: np.ndarray) -> np.ndarray:
    """`splits` with `PER_PARTITION` slices to each partition: self-similar, or equal where a parallel view begins behind the eye."""
    count = len(splits) - 1
    places = np.linspace(0.0, count, count * PER_PARTITION + 1), np.arange(count + 1)
    return np.exp(np.interp(*places, np.log(splits))) if splits[0] > 0.0 else np.interp(*places, splits)


def _of_body(body: Body, fine: np.ndarray, view: np.ndarray, normal: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """(heights, share of the density below them): each slice's weight spread evenly over the heights between which the body lies there."""
    edges = np.array([pair for face in body.faces for pair in zip(face, (*face[1:], face[0]), strict=True)]).reshape(-1, 2, 3)
    depths, heights = edges @ view, edges @ normal
    low, high = np.full(len(fine), np.inf), np.full(len(fine), -np.inf)  # of the body's cross-sections at the slices' ends
    for (d0, d1), (h0, h1) in zip(depths, heights, strict=True):
        crossed = np.flatnonzero((fine - d0) * (fine - d1) < 0.0)
        at = h0 + (fine[crossed] - d0) / (d1 - d0) * (h1 - h0) if len(crossed) else 0.0
        low[crossed], high[crossed] = np.minimum(low[crossed], at), np.maximum(high[crossed], at)
    low, high = np.minimum(low[:-1], low[1:]), np.maximum(high[:-1], high[1:])
    slot = np.clip(np.searchsorted(fine, depths[:, 0]) - 1, 0, len(low) - 1)  # the corners lie in a slice, or at the range's ends
    np.minimum.at(low, slot, heights[:, 0])
    np.maximum.at(high, slot, heights[:, 0])
    low, high = low[low <= high], high[low <= high]
    if not len(low):
        return None
    u = np.unique(np.concatenate([low, high]))
    return u, np.clip((u[:, None] - low) / np.maximum(high - low, 1e-9 * (u[-1] - u[0]) + 1e-300), 0.0, 1.0).mean(axis=1)


def _of_samples(
    depths: np.ndarray, z_ls: np.ndarray, fine: np.ndarray, weights: tuple[float, float]
) -> tuple[np.ndarray, np.ndarray] | None:
    """(heights, share of the density below them): each slice's weight shared by its receivers; slices without any have none."""
    if not len(depths):
        return None
    step = -(-len(depths) // MOST_SAMPLES)
    depths, z_ls = depths[::step], z_ls[::step]
    u = weights[0] * depths.astype(np.float64) + weights[1] * z_ls
    slot = np.clip(np.searchsorted(fine, depths) - 1, 0, len(fine) - 2)
    weight = 1.0 / np.bincount(slot)[slot]
    order = np.argsort(u)
    share = np.cumsum(weight[order])
    return u[order], share / share[-1]
