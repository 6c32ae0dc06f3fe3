"""What the predictors need of a relief texture, taken over by a new capture of the same object from nearer instead of gathered again.

An eye that comes nearer needs finer texels, but it sees the same edges: each is moved, as the points in space that its two ends are, into
the new capture's frame. RI §5.1 asks for it ("reusing what is already there"); how is our own. What the coarser capture did not resolve is
not in them, so `carries` allows it only up to a multiple of the resolution and while next to nothing has come into view since the
gathering. No GPU.
"""

from __future__ import annotations

from dataclasses import replace
from math import cos, inf, radians

import numpy as np

from ...errors import SceneError
from .edges import EMPTY_TEXTURE, ReliefEdges, directional_sums
from .error import predict, relief_set
from .warp import CaptureFrame

FINER, FINEST = 1.04, 2.5
"""By how much the new capture must be finer than the last, and may be finer than that of the gathering: new texels to an old one. Over six
random machines × three eyes, carried predictions are within 18, 27 and 37 % of fresh ones at 1.5, 2.2 and 2.7 (docs/laboratory.md)."""
OPENED = 0.02
"""Share of the new texels that may have opened since the gathering, by its own prediction."""
SMALLEST_COSINE = cos(radians(5.0))
"""The frames' axes may differ by this: an edge is taken for one along its old axis."""


def carries(edges: ReliefEdges, frame: CaptureFrame) -> bool:
    """Whether the last texture's `edges` may serve a new one on `frame`, a capture of the same object: see the constants above."""
    first = edges.gathered or edges
    if first.frame.is_perspective != frame.is_perspective or not _axes_agree(first.frame, frame):
        return False
    if not (_growth(edges.frame, frame) >= FINER and _growth(first.frame, frame) <= FINEST):
        return False
    found = predict(relief_set([first]), frame.camera(), (frame.width, frame.height), exact=False)
    opened, covered = (float(found[name][0]) for name in ("edge_fast_px", "covered_px"))
    return opened < inf and opened <= OPENED * covered


def carried(edges: ReliefEdges, frame: CaptureFrame, texels: int) -> ReliefEdges:
    """`edges` in the frame of a new capture whose mask holds `texels`, always from those once gathered: errors do not add up.

    A piece of one old texel's length is k new texels long (its last column); its rest is what its ends lie apart, as the new eye sees them.
    A step's ends lie together again, where the nearer one is seen: what the step hid just now is in the new texture. A piece from behind
    the outline that has come into view is dropped. Critical pairs stay those of their regions. Raises `SceneError` for an empty mask.
    """
    if not texels:
        raise SceneError(EMPTY_TEXTURE)
    first = edges.gathered or edges
    moved, depth_edges = (_moved(first.frame, edges, frame) for edges in (first.edges, first.depth_edges))
    written, corrected = (
        _moved_pairs(first, np.vstack(pairs), frame)
        for pairs in ((first.whole_written, first.written), (first.whole_corrected, first.corrected))
    )
    sums, totals = directional_sums(frame, moved, first.choice.bins)
    contour = round(first.contour * _growth(first.frame, frame))
    whole = {"whole_written": written[0], "whole_corrected": corrected[0], "written": written[1:], "corrected": corrected[1:]}
    return replace(
        first,
        frame=frame,
        edges=moved,
        depth_edges=depth_edges,
        sums=sums,
        totals=totals,
        texels=texels,
        contour=contour,
        gathered=first,
        **whole,
    )


def _axes_agree(first: CaptureFrame, second: CaptureFrame) -> bool:
    axes = (f.world_from_plane[:3, :3] / np.linalg.norm(f.world_from_plane[:3, :3], axis=0) for f in (first, second))
    return bool(np.einsum("ij,ij->j", *axes).min() >= SMALLEST_COSINE)


def _growth(old: CaptureFrame, new: CaptureFrame) -> float:
    """New texels to one old texel in the middle of the old bounds."""
    ends = old.centre_uv + np.array([[-0.5, 0.0], [0.5, 0.0]])
    seen = new.texels(old.points_ws(ends, np.full(2, old.deepest_relief / 2.0)))[0]
    return float(np.linalg.norm(seen[1] - seen[0]))


def _moved(old: CaptureFrame, edges: np.ndarray, frame: CaptureFrame) -> np.ndarray:
    """(E, 8) edges of the frame `old` in another, without those that have opened there and had a rest."""
    middle, normal, reliefs, rest = edges[:, :2], edges[:, 2:4], edges[:, 4:6].T, edges[:, 6]
    half = normal * rest[:, None] / 2.0
    (near_uv, near), (far_uv, far) = (
        frame.texels(old.points_ws(middle + end, relief)) for end, relief in zip((-half, half), reliefs, strict=True)
    )
    tangent = normal[:, ::-1] * [-0.5, 0.5]
    lengths = [
        np.linalg.norm(np.subtract(*(frame.texels(old.points_ws(middle + side * tangent, relief))[0] for side in (-1, 1))), axis=1)
        for relief in reliefs
    ]
    apart = ((far_uv - near_uv) * normal).sum(axis=1)
    is_step = rest == 0.0
    place = np.where(is_step[:, None], near_uv, (near_uv + far_uv) / 2.0)
    weight = edges[:, 7] * (lengths[0] + lengths[1]) / 2.0
    moved = np.column_stack([place, normal, near, far, np.where(is_step, 0.0, apart), weight])
    return moved[is_step | (apart > 0.0)]


def _moved_pairs(first: ReliefEdges, pairs: np.ndarray, frame: CaptureFrame) -> np.ndarray:
    """(R, 6) critical pairs in another frame: neighbours there, where the nearer texel's border is seen; rows without a pair stay so."""
    place, near = frame.texels(first.frame.points_ws(pairs[:, :2], pairs[:, 4]))
    far = frame.texels(first.frame.points_ws(pairs[:, :2], pairs[:, 5]))[1]
    moved = np.column_stack([place, pairs[:, 2:4], near, far])
    return np.where(pairs[:, 2:4].any(axis=1, keepdims=True), moved, pairs)
