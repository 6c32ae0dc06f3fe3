"""What the error predictors need of a relief texture, gathered once at its capture: depth edges, critical points, directional sums.

After this no predictor reads the texture again. A *pair* is two neighbouring texels, kept as a row `(u, v, n_u, n_v, near, far)`: their
midpoint, the unit step from the background texel to the foreground texel, and the reliefs δ of foreground and background
(`warp.py` says what δ is). Where the object ends, the background's relief is that of the last surface on the outline's own ray: the
side that a moving eye uncovers. An *edge* is a pair across a depth step with two more numbers. The rest: the texels its two ends lie apart
already, so that they open only once the far one has overtaken the near one. The weight: its length in texels, 1 where it was gathered,
negative for what must be taken off again. There are three sorts, which add up: steps (rest 0), what turns up from behind the outline (the
hull of the last surfaces behind it; rest: the piece's length), and, negative, the end of what a thin part hides: behind a rod there is no
more to uncover than the rod is wide (rest: its width).
Sources: RI §5.5, §5.6 (critical points, N×M regions); edges and sums are our own (method §7).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...errors import SceneError
from ..choices import require
from .outline import STEEPEST, WIDEST, behind_the_outline
from .warp import CaptureFrame, depth_from_relief, relief_from_depth, shift_unit

NO_PAIR = np.zeros(6)
"""Where there is no pair: without a direction it predicts nothing from any eye."""
EMPTY_TEXTURE = "The impostor's texture is empty: the object is hidden, fully transparent or out of view."


@dataclass(frozen=True, slots=True)
class EdgeChoice:
    """`regions` (columns, rows) of RI §5.6; a step is a depth edge when it exceeds its neighbours' slopes by `edge_texels` texels of depth;
    `bins` strips per axis of the directional sums."""

    regions: tuple[int, int] = (4, 4)
    edge_texels: float = 1.5
    bins: int = 8

    def __post_init__(self) -> None:
        require(all(1 <= n <= 64 for n in self.regions), "The regions of an impostor must be 1 to 64 in each direction.")
        require(0.0 < self.edge_texels < 1e6, "The depth edge threshold must be positive.")
        require(1 <= self.bins <= 256, "The directional sums take 1 to 256 strips.")


@dataclass(frozen=True, eq=False)
class ReliefEdges:
    """One texture's precomputation.

    `edges` (E, 8) pairs across depth edges, with rest and weight; `depth_edges` (D, 8) those of the definition, rest 0: the steps on the
    object, and its outline with the back of the part seen. `written` (R, 6) the critical pair of each region as RI takes it (both
    texels on the object), `corrected` (R, 6) the same with the object's outline included; regions without one hold `NO_PAIR`.
    `whole_written`, `whole_corrected` (6,) the critical pair of the texture.
    `sums` (4, bins, N), `totals` (4, bins, 4): the directional sums of the classes (u, +), (u, −), (v, +), (v, −), strip by strip: with g
    the signed relief step along the axis, `totals` is Σ±|g| and the mean u, v and relief weighted by |g|, and `sums` is
    Σ±max(0, |g|·y − rest) at the shifts y = `SHIFTS / shift_unit(frame)` (texels per unit of relief). `texels` the mask holds, `contour`
    the pairs across depth edges on the object and across its outline: about √2 times their length in texels. `choice`, `has_back`: how all
    was gathered; `gathered`: what these were carried over from, when not gathered from this texture itself (`carry.py`).
    """

    frame: CaptureFrame
    edges: np.ndarray
    depth_edges: np.ndarray
    written: np.ndarray
    corrected: np.ndarray
    whole_written: np.ndarray
    whole_corrected: np.ndarray
    sums: np.ndarray
    totals: np.ndarray
    texels: int
    contour: int
    choice: EdgeChoice
    has_back: bool
    gathered: ReliefEdges | None = None

    @property
    def contour_share(self) -> float:
        """Contours per texel of the object: how thin the parts are that its texels show."""
        return self.contour / self.texels


def relief_edges(
    frame: CaptureFrame,
    depth_m: np.ndarray,
    mask: np.ndarray,
    back_m: np.ndarray | None = None,
    choice: EdgeChoice = EdgeChoice(),
    last_m: np.ndarray | None = None,
) -> ReliefEdges:
    """The precomputation for a texture: `depth_m` (h, w) metres behind the plane, `mask` (h, w) bool, `back_m` (h, w) where the part seen
    ends, `last_m` (h, w) the last surface that a ray meets.

    Without `last_m` the part seen is taken for the last one; without `back_m` the bounds' back stands for both. Raises `SceneError` for an
    empty mask and for depths that are not finite.
    """
    mask = np.asarray(mask, bool)
    if mask.shape != (frame.height, frame.width) or np.shape(depth_m) != mask.shape:
        raise SceneError(f"The impostor's depth is {np.shape(depth_m)}, its frame {(frame.height, frame.width)}: capture it again.")
    if not mask.any():
        raise SceneError(EMPTY_TEXTURE)
    depth = np.where(mask, depth_m, 0.0).astype(np.float64)
    back = np.where(mask, frame.depth_m if back_m is None else np.maximum(back_m, depth), 0.0).astype(np.float64)
    last = back if last_m is None else np.where(mask, np.maximum(last_m, back), 0.0).astype(np.float64)
    if not (np.isfinite(depth).all() and np.isfinite(back).all() and np.isfinite(last).all()):
        raise SceneError("The impostor's depth holds values that are not finite: capture it again.")
    axes = [_AxisSteps.along(frame, depth, last, mask, axis, choice.edge_texels) for axis in (0, 1)]
    steps, outline = (np.concatenate([axis.pairs(*at(axis)) for axis in axes]) for at in (lambda a: a.edges, lambda a: a.outline))
    own_back = np.concatenate([axis.outline_before(back) for axis in axes])
    found = [_at_rest(steps), behind_the_outline(frame, depth, back, last, mask, outline)]
    if back_m is not None:
        found.append(_ends_of_the_hidden(frame, depth, back, mask, steps))
    edges = np.concatenate(found)
    written, corrected = (_largest(axes, choice.regions, with_outline=chosen) for chosen in (False, True))
    return ReliefEdges(
        frame,
        edges,
        np.concatenate([edges[: len(steps)], _at_rest(own_back[own_back[:, 4] != own_back[:, 5]])]),
        written[1:],
        corrected[1:],
        written[0],
        corrected[0],
        *directional_sums(frame, edges, choice.bins),
        int(mask.sum()),
        len(steps) + len(outline),
        choice,
        back_m is not None,
    )


@dataclass(frozen=True, eq=False)
class _AxisSteps:
    """All neighbours along `axis` (0: u, 1: v) of a texture; the images' rows run along the axis, a pair's column is its first texel's.

    `step` (rows, columns − 1) metres between the pairs' texels where both lie on the object, −1 elsewhere. `edges`, `outline`: (rows,
    columns) of the pairs across a depth step on the object and of those across its outline; `outline_edges` those of a step behind it.
    """

    frame: CaptureFrame
    axis: int
    depth: np.ndarray
    last: np.ndarray
    mask: np.ndarray
    step: np.ndarray
    edges: tuple[np.ndarray, np.ndarray]
    outline: tuple[np.ndarray, np.ndarray]
    outline_edges: tuple[np.ndarray, np.ndarray]

    @classmethod
    def along(cls, frame: CaptureFrame, depth: np.ndarray, last: np.ndarray, mask: np.ndarray, axis: int, edge_texels: float) -> _AxisSteps:
        """Of images (h, w) that are 0 outside the mask."""
        d, b, m = (depth, last, mask) if axis == 0 else (np.ascontiguousarray(depth.T), last.T, np.ascontiguousarray(mask.T))
        inside, threshold = m[:, :-1] & m[:, 1:], edge_texels * frame.texel_m
        signed = np.where(inside, d[:, 1:] - d[:, :-1], 0.0)
        step = np.where(inside, np.abs(signed), -1.0)
        rows, columns = np.nonzero(step > threshold)
        is_edge = step[rows, columns] - _slope(signed, rows, columns, frame.texel_m) > threshold
        outline = np.nonzero(m[:, :-1] ^ m[:, 1:])
        on = outline[0], outline[1] + ~m[outline]
        behind = b[on] - d[on] > threshold
        edges, outline_edges = (rows[is_edge], columns[is_edge]), (outline[0][behind], outline[1][behind])
        return cls(frame, axis, d, b, m, step, edges, outline, outline_edges)

    def pairs(self, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """(P, 6) the pairs of these rows and columns."""
        first, second = (rows, columns), (rows, columns + 1)
        inside = self.mask[first] & self.mask[second]
        first_near = np.where(inside, self.depth[first] <= self.depth[second], self.mask[first])
        near, far = ((rows, columns + chosen) for chosen in (~first_near, first_near))
        depths = self.depth[near], np.where(inside, self.depth[far], self.last[near])
        sign, zero = np.where(first_near, -1.0, 1.0), np.zeros(len(rows))
        place = (columns + 1.0, rows + 0.5, sign, zero) if self.axis == 0 else (rows + 0.5, columns + 1.0, zero, sign)
        return np.stack([*place, *(relief_from_depth(self.frame.source, d) for d in depths)], axis=-1)

    def outline_before(self, image: np.ndarray) -> np.ndarray:
        """(P, 6) the outline's pairs with the depths of an image (h, w) as their background."""
        return replace(self, last=image if self.axis == 0 else image.T).pairs(*self.outline)

    def with_outline(self) -> np.ndarray:
        """`step` with those of `outline_edges`."""
        rows, columns = self.outline_edges
        on = rows, columns + ~self.mask[rows, columns]
        step = self.step.copy()
        step[rows, columns] = self.last[on] - self.depth[on]
        return step


