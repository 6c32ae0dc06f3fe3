"""How wrong a warped relief texture would look from a given eye, predicted without a pass over the texture. No GPU.

Every predictor works on what `edges.py` gathered at capture, for one texture or for hundreds at once:

| name | what it says | source |
|---|---|---|
| `critical` | E_u² + E_v² of the critical pair, texels² (2 at rest) | RI 5-5…5-7 as written |
| `critical_px` | its opening beyond rest along its own axis, pixels | corrected: vertical pairs right, folds and shear not counted |
| `regions_sum`, `regions_max` | sum and largest of RI's E over N×M critical pairs | RI §5.6 as written |
| `regions_sum_px`, `regions_max_px`, `regions_share` | the same of the corrected form; share of regions that open by more than a pixel | |
| `edge_written_px` | pixels that open behind depth edges and outline, `Σ max(0, (s_fg − s_bg)(p − e)·n)` | method §7 |
| `edge_sum_px` | the same with what turns up from behind the outline, and what thin parts hide taken off | our own |
| `edge_fast_px` | the edge sum with one depth for all edges, from directional sums, O(1) per texture | the same |

An eye from which the warp does not exist (behind the plane) gives infinity everywhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..view import Camera
from .edges import SHIFTS, ReliefEdges
from .warp import pixel_from_clip, shift_unit, warp_coefficients

PREDICTORS = (
    "critical",
    "critical_px",
    "regions_sum",
    "regions_max",
    "regions_sum_px",
    "regions_max_px",
    "regions_share",
    "edge_written_px",
    "edge_sum_px",
    "edge_fast_px",
)
EXACT = ("edge_written_px", "edge_sum_px")
"""Those that go through all edges: their cost grows with their number."""
OPENS_PX = 1.0
"""A region counts in `regions_share` when its critical pair opens by more than this."""


@dataclass(frozen=True, eq=False)
class ReliefSet:
    """T textures' precomputations stacked for `predict`, T last, so that every step of it runs along the textures.

    `world_from_plane` (4, 4, T); `world_to_plane` (4, 4, T) their inverses, transposed; `source` (4, T); `extent` (2, T); `written`,
    `corrected` (6, 1 + R, T), the whole texture's pair first; `sums` flat, with the places (4, bins, T) in it where the strips of the four
    classes begin, `strips`; `means` (4, 4, bins, T) their `ReliefEdges.totals`; `deepest`, `unit`, `texels` (T,).
    """

    world_from_plane: np.ndarray
    world_to_plane: np.ndarray
    source: np.ndarray
    extent: np.ndarray
    deepest: np.ndarray
    written: np.ndarray
    corrected: np.ndarray
    sums: np.ndarray
    strips: np.ndarray
    means: np.ndarray
    unit: np.ndarray
    texels: np.ndarray
    members: tuple[ReliefEdges, ...]

    def __len__(self) -> int:
        return len(self.members)

    @cached_property
    def edges(self) -> tuple[np.ndarray, np.ndarray]:
        """All edges (E, 8) one after the other, and whose each is (E,)."""
        return _joined([m.edges for m in self.members])

    @cached_property
    def depth_edges(self) -> tuple[np.ndarray, np.ndarray]:
        """The same of the depth edges."""
        return _joined([m.depth_edges for m in self.members])


def relief_set(members: Sequence[ReliefEdges]) -> ReliefSet:
    """Stack precomputations that were made with the same `EdgeChoice`."""
    frames = [m.frame for m in members]
    sums = np.stack([m.sums for m in members])
    return ReliefSet(
        world_from_plane=_last([f.world_from_plane for f in frames]),
        world_to_plane=_last([f.plane_from_world.T for f in frames]),
        source=_last([f.source for f in frames]),
        extent=_last([np.array([f.width, f.height], float) for f in frames]),
        deepest=np.array([f.deepest_relief for f in frames]),
        written=_last([np.vstack([m.whole_written, m.written]).T for m in members]),
        corrected=_last([np.vstack([m.whole_corrected, m.corrected]).T for m in members]),
        sums=sums.ravel(),
        strips=_last(np.arange(0, sums.size, sums.shape[3]).reshape(sums.shape[:3])),
        means=_last([m.totals.transpose(2, 0, 1) for m in members]),
        unit=np.array([shift_unit(f) for f in frames]),
        texels=np.array([m.texels for m in members], float),
        members=tuple(members),
    )


def _joined(rows: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """(rows one after the other, whose each is)."""
    return np.concatenate(rows), np.repeat(np.arange(len(rows)), [len(r) for r in rows])


def _last(arrays: Sequence[np.ndarray] | np.ndarray) -> np.ndarray:
    """T equal arrays stacked along a new last axis, contiguous."""
    return np.ascontiguousarray(np.moveaxis(np.stack(list(arrays)), 0, -1))


def predict(textures: ReliefSet, camera: Camera, size: tuple[int, int], exact: bool = True) -> dict[str, np.ndarray]:
    """Every predictor of the table above and `covered_px`, (T,) each, for `camera` with an image of `size` (width, height) pixels.

    `covered_px` are the pixels that the texture's texels would cover lying on its plane.

    `exact=False` leaves out those of `EXACT`.
    """
    view = _View.of(textures, camera, size)
    written = _written(view, textures.written)
    opening = _opening_px(view, textures.corrected)
    out = {
        "critical": written[0],
        "regions_sum": written[1:].sum(axis=0),
        "regions_max": written[1:].max(axis=0),
        "critical_px": opening[0],
        "regions_sum_px": opening[1:].sum(axis=0),
        "regions_max_px": opening[1:].max(axis=0),
        "regions_share": (opening[1:] > OPENS_PX).mean(axis=0),
        "edge_fast_px": _edge_fast_px(view, textures),
        "covered_px": _covered_px(view, textures),
    }
    if exact:
        out |= {name: _edge_sum_px(view, *edges) for name, edges in zip(EXACT, (textures.depth_edges, textures.edges), strict=True)}
    return {name: np.where(view.valid, value, np.inf) for name, value in out.items()}


def predict_one(edges: ReliefEdges, camera: Camera, size: tuple[int, int]) -> dict[str, float]:
    """`predict` for a single texture, as plain numbers."""
    return {name: float(value[0]) for name, value in predict(relief_set([edges]), camera, size).items()}


@dataclass(frozen=True, eq=False)
class _View:
    """The warps K (3, T) of T textures and their projections for one camera: homographies (3, 3, T) and the determinants (T,) of these.
    `valid` (T,): the eye stands before the plane and all of the bounds before the eye; elsewhere the numbers are placeholders."""

    K: np.ndarray
    homography: np.ndarray
    determinant: np.ndarray
    depth_row: np.ndarray
    valid: np.ndarray

    @classmethod
    def of(cls, textures: ReliefSet, camera: Camera, size: tuple[int, int]) -> _View:
        """`depth_row` (4, T): the w of a texel of relief δ is `depth_row · (u, v, 1, δ)`."""
        count = len(textures)
        eye_ws = np.append(-camera.direction_ws, 0.0) if camera.is_orthographic else np.append(camera.eye_ws, 1.0)
        eye = (eye_ws @ textures.world_to_plane.reshape(4, -1)).reshape(4, count)
        before = eye[2] < -1e-9
        eye = np.where(before, eye, [[0.0], [0.0], [-1.0], [1.0]])
        pixel_from_world = pixel_from_clip(size) @ camera.clip_from_world
        projection = (pixel_from_world @ textures.world_from_plane.reshape(4, -1)).reshape(3, 4, count)
        homography = projection[:, [0, 1, 3]]
        depth_row = np.concatenate([homography[2], (projection[2] * textures.source).sum(axis=0, keepdims=True)])
        corner = np.minimum(depth_row[:2] * textures.extent, 0.0)
        lowest = depth_row[2] + corner[0] + corner[1] + np.minimum(depth_row[3] * textures.deepest, 0.0)
        K = warp_coefficients(textures.source.T, eye.T)[1].T
        return cls(K, homography, _determinant(homography), depth_row, before & (lowest > 0.0))

    def shift(self, relief: np.ndarray) -> np.ndarray:
        """(…, T) `δ/(1 + K₃ δ)`: times `(K₁ − u K₃)` it is the warped place minus the place."""
        return relief / (1.0 + self.K[2] * relief)

    def area_scale(self, owner: np.ndarray, uv: np.ndarray, near: np.ndarray, far: np.ndarray) -> np.ndarray:
        """(E,) pixels per unit of `(K₁ − u K₃)(δ_fg − δ_bg)`: `det H / (W_fg W_bg W_mean)`, W the w of the texel at that relief.

        The warp divides the opening by (1 + K₃δ) of both texels and the edge's length by that of their mean, and the homography magnifies
        areas by det H / w³ at the warped place; the factors join to W = w·(1 + K₃δ), the w of the texel's own point.
        """
        row = self.depth_row[:, owner]
        flat = row[0] * uv[:, 0] + row[1] * uv[:, 1] + row[2]
        w_near, w_far = flat + row[3] * near, flat + row[3] * far
        return self.determinant[owner] / np.where(self.valid[owner], w_near * w_far * 0.5 * (w_near + w_far), 1.0)


def _determinant(m: np.ndarray) -> np.ndarray:
    """(T,) determinants of (3, 3, T): the first row times the cross product of the others."""
    return (
        m[0, 0] * (m[1, 1] * m[2, 2] - m[1, 2] * m[2, 1])
        + m[0, 1] * (m[1, 2] * m[2, 0] - m[1, 0] * m[2, 2])
        + m[0, 2] * (m[1, 0] * m[2, 1] - m[1, 1] * m[2, 0])
    )


def _covered_px(view: _View, textures: ReliefSet) -> np.ndarray:
    """(T,) texels times det H / w³ at the quad's centre, the pixels of a texel there."""
    w = (view.depth_row[:2] * textures.extent).sum(axis=0) / 2.0 + view.depth_row[2]
    return textures.texels * np.maximum(0.0, view.determinant) / np.where(view.valid, w * w * w, 1.0)


