"""What the error predictors need of a relief texture, gathered once at its capture: depth edges, critical points, directional sums.

After this no predictor reads the texture again. A *pair* is two neighbouring texels, kept as a row `(u, v, n_u, n_v, near, far)`: their
midpoint, the unit step from the background texel to the foreground texel, and the reliefs δ of foreground and background
(`relief.py` says what δ is). Where the object ends, the background's relief is that of the last surface on the outline's own ray: the
side that a moving eye uncovers. An *edge* is a pair across a depth step with two more numbers. The rest: the texels its two ends lie apart
already, so that they open only once the far one has overtaken the near one. The sign: +1 what comes into view, −1 what must be taken off
again. There are three sorts, which add up: steps (rest 0), what turns up from behind the outline (the hull of the last surfaces behind it;
rest: the piece's length), and, negative, the end of what a thin part hides: behind a rod there is no more to uncover than the rod is
wide (rest: its width).
Sources: RI §5.5, §5.6 (critical points, N×M regions); edges and sums are our own (research/impostors.md §6).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from .choices import require
from .relief import CaptureFrame, depth_from_relief, relief_from_depth, shift_unit
from .relief_outline import STEEPEST, WIDEST, behind_the_outline

NO_PAIR = np.zeros(6)
"""Where there is no pair: without a direction it predicts nothing from any eye."""


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

    `edges` (E, 8) pairs across depth edges, with rest and sign. `written` (R, 6) the critical pair of each region as RI takes it (both
    texels on the object), `corrected` (R, 6) the same with the object's outline included; regions without one hold `NO_PAIR`.
    `whole_written`, `whole_corrected` (6,) the critical pair of the texture.
    `sums` (4, bins, N), `totals` (4, bins, 4): the directional sums of the classes (u, +), (u, −), (v, +), (v, −), strip by strip: with g
    the signed relief step along the axis, `totals` is Σ±|g| and the mean u, v and relief weighted by |g|, and `sums` is
    Σ±max(0, |g|·y − rest) at the shifts y = `SHIFTS / shift_unit(frame)` (texels per unit of relief). `texels` the mask holds, `contour`
    the pairs across depth edges on the object and across its outline: about √2 times their length in texels.
    """

    frame: CaptureFrame
    edges: np.ndarray
    written: np.ndarray
    corrected: np.ndarray
    whole_written: np.ndarray
    whole_corrected: np.ndarray
    sums: np.ndarray
    totals: np.ndarray
    texels: int
    contour: int

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
        raise SceneError("The impostor's texture is empty: the object is hidden, fully transparent or out of view.")
    depth = np.where(mask, depth_m, 0.0).astype(np.float64)
    back = np.where(mask, frame.depth_m if back_m is None else np.maximum(back_m, depth), 0.0).astype(np.float64)
    last = back if last_m is None else np.where(mask, np.maximum(last_m, back), 0.0).astype(np.float64)
    if not (np.isfinite(depth).all() and np.isfinite(back).all() and np.isfinite(last).all()):
        raise SceneError("The impostor's depth holds values that are not finite: capture it again.")
    pairs, step, is_edge, is_inside = (
        np.concatenate(parts)
        for parts in zip(*(_axis_pairs(frame, depth, last, mask, axis, choice.edge_texels) for axis in (0, 1)), strict=True)
    )
    region = _regions(frame, pairs, choice.regions)
    steps = pairs[is_edge & is_inside]
    edges = [np.column_stack([steps, np.zeros(len(steps)), np.ones(len(steps))])]
    edges.append(behind_the_outline(frame, depth, back, last, mask, pairs[~is_inside]))
    if back_m is not None:
        edges.append(_ends_of_the_hidden(frame, depth, back, mask, steps))
    edges = np.concatenate(edges)
    corrected = is_edge | is_inside
    sums, totals = _directional_sums(frame, edges, choice.bins)
    count = choice.regions[0] * choice.regions[1]
    return ReliefEdges(
        frame,
        edges,
        _largest(pairs[is_inside], step[is_inside], region[is_inside], count),
        _largest(pairs[corrected], step[corrected], region[corrected], count),
        _largest(pairs[is_inside], step[is_inside], np.zeros(is_inside.sum(), int), 1)[0],
        _largest(pairs[corrected], step[corrected], np.zeros(corrected.sum(), int), 1)[0],
        sums,
        totals,
        int(mask.sum()),
        int((is_edge | ~is_inside).sum()),
    )


