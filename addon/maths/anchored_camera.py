"""A camera as the vertex stage is given it: for places relative to an anchor near what is seen, so that nothing large cancels. No GPU.

A float32 matrix loses 6e-8 of the distances that it takes away from one another: of the scene's size with places relative to the scene's
origin, of what is seen itself with places relative to the middle of the near plane.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .depth_projection import DepthProjection, fitted, whole
from .frusta import box_distances
from .view import Camera

LARGE = 8.0
"""A triangle is large whose longest edge is so many times its distance: what is rounded at its corners shows in its middle."""


@dataclass(frozen=True, eq=False)
class AnchoredCamera:
    """`camera` with the depth projection it is drawn with, about `anchor_ws` (3,), float32 numbers near the middle of the near plane."""

    camera: Camera
    depth: DepthProjection

    @classmethod
    def of(cls, camera: Camera, bounds_ws: np.ndarray | None = None) -> AnchoredCamera:
        """Fitted to boxes (B, 2, 3), or with the camera's own near and far."""
        return cls(camera, whole(camera) if bounds_ws is None else fitted(camera, bounds_ws))

    @cached_property
    def world_from_view(self) -> np.ndarray:
        """(4, 4) float64."""
        return self.camera.world_from_view

    @cached_property
    def anchor_ws(self) -> np.ndarray:
        """(3,) float64 that hold float32 numbers."""
        return self.camera.anchor_ws(self.depth.near)

    @cached_property
    def rows_ws(self) -> np.ndarray:
        """(3, 4): clip x, clip y and metres behind the near plane of a place in the world."""
        clip, view = self.camera.clip_from_world, self.camera.view_from_world
        rows = np.stack([clip[0], clip[1], -view[2]])
        rows[2, 3] -= self.depth.near
        return rows

    @cached_property
    def rows(self) -> np.ndarray:
        """(3, 4): the same of a place relative to the anchor."""
        rows = self.rows_ws.copy()
        rows[:, 3] += rows[:, :3] @ self.anchor_ws
        return rows

    @property
    def least_large_m(self) -> float:
        """No triangle with shorter edges is large: `LARGE` times the near plane's distance, or the longer side of a parallel picture."""
        is_parallel = self.camera.is_orthographic
        return LARGE * (2.0 / float(np.abs(np.diag(self.camera.clip_from_view)[:2]).min()) if is_parallel else self.depth.near)

    def is_large(self, bounds_ws: np.ndarray, longest_edge_m: np.ndarray) -> np.ndarray:
        """(B,) bool: whether boxes (B, 2, 3) with edges up to `longest_edge_m` (B,) may hold a triangle `LARGE` for this view."""
        large = longest_edge_m > self.least_large_m
        if not self.camera.is_orthographic:
            large &= longest_edge_m > LARGE * box_distances(bounds_ws, self.world_from_view[:3, 3])
        return large