def _written(view: _View, pairs: np.ndarray) -> np.ndarray:
    """(R, T) RI 5-7 `E_u² + E_v²` of pairs (6, R, T), with the text's `u₁ − u₂ = 1` in u and in v whatever the pair's direction."""
    u, v, n_u, n_v, near, far = pairs
    k_1, k_2, k_3 = view.K
    near, far = view.shift(near), view.shift(far)
    towards_first, apart, half = n_u + n_v, near - far, 0.5 * k_3 * (near + far)
    error_u = 1.0 + towards_first * ((k_1 - u * k_3) * apart - n_u * half)
    error_v = 1.0 + towards_first * ((k_2 - v * k_3) * apart - n_v * half)
    return (error_u * error_u + error_v * error_v) * np.abs(towards_first)


def _opening_px(view: _View, pairs: np.ndarray) -> np.ndarray:
    """(R, T) pixels by which pairs (6, R, T) come to lie farther apart than neighbours, along their own axis: `max(0, separation − 1)`.

    The gap begins one texel from the warped background texel; its image is `stretch·|H n − (h₃·n) x| / w` with x the image of its
    beginning and w that of its end (method §7).
    """
    u, v, n_u, n_v, near, far = pairs
    k_1, k_2, k_3 = view.K
    near, far = view.shift(near), view.shift(far)
    along = n_u * (k_1 - u * k_3) + n_v * (k_2 - v * k_3)
    stretch = np.maximum(0.0, along * (near - far) - 0.5 * k_3 * (near + far) * (n_u * n_u + n_v * n_v))
    half_u, half_v = 0.5 * n_u, 0.5 * n_v
    u_0, v_0 = u + half_u + far * (k_1 - (u - half_u) * k_3), v + half_v + far * (k_2 - (v - half_v) * k_3)
    x, y, w = (h[0] * u_0 + h[1] * v_0 + h[2] for h in view.homography)
    d_x, d_y, d_w = (h[0] * n_u + h[1] * n_v for h in view.homography)
    w = np.where(w > 0.0, w, 1.0)
    end = w + stretch * d_w
    turned = d_w / w
    across_x, across_y = d_x - turned * x, d_y - turned * y
    return stretch * np.sqrt(across_x * across_x + across_y * across_y) / np.where(end > 0.0, end, 1.0)


