"""Back faces of closed meshes are left out: which way they are wound in a target, and for what that holds. Worker thread only."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import moderngl
import numpy as np

from ...maths.spaces import linear


@dataclass(frozen=True, slots=True)
class Culling:
    """Back faces of closed meshes are not drawn. `front`: how front faces are wound in the target, 'ccw' or 'cw'; `plane` (4,): only of
    what lies all before it, plane·(x, 1) > 0: what the near plane cuts open, or what holds the eye, shows its inside."""

    front: str
    plane: np.ndarray

    @classmethod
    def by(cls, clip_from_world: np.ndarray, *, near: bool) -> Culling:
        """That of a projection whose depth grows away from where it looks from; `near`: what lies before its near plane is cut off.

        A matrix that turns space over, as a camera's does, keeps the winding that is seen.
        """
        rows = np.asarray(clip_from_world, np.float64)
        return cls("ccw" if np.linalg.det(rows) < 0.0 else "cw", rows[3] + rows[2] if near else rows[3])

    def allows(self, bounds_ws: np.ndarray) -> np.ndarray:
        """(B,) bool: boxes (B, 2, 3) wholly before the plane."""
        low, high = bounds_ws[:, 0], bounds_ws[:, 1]
        return linear(self.plane[:3], np.where(self.plane[:3] > 0.0, low, high).T) + self.plane[3] > 0.0


@contextmanager
def back_faces_left_out(context: moderngl.Context, culling: Culling | None, *, mirrored: bool = False) -> Iterator[None]:
    """While this lasts, if `culling` is given."""
    if culling is None:
        yield
        return
    other = {"ccw": "cw", "cw": "ccw"}
    context.front_face = other[culling.front] if mirrored else culling.front
    context.enable(moderngl.CULL_FACE)
    try:
        yield
    finally:
        context.disable(moderngl.CULL_FACE)
        context.front_face = "ccw"