def _axis_pairs(
    frame: CaptureFrame, depth: np.ndarray, last: np.ndarray, mask: np.ndarray, axis: int, edge_texels: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """(pairs, step in metres, is a depth edge, both on the object) of all neighbours along `axis` (0: u, 1: v) that touch the object."""
    d, b, m = (x if axis == 0 else x.T for x in (depth, last, mask))
    first, second = (d[:, :-1], b[:, :-1], m[:, :-1]), (d[:, 1:], b[:, 1:], m[:, 1:])
    inside = first[2] & second[2]
    outline = first[2] ^ second[2]
    first_near = np.where(inside, first[0] <= second[0], first[2])
    near = np.where(first_near, first[0], second[0])
    far = np.where(inside, np.where(first_near, second[0], first[0]), np.where(first_near, first[1], second[1]))
    step = np.where(inside | outline, far - near, 0.0)
    threshold = edge_texels * frame.texel_m
    is_edge = np.where(inside, step - _slope(d, m, frame.texel_m) > threshold, step > threshold) & (inside | outline)
    rows, columns = np.nonzero(inside | outline)
    here = (rows, columns)
    sign = np.where(first_near[here], -1.0, 1.0)
    along, across = columns + 1.0, rows + 0.5
    zero = np.zeros_like(sign)
    place = (along, across, sign, zero) if axis == 0 else (across, along, zero, sign)
    reliefs = (relief_from_depth(frame.source, near[here]), relief_from_depth(frame.source, far[here]))
    return np.stack([*place, *reliefs], axis=-1), step[here], is_edge[here], inside[here]


def _slope(depth: np.ndarray, mask: np.ndarray, texel_m: float) -> np.ndarray:
    """(h, w − 1): the part of every step along a row that a surface explains: how far its neighbours along the row step the same way.

    A wall of up to `STEEPEST` texels of depth per texel needs to go on at one side (its end at a crease is no edge); what is steeper must
    go on at both, lest the two halves of an edge that happens to pass over one texel in the middle explain each other.
    """
    known = mask[:, 1:] & mask[:, :-1]
    signed = np.where(known, np.diff(depth, axis=1), 0.0)
    padded, direction = np.pad(signed, ((0, 0), (1, 1))), np.sign(signed)
    before, after = padded[:, :-2] * direction, padded[:, 2:] * direction
    one_side = np.maximum(before, after)
    return np.maximum(0.0, np.where(one_side <= STEEPEST * texel_m, one_side, np.minimum(before, after)))


def _regions(frame: CaptureFrame, pairs: np.ndarray, regions: tuple[int, int]) -> np.ndarray:
    """(P,) index of the region of RI §5.6 in which every pair's midpoint lies, row by row."""
    cell = (pairs[:, :2] / [frame.width, frame.height] * regions).astype(int)
    cell = np.minimum(cell, np.array(regions) - 1)
    return cell[:, 1] * regions[0] + cell[:, 0]


def _largest(pairs: np.ndarray, step: np.ndarray, region: np.ndarray, count: int) -> np.ndarray:
    """(count, 6): the pair with the largest step in each region (the first of equals), `NO_PAIR` where there is none."""
    out = np.tile(NO_PAIR, (count, 1))
    order = np.argsort(-step, kind="stable")
    found, first = np.unique(region[order], return_index=True)
    out[found] = pairs[order[first]]
    return out


def _ends_of_the_hidden(frame: CaptureFrame, depth: np.ndarray, back: np.ndarray, mask: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """(H, 8) negative edges from steps (S, 6): how far the back of the foreground has moved on past the far end of what it hid.

    The width of the foreground is counted in texels from the step until something as deep as the background is seen again; parts wider than
    `WIDEST` texels hide more than a useful tilt uncovers.
    """
    inwards = steps[:, 2:4].astype(int)
    start = np.floor(steps[:, :2] + steps[:, 2:4] / 2.0).astype(int)
    background = depth_from_relief(frame.source, steps[:, 5])
    behind = np.minimum(back[start[:, 1], start[:, 0]], background)
    covering = np.where(mask, depth, np.inf)
    padded = np.pad(covering, WIDEST, constant_values=np.inf)
    width, going = np.zeros(len(steps), int), np.arange(len(steps))
    while len(going) and width.max() < WIDEST:
        place = start[going] + inwards[going] * width[going, None] + WIDEST
        going = going[padded[place[:, 1], place[:, 0]] < background[going]]
        width[going] += 1
    ended = (width < WIDEST) & (behind < background)
    reliefs = [relief_from_depth(frame.source, d[ended]) for d in (behind, background)]
    half = (inwards * width[:, None] / 2.0)[ended]
    return np.column_stack([steps[ended, :2] + half, inwards[ended], *reliefs, width[ended], np.full(ended.sum(), -1.0)])


SHIFTS = 2.0 * np.linspace(0.0, 1.0, 65) ** 2
"""Where the directional sums are tabulated: tangents of the angle by which the view ray has turned, denser where that is small; beyond,
they go on linearly."""


def _directional_sums(frame: CaptureFrame, edges: np.ndarray, bins: int) -> tuple[np.ndarray, np.ndarray]:
    """`sums`, `totals` of `ReliefEdges`."""
    sums, totals = np.zeros((4, bins, len(SHIFTS))), np.zeros((4, bins, 4))
    shifts = SHIFTS / shift_unit(frame)
    for axis, extent in enumerate((frame.width, frame.height)):
        weight = edges[:, 2 + axis] * (edges[:, 4] - edges[:, 5])
        strip = np.minimum((edges[:, axis] / extent * bins).astype(int), bins - 1)
        for side in (0, 1):
            for cell in range(bins):
                chosen = edges[((weight < 0.0) if side else (weight > 0.0)) & (strip == cell)]
                if not len(chosen):
                    continue
                step = np.abs(chosen[:, 4] - chosen[:, 5])
                mean = step @ np.column_stack([chosen[:, :2], chosen[:, 4:6].mean(axis=1)]) / step.sum()
                totals[2 * axis + side, cell] = [step @ chosen[:, 7], *mean]
                order = np.argsort(chosen[:, 6] / step)
                upto = np.searchsorted((chosen[:, 6] / step)[order], shifts)
                signed = np.column_stack([step, chosen[:, 6]])[order] * chosen[order, 7:]
                mass, rest = np.concatenate([np.zeros((1, 2)), np.cumsum(signed, axis=0)])[upto].T
                sums[2 * axis + side, cell] = mass * shifts - rest
    return sums, totals
