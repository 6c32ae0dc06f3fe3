"""A preview against the truth, in numbers: misclassified, acne, leak, edge displacement. Images in, numbers out; no rays, no GPU.

Edges live between pixels: a *crack* is the midpoint of two neighbouring pixel centres. All distances are exact Euclidean distances in
pixels on the grid of half pixels, on which centres and cracks both lie. The names are those of the report's `truth`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

SMALLEST_RADIUS_PX = 2.0
LARGEST_DISTANCE_PX = 64.0
ACNE_THRESHOLD = 0.01
ACNE_COLOR, LEAK_COLOR, EDGE_COLOR = (0.90, 0.10, 0.10), (0.10, 0.35, 0.95), (0.95, 0.75, 0.10)


@dataclass(frozen=True, eq=False)
class Cracks:
    """Booleans between neighbours of an (h, w) image: `across` (h, w−1) left | right, `down` (h−1, w) upper / lower."""

    across: np.ndarray
    down: np.ndarray

    def __or__(self, other: Cracks) -> Cracks:
        return Cracks(self.across | other.across, self.down | other.down)

    def __and__(self, other: Cracks) -> Cracks:
        return Cracks(self.across & other.across, self.down & other.down)

    def __invert__(self) -> Cracks:
        return Cracks(~self.across, ~self.down)

    def on_half_pixels(self) -> np.ndarray:
        """(2h−1, 2w−1) bool: centres at even-even places (False), cracks between them."""
        height, width = self.across.shape[0], self.down.shape[1]
        grid = np.zeros((2 * height - 1, 2 * width - 1), dtype=bool)
        grid[0::2, 1::2] = self.across
        grid[1::2, 0::2] = self.down
        return grid


def changes(image: np.ndarray) -> Cracks:
    """Where neighbours of an (h, w) image of labels differ."""
    return Cracks(image[:, 1:] != image[:, :-1], image[1:] != image[:-1])


def both(mask: np.ndarray) -> Cracks:
    """Where both neighbours are True."""
    return Cracks(mask[:, 1:] & mask[:, :-1], mask[1:] & mask[:-1])


def depth_breaks(points: np.ndarray, normals: np.ndarray, pixel_size: np.ndarray) -> Cracks:
    """Where neighbours do not lie on one continuous surface.

    Two visible points belong together when at least one lies within 1.5 pixels of the other's tangent plane: creases pass, steps do not.
    `points`, `normals` (h, w, 3); `pixel_size` (h, w) metres covered by a pixel that faces the camera there.
    """

    def step(a: tuple[slice, slice], b: tuple[slice, slice]) -> np.ndarray:
        offset = points[b] - points[a]
        from_a, from_b = (np.abs(np.einsum("ijk,ijk->ij", offset, normals[s])) for s in (a, b))
        return np.minimum(from_a, from_b) > 1.5 * np.maximum(pixel_size[a], pixel_size[b])

    every, later, earlier = slice(None), slice(1, None), slice(None, -1)
    return Cracks(step((every, earlier), (every, later)), step((earlier, every), (later, every)))


def distances(marks: np.ndarray, points: np.ndarray, limit: int) -> np.ndarray:
    """(K,) exact Euclidean distance from K cells (K, 2: row, column) of a grid to its nearest marked cell, in cells; at most `limit`.

    Separable: nearest mark in every row by running extrema, then the smallest hypotenuse over the rows, widened until none can win.
    """
    height, width = marks.shape
    index = np.arange(width, dtype=np.int32)
    before = np.maximum.accumulate(np.where(marks, index, -limit), axis=1)
    after = np.minimum.accumulate(np.where(marks, index, width - 1 + limit)[:, ::-1], axis=1)[:, ::-1]
    in_row = np.minimum(np.minimum(index - before, after - index), limit)
    row, column = points[:, 0], points[:, 1]
    best = in_row[row, column].astype(np.int64) ** 2
    for shift in range(1, min(limit, height)):
        if not (best > shift * shift).any():
            break
        for other in (row - shift, row + shift):
            inside = (other >= 0) & (other < height)
            best[inside] = np.minimum(best[inside], in_row[other[inside], column[inside]].astype(np.int64) ** 2 + shift * shift)
    return np.sqrt(best.astype(np.float64))


def distance_to_edges_px(edges: Cracks, pixels: np.ndarray) -> np.ndarray:
    """(K,) distance in pixels from the centres of K pixels (K, 2: row, column) to the nearest crack or the image's border, at most 64.

    What lies beyond the border is not known, so the border counts as an edge.
    """
    grid = edges.on_half_pixels()
    inner = distances(grid, 2 * pixels, int(2 * LARGEST_DISTANCE_PX)) / 2.0
    size = (np.array(grid.shape) + 1) / 2
    border = np.minimum(pixels + 0.5, size - 0.5 - pixels).min(axis=1)
    return np.minimum(inner, border)


def is_uniform(edges: Cracks, pixels: np.ndarray, texel_px: np.ndarray | float) -> np.ndarray:
    """(K,): no edge within two pixels or one texel's footprint, whichever is larger (a footprint of 64 pixels or more is never uniform)."""
    return distance_to_edges_px(edges, pixels) > np.maximum(SMALLEST_RADIUS_PX, texel_px)


