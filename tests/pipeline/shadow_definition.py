"""The shadow tests in numpy, float64, texel by texel, written plainly: the definition and the oracle of the shaders that do them.

IDD's two epsilons, SMMVP's n-SM with its composite test and PCF(k, n), and the depth test by height over the receiver's plane.
Shapes: P receivers, n depths per cell, k taps; maps (N, N) with row 0 at t = −1, NDC depth −1…1 unless said otherwise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from addon.maths.shadow.lookup import project, texel_footprint, towards_light, unproject
from addon.maths.shadow.projection import ShadowProjection
from addon.maths.view import Light
from addon.pipeline.passes.shadow_defines import spread_neighbours


def selected_places(depth: np.ndarray, depths: int) -> np.ndarray:
    """(N, N, n, 2) int: offset (x, y) of the cell whose depth is each cell's i-th (SMMVP §4.5).

    The first is the cell itself. n = 2: then the largest of the 3×3; n = 3: the largest and the smallest (of equals the centre, else the
    first row by row); n ≥ 4: `spread_neighbours`. Beyond the border the border's cells repeat.
    """
    size = depth.shape[0]
    places = np.zeros((size, size, depths, 2), dtype=np.int64)
    if depths >= 4:
        places[:, :, 1:] = spread_neighbours(depths)
        return places
    nine = np.array([(x, y) for y in (-1, 0, 1) for x in (-1, 0, 1)])
    order = np.array([4, 0, 1, 2, 3, 5, 6, 7, 8])
    values = np.stack([_shifted(depth, *nine[i]) for i in order])
    for i, pick in enumerate((np.argmax, np.argmin)[: depths - 1]):
        places[:, :, i + 1] = nine[order[pick(values, axis=0)]]
    return places


def _shifted(image: np.ndarray, x: int, y: int) -> np.ndarray:
    size = image.shape[0]
    rows, columns = np.clip(np.arange(size) + y, 0, size - 1), np.clip(np.arange(size) + x, 0, size - 1)
    return image[rows[:, None], columns[None, :]]


def selected(values: np.ndarray, places: np.ndarray) -> np.ndarray:
    """(N, N, n) the values of a map (depths or ids) at the places of its n-SM."""
    size = values.shape[0]
    row, column = np.mgrid[:size, :size]
    return values[np.clip(row[..., None] + places[..., 1], 0, size - 1), np.clip(column[..., None] + places[..., 0], 0, size - 1)]


def is_dark_by_id(difference: np.ndarray, same_id: np.ndarray, near: np.ndarray | float, far: np.ndarray | float) -> np.ndarray:
    """IDD §5.4, §5.5 for `difference` d − d_map (metres): dark iff difference > ε_far, or the ids differ and difference > ε."""
    return (difference > far) | (~same_id & (difference > near))


@dataclass(frozen=True, eq=False)
class ReceiverSamples:
    """P lit-facing points seen in one map: `points_ws`, `normals_ws` (P, 3) towards the light, `ids` (P,)."""

    projection: ShadowProjection
    light: Light
    size: int
    points_ws: np.ndarray
    normals_ws: np.ndarray
    ids: np.ndarray

    def texels(self) -> np.ndarray:
        """(P, 2) texel coordinates 0…N."""
        s, t, _, _ = project(self.projection, self.points_ws)
        return (np.stack([s, t], axis=-1) + 1.0) * (self.size / 2.0)

    def facing(self) -> np.ndarray:
        """(P,) cosine between normal and light."""
        return (self.normals_ws * towards_light(self.light, self.points_ws)).sum(axis=-1)

    def footprint_m(self) -> np.ndarray:
        """(P,) metres: the longer side of the texel across the light's ray."""
        return np.linalg.norm(texel_footprint(self.projection, self.points_ws, self.light, self.size), axis=-1).max(axis=-1)

    def heights_m(self, cells: np.ndarray, depth: np.ndarray) -> np.ndarray:
        """(P, …) metres above each receiver's plane of the map's points at `cells` (P, …, 2) with NDC `depth` (P, …)."""
        s, t = np.moveaxis((cells + 0.5) * (2.0 / self.size) - 1.0, -1, 0)
        extra = (slice(None), *(None,) * (depth.ndim - 1))
        return ((unproject(self.projection, s, t, depth) - self.points_ws[extra]) * self.normals_ws[extra]).sum(axis=-1)

    def distances_m(self, depth: np.ndarray) -> np.ndarray:
        """(P, …) metres along each receiver's own ray, towards the light, to the NDC `depth` (P, …): IDD's d − d_map."""
        extra = (slice(None), *(None,) * (depth.ndim - 1))
        s, t, _, _ = project(self.projection, self.points_ws)
        points = unproject(self.projection, s[extra], t[extra], depth)
        return ((points - self.points_ws[extra]) * towards_light(self.light, self.points_ws)[extra]).sum(axis=-1)


def tap_cells(texels: np.ndarray, side: int, spacing: float = 1.0) -> np.ndarray:
    """(P, k, 2) int cells of the k = side² taps round (P, 2) texel coordinates, `spacing` texels apart, row by row."""
    y, x = np.mgrid[:side, :side].reshape(2, -1) - (side - 1) / 2.0
    return np.floor(texels[:, None] + spacing * np.stack([x, y], axis=-1)).astype(np.int64)


def cell_values(values: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """The map's values (N, N, …) at `cells` (…, 2) as (x, y); beyond the border the border's cells repeat."""
    size = values.shape[0]
    inside = np.clip(cells, 0, size - 1)
    return values[inside[..., 1], inside[..., 0]]


def filtered(lit: np.ndarray) -> np.ndarray:
    """(P,) PCF(k, n): the mean over taps of the composite tests' s/n, as light, of `lit` (P, k, n) bool. n·k + 1 levels (SMMVP §4.4)."""
    return lit.reshape(len(lit), -1).mean(axis=1)


def is_dark_between(heights: np.ndarray, dark: np.ndarray, within: np.ndarray, low: np.ndarray, edge: float, foot: float) -> np.ndarray:
    """(P,) whether a place is dark, from the four cells round it: their `heights` (P, 4) over the receiver's plane and whether each is
    `dark` (P, 4); own, next in s, next in t, next in both. `within` (P, 2): from the own centre towards the others', 0…0.5 texel.

    Dark iff the bilinear share of the dark cells reaches `edge`, or `foot` where the lowest of them stands at most `low` (P,) metres high.
    """
    own = 1.0 - within
    weights = np.stack([own.prod(axis=1), within[:, 0] * own[:, 1], own[:, 0] * within[:, 1], within.prod(axis=1)], axis=-1)
    lowest = np.where(dark, heights, np.inf).min(axis=1)
    return (weights * dark).sum(axis=1) >= np.where(lowest <= low, foot, edge)