def _at_rest(pairs: np.ndarray) -> np.ndarray:
    """(P, 8) edges of a texel's length without a rest."""
    return np.column_stack([pairs, np.zeros(len(pairs)), np.ones(len(pairs))])


def _slope(signed: np.ndarray, rows: np.ndarray, columns: np.ndarray, texel_m: float) -> np.ndarray:
    """(P,): the part of steps along rows that a surface explains: how far their neighbours along the row step the same way.

    `signed` (h, w − 1) all steps, 0 across the outline. A wall of up to `STEEPEST` texels of depth per texel needs to go on at one side
    (its end at a crease is no edge); what is steeper must go on at both, lest the two halves of an edge that happens to pass over one
    texel in the middle explain each other.
    """
    direction, last = np.sign(signed[rows, columns]), signed.shape[1] - 1
    before = np.where(columns > 0, signed[rows, np.maximum(columns - 1, 0)], 0.0) * direction
    after = np.where(columns < last, signed[rows, np.minimum(columns + 1, last)], 0.0) * direction
    one_side = np.maximum(before, after)
    return np.maximum(0.0, np.where(one_side <= STEEPEST * texel_m, one_side, np.minimum(before, after)))


def _largest(axes: list[_AxisSteps], regions: tuple[int, int], *, with_outline: bool) -> np.ndarray:
    """(1 + columns × rows, 6): the pair with the largest step (the first of equals) of the texture, then in each region of RI §5.6, row by
    row; `NO_PAIR` where there is none. A pair lies where its midpoint does."""
    count = regions[0] * regions[1]
    best, found = np.full(count, -1.0), np.zeros((count, 3), int)
    for axis in axes:
        step = axis.with_outline() if with_outline else axis.step
        along = _strips(np.arange(1.0, step.shape[1] + 1.0), step.shape[1] + 1, regions[axis.axis])
        across = _strips(np.arange(0.5, step.shape[0]), step.shape[0], regions[1 - axis.axis])
        for i, j in np.ndindex(len(across), len(along)):
            block = np.ascontiguousarray(step[across[i], along[j]])
            if block.size:
                row, column = divmod(int(block.argmax()), block.shape[1])
                region = i * regions[0] + j if axis.axis == 0 else j * regions[0] + i
                if block[row, column] > best[region]:
                    best[region] = block[row, column]
                    found[region] = axis.axis, across[i].start + row, along[j].start + column
    first = np.lexsort((*found.T[::-1], -best))[0]
    best, found = np.append(best[first], best), np.vstack([found[first], found])
    out = np.tile(NO_PAIR, (1 + count, 1))
    for axis in axes:
        chosen = (best >= 0.0) & (found[:, 0] == axis.axis)
        out[chosen] = axis.pairs(*found[chosen, 1:].T)
    return out