def _edge_terms(view: _View, edges: np.ndarray, owner: np.ndarray) -> np.ndarray:
    """(E,) signed pixels that open behind each edge (E, 8): width
    `max(0, (s_fg − s_bg)(p − e)·n − rest·(s_fg + s_bg)/2)` times its texels of length."""
    K = view.K.T[owner]
    uv, near, far, rest = edges[:, :2], edges[:, 4], edges[:, 5], edges[:, 6]
    along = ((K[:, :2] - uv * K[:, 2:]) * edges[:, 2:4]).sum(axis=1)
    return (
        edges[:, 7]
        * np.maximum(0.0, along * (near - far) - rest * (1.0 + 0.5 * K[:, 2] * (near + far)))
        * view.area_scale(owner, uv, near, far)
    )


def _edge_sum_px(view: _View, edges: np.ndarray, owner: np.ndarray) -> np.ndarray:
    """(T,) sums of `_edge_terms`."""
    return np.maximum(0.0, np.bincount(owner, _edge_terms(view, edges, owner), minlength=len(view.valid)))


def _edge_fast_px(view: _View, textures: ReliefSet) -> np.ndarray:
    """(T,) the edge sum strip by strip: all edges of a strip that face one way share their mean place and relief.

    Between the shifts `SHIFTS[j] = SHIFTS[1]·j²` the sums are interpolated, beyond the last they grow as fast as they can.
    """
    mass, u, v, relief = textures.means
    k_1, k_2, k_3 = view.K * textures.unit
    tangent = np.empty_like(mass)
    tangent[0], tangent[2] = k_1 - u[0] * k_3, k_2 - v[2] * k_3
    tangent[1], tangent[3] = u[1] * k_3 - k_1, v[3] * k_3 - k_2
    tangent = np.maximum(tangent, 0.0)
    within = np.minimum(tangent, SHIFTS[-1])
    steps = within / SHIFTS[1]
    below = np.minimum(np.floor(np.sqrt(steps)), len(SHIFTS) - 2.0)
    place = textures.strips + below.astype(textures.strips.dtype)
    share = (steps - below * below) / (2.0 * below + 1.0)
    width = (1.0 - share) * textures.sums.take(place) + share * textures.sums.take(place + 1) + mass * (tangent - within) / textures.unit
    row = view.depth_row
    w = np.where(view.valid, row[0] * u + row[1] * v + row[2] + row[3] * relief, 1.0)
    return np.maximum(0.0, (width / (w * w * w)).sum(axis=(0, 1)) * view.determinant)