def edge_displacements_px(truth_edges: Cracks, preview_edges: Cracks) -> tuple[np.ndarray, np.ndarray]:
    """For every true shadow edge (crack): its distance to the nearest edge of the preview, in pixels, 64 where there is none.

    Returns (E,) distances and (E, 2) rows and columns of the pixels above or left of the cracks.
    """
    truth, preview = truth_edges.on_half_pixels(), preview_edges.on_half_pixels()
    where = np.argwhere(truth)
    return distances(preview, where, int(2 * LARGEST_DISTANCE_PX)) / 2.0, where // 2


@dataclass(frozen=True, eq=False)
class Classes:
    """What each pixel of the preview is, (h, w) bool: `counted` the pixels compared (lit-facing in truth, same surface in the preview),
    `too_dark` and `too_light` the misclassified ones, `acne` and `leak` those of them that no edge excuses."""

    counted: np.ndarray
    too_dark: np.ndarray
    too_light: np.ndarray
    acne: np.ndarray
    leak: np.ndarray


def misclassified(lit: np.ndarray, shadow: np.ndarray, counted: np.ndarray) -> np.ndarray:
    """(h, w) where `lit` (truth, bool) and `shadow` (preview, light reaching the surface 0…1, dark below ½) disagree."""
    return counted & (lit != (shadow >= 0.5))


def classify(lit: np.ndarray, shadow: np.ndarray, counted: np.ndarray, facing: np.ndarray, uniform: np.ndarray) -> Classes:
    """What each pixel is; `uniform` (h, w) need be right at misclassified pixels only.

    Acne: dark here, lit in truth, facing the light by more than `ACNE_THRESHOLD` (cosine), truth uniform around.
    Leak: lit here, dark in truth, truth uniform around.
    """
    wrong = misclassified(lit, shadow, counted)
    too_dark, too_light = wrong & lit, wrong & ~lit
    return Classes(counted, too_dark, too_light, too_dark & uniform & (facing > ACNE_THRESHOLD), too_light & uniform)


def statistics(classes: Classes, displacement_px: np.ndarray, where: np.ndarray | None = None) -> dict[str, float | int | None]:
    """The report's `truth`: percentages of the counted pixels (inside `where` if given); None where nothing can be counted."""
    inside = classes.counted if where is None else classes.counted & where
    pixels = int(inside.sum())

    def percent(mask: np.ndarray) -> float | None:
        return 100.0 * int((mask & inside).sum()) / pixels if pixels else None

    has_edges = displacement_px.size > 0
    return {
        "pixels": pixels,
        "misclassified_pct": percent(classes.too_dark | classes.too_light),
        "acne_pct": percent(classes.acne),
        "leak_pct": percent(classes.leak),
        "edge_px_median": float(np.median(displacement_px)) if has_edges else None,
        "edge_px_p95": float(np.percentile(displacement_px, 95.0)) if has_edges else None,
    }


def difference_image(classes: Classes, lit: np.ndarray, background: np.ndarray) -> np.ndarray:
    """(h, w, 3) float32: red acne, blue leak, yellow what is within an edge's reach; grey where truth and preview agree.

    Grey tells the truth: light lit, middle dark or turned away; white where `background` (nothing visible).
    """
    grey = np.where(background, 1.0, np.where(lit, 0.75, 0.45)).astype(np.float32)
    image = np.repeat(grey[..., None], 3, axis=-1)
    image[classes.too_dark | classes.too_light] = EDGE_COLOR
    image[classes.acne] = ACNE_COLOR
    image[classes.leak] = LEAK_COLOR
    return image
