"""What became of the marks in a picture, as panels, overlays and reports show it. No bpy."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ...maths.relief.edges import ReliefEdges
    from ...pipeline.frame import ImpostorReport

STATES = {
    "sprite": "As captured",
    "warp": "Warped",
    "regenerated": "Just captured",
    "geometry": "Geometry",
    "hidden": "Out of view",
}
"""What the stages of the life cycle are called."""
WORST_FIRST = ("geometry", "regenerated", "warp", "sprite", "hidden")
CROSS_SHARE = 0.012
CROSS, GRID = (1.0, 0.1, 0.05), (1.0, 1.0, 1.0)
PAPER = (0.18, 0.18, 0.2)


@dataclass(frozen=True, slots=True)
class MarkState:
    """What became of a mark in the last picture, its copies taken together: the worst of each.

    `error` is what is predicted of the texture shown (None without one, infinite where it cannot be used), `limit` its limit.
    """

    stage: str
    reason: str
    error: float | None
    limit: float
    age: int
    bytes: int
    size: tuple[int, int]
    triangles: int
    copies: int


def states(reports: Iterable[ImpostorReport]) -> dict[tuple[str, int], MarkState]:
    """The state of every mark that the last picture knew, by its kind and number."""
    members: dict[tuple[str, int], list[ImpostorReport]] = {}
    for report in reports:
        members.setdefault((report.key.kind, report.key.uid), []).append(report)
    return {key: _together(copies) for key, copies in members.items()}


def _together(copies: list[ImpostorReport]) -> MarkState:
    worst = min(copies, key=lambda r: WORST_FIRST.index(r.stage))
    errors = [r.error for r in copies if r.error is not None]
    return MarkState(
        worst.stage,
        worst.reason,
        max(errors, default=None),
        worst.limit,
        max(r.age for r in copies),
        sum(r.bytes for r in copies),
        max(r.size for r in copies),
        sum(r.triangles for r in copies),
        len(copies),
    )


def critical_places(edges: ReliefEdges) -> tuple[np.ndarray, np.ndarray]:
    """((P, 2) u, v; (P, 3) world points relative to the local origin) of the near texel of each region's critical pair."""
    pairs = edges.corrected[np.any(edges.corrected[:, 2:4] != 0.0, axis=1)]
    near = pairs[:, :2] + 0.5 * pairs[:, 2:4]
    return near, edges.frame.points_ws(near, pairs[:, 4])


def quad_corners(edges: ReliefEdges) -> np.ndarray:
    """(4, 3) corners of the texture's quad, round it, relative to the local origin."""
    frame = edges.frame
    uv = np.array([[0, 0], [frame.width, 0], [frame.width, frame.height], [0, frame.height]], float)
    return frame.points_ws(uv, np.zeros(4))


def annotated(picture: np.ndarray, edges: ReliefEdges, regions: tuple[int, int]) -> np.ndarray:
    """The texture's picture (h, w, 4; premultiplied) on dark paper with the regions' borders and a cross on each critical point."""
    height, width = picture.shape[:2]
    out = picture.copy()
    out[..., :3] += (1.0 - picture[..., 3:]) * np.array(PAPER, np.float32)
    out[..., 3] = 1.0
    for axis, (count, extent) in enumerate(zip(regions, (width, height), strict=True)):
        lines = (np.arange(1, count) * extent / count).astype(int)
        part = out[:, lines] if axis == 0 else out[lines]
        faint = 0.75 * part[..., :3] + 0.25 * np.array(GRID, np.float32)
        if axis == 0:
            out[:, lines, :3] = faint
        else:
            out[lines, :, :3] = faint
    reach = max(4, round(CROSS_SHARE * max(width, height)))
    for u, v in critical_places(edges)[0]:
        _cross(out, int(u), int(v), reach)
    return out


def _cross(image: np.ndarray, column: int, row: int, reach: int) -> None:
    """A cross of two bars with a dark rim."""
    for rim, color in ((1, (0.0, 0.0, 0.0)), (0, CROSS)):
        for across, down in ((reach + rim, 1 + rim), (1 + rim, reach + rim)):
            y, x = max(row - down, 0), max(column - across, 0)
            image[y : row + down + 1, x : column + across + 1, :3] = color