def _strips(places: np.ndarray, extent: int, count: int) -> list[slice]:
    """Which of rising `places` lie in each of `count` equal parts of 0…`extent`."""
    bounds = np.searchsorted(np.minimum((places / extent * count).astype(int), count - 1), np.arange(count + 1))
    return [slice(*pair) for pair in zip(bounds[:-1], bounds[1:], strict=True)]


def _ends_of_the_hidden(frame: CaptureFrame, depth: np.ndarray, back: np.ndarray, mask: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """(H, 8) negative edges from steps (S, 6): how far the back of the foreground has moved on past the far end of what it hid.

    The width of the foreground is counted in texels from the step until something as deep as the background is seen again; parts wider than
    `WIDEST` texels hide more than a useful tilt uncovers.
    """
    inwards = steps[:, 2:4].astype(int)
    start = np.floor(steps[:, :2] + steps[:, 2:4] / 2.0).astype(int)
    background = depth_from_relief(frame.source, steps[:, 5])
    behind = np.minimum(back[start[:, 1], start[:, 0]], background)
    padded = np.pad(np.where(mask, depth, np.inf), WIDEST, constant_values=np.inf)
    place, stride = (start + WIDEST) @ [1, padded.shape[1]], inwards @ [1, padded.shape[1]]
    width, going = np.zeros(len(steps), int), np.arange(len(steps))
    for reached in range(WIDEST):
        going = going[padded.ravel()[place[going] + stride[going] * reached] < background[going]]
        width[going] = reached + 1
        if not len(going):
            break
    ended = (width < WIDEST) & (behind < background)
    reliefs = [relief_from_depth(frame.source, d[ended]) for d in (behind, background)]
    half = (inwards * width[:, None] / 2.0)[ended]
    return np.column_stack([steps[ended, :2] + half, inwards[ended], *reliefs, width[ended], np.full(ended.sum(), -1.0)])


SHIFTS = 2.0 * np.linspace(0.0, 1.0, 65) ** 2
"""Where the directional sums are tabulated: tangents of the angle by which the view ray has turned, denser where that is small; beyond,
they go on linearly."""

ON_BORDER = 1e-6
"""Share of a strip: what lies less before a strip's end lies on the border and belongs to the next. Places are halves of texels, so none
lies as near without lying on it; but a place that was carried to another frame and back is off by rounding."""


def directional_sums(frame: CaptureFrame, edges: np.ndarray, bins: int) -> tuple[np.ndarray, np.ndarray]:
    """`sums`, `totals` of `ReliefEdges`. Every edge opens along one axis, from the shift on at which its ends pass each other."""
    shifts = SHIFTS / shift_unit(frame)
    step = np.abs(edges[:, 4] - edges[:, 5])
    chosen = edges[step > 0.0]
    step, axis = step[step > 0.0], (chosen[:, 3] != 0.0).astype(int)
    side = chosen[np.arange(len(chosen)), 2 + axis] * (chosen[:, 4] - chosen[:, 5]) < 0.0
    extent = np.array([frame.width, frame.height])[axis]
    strip = np.clip((chosen[np.arange(len(chosen)), axis] / extent * bins + ON_BORDER).astype(int), 0, bins - 1)
    group, count = (2 * axis + side) * bins + strip, 4 * bins

    def total(weight: np.ndarray) -> np.ndarray:
        return np.bincount(group, weight, minlength=count)

    means = [chosen[:, 0], chosen[:, 1], (chosen[:, 4] + chosen[:, 5]) / 2.0]
    signed = step * chosen[:, 7]
    mass = np.abs(signed)
    weights = total(mass)
    totals = np.stack([total(signed), *(total(mass * m) / np.where(weights > 0.0, weights, 1.0) for m in means)], axis=-1)
    cell = group * (len(shifts) + 1) + np.searchsorted(shifts, chosen[:, 6] / step, side="right")
    mass, rest = (
        np.bincount(cell, weight, minlength=count * (len(shifts) + 1)).reshape(count, -1)[:, :-1].cumsum(axis=1)
        for weight in (signed, chosen[:, 6] * chosen[:, 7])
    )
    return (mass * shifts - rest).reshape(4, bins, -1), totals.reshape(4, bins, 4)
