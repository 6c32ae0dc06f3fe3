"""The camera pass: view depth, shading normal and triangle id at every pixel centre. Worker thread only."""

from __future__ import annotations

from collections.abc import Hashable
from contextlib import ExitStack

import moderngl
import numpy as np

from ...maths.anchored_camera import AnchoredCamera
from ...maths.depth_projection import DepthProjection
from ...maths.view import Camera
from ..geometry.clusters import frustum_planes, visible
from ..geometry.draw_list import DrawList
from ..gl.allocation import freed_with
from ..gl.depth_buffer import DepthBuffer
from ..gl.programs import Programs
from .surface import SurfaceShader, draw_surfaces

SURFACE = SurfaceShader("gbuffer.frag", {"PEEL": 0})
FROM_TEXTURE = 1 << 31
"""Added to the triangle in `ids` where an impostor drew it: what the view ray meets is near it, and found when shading."""


class GBuffer:
    """Targets of one size: `view_depth` R32F (metres), `normal` RG16 octahedral, `ids` RG32UI (slot + 1, triangle), and a depth buffer.

    `holds` says what was drawn last (scene, camera, instances), by whoever can say; None after `use`. `projection`: of the depths in the
    buffer, None before anything is drawn.
    """

    def __init__(self, context: moderngl.Context, size: tuple[int, int]) -> None:
        self.size = size
        self.view_depth = context.texture(size, 1, dtype="f4")
        self.normal = context.texture(size, 2, dtype="f2")
        self.ids = context.texture(size, 2, dtype="u4")
        for texture in (self.view_depth, self.normal, self.ids):
            texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        with ExitStack() as made:  # freed when what follows fails
            self.depth = freed_with(made, DepthBuffer(context, size))
            self.framebuffer = self.depth.framebuffer([self.view_depth, self.normal, self.ids])
            made.pop_all()
        self.holds: Hashable = None
        self.projection: DepthProjection | None = None

    def use(self) -> None:
        """Bind for drawing: what it held before does not count any more."""
        self.holds = None
        self.framebuffer.use()

    def clear(self, projection: DepthProjection) -> None:
        """Bind, and nothing is seen: the depths to come are those of `projection`."""
        self.use()
        self.projection = projection
        self.framebuffer.clear(depth=projection.farthest)

    def release(self) -> None:
        """Free the targets."""
        for thing in (self.framebuffer, self.view_depth, self.normal, self.ids, self.depth):
            thing.release()


def draw_gbuffer(
    context: moderngl.Context, programs: Programs, target: GBuffer, draw_list: DrawList, camera: Camera, rows: np.ndarray | None = None
) -> int:
    """Draw the scene (or only the instance rows of the mask `rows`) as the camera sees it; returns the triangles sent.

    The depths are fitted to all that the camera can see of the scene, also to what is drawn later in another way (impostors, layers).
    """
    eye = eye_of(draw_list, camera)
    target.clear(eye.depth)
    return draw_surfaces(context, programs, draw_list, eye, SURFACE, target.size, rows, culled=True)


def eye_of(draw_list: DrawList, camera: Camera) -> AnchoredCamera:
    """The camera with depths fitted to all that it can see of the scene."""
    bounds = draw_list.bounds_ws()
    return AnchoredCamera.of(camera, bounds[visible(bounds, frustum_planes(camera.clip_from_world))])


def pixel_rays(camera: Camera, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """(3, 3) matrices M, S: the world point at view depth z behind pixel (x, y) from the bottom left is S·(x, y, 1) + z·M·(x, y, 1).

    Holds for perspective (S constant: the eye) and orthographic (M constant: the view direction) cameras, shift included.
    """
    p, w = camera.clip_from_view, camera.world_from_view
    ndc = np.array([[2.0 / size[0], 0.0, -1.0], [0.0, 2.0 / size[1], -1.0], [0.0, 0.0, 1.0]])
    plane = np.array([[1.0 / p[0, 0], 0.0, 0.0], [0.0, 1.0 / p[1, 1], 0.0]]) @ ndc
    along_vs, start_vs = np.zeros((3, 3)), np.zeros((3, 3))
    along_vs[2, 2] = -1.0
    if camera.is_orthographic:
        start_vs[:2] = plane
        start_vs[:2, 2] -= (p[0, 3] / p[0, 0], p[1, 3] / p[1, 1])
    else:
        along_vs[:2] = plane
        along_vs[:2, 2] += (p[0, 2] / p[0, 0], p[1, 2] / p[1, 1])
    start = w[:3, :3] @ start_vs
    start[:, 2] += w[:3, 3]
    return w[:3, :3] @ along_vs, start


def pixel_from_world(camera: Camera, size: tuple[int, int]) -> np.ndarray:
    """(4, 4): homogeneous pixel coordinates from the bottom left of a world point, the inverse of `pixel_rays`."""
    width, height = size
    viewport = np.array([[0.5 * width, 0, 0, 0.5 * width], [0, 0.5 * height, 0, 0.5 * height], [0, 0, 1, 0], [0, 0, 0, 1]])
    return viewport @ camera.clip_from_world


def seen_surface(depth: np.ndarray, camera: Camera, dtype: type = np.float32) -> tuple[np.ndarray, np.ndarray]:
    """(h, w) where a `depth` pass (row 0 at the top; inf = nothing) has a surface, rows from the bottom up, and its (P, 3) points."""
    seen = np.isfinite(depth[::-1])
    return seen, surface_points_ws(np.where(seen, depth[::-1], np.float32(0.0)), camera, dtype)


def surface_points_ws(view_depth: np.ndarray, camera: Camera, dtype: type = np.float32) -> np.ndarray:
    """(P, 3) world points of all pixels of `view_depth` (h, w; row 0 at the bottom; 0 = nothing)."""
    height, width = view_depth.shape
    along, start = (m.astype(dtype) for m in pixel_rays(camera, (width, height)))
    seen = view_depth != 0.0
    place = np.flatnonzero(seen)
    y = np.repeat(np.arange(height), np.count_nonzero(seen, axis=1))
    z = view_depth.reshape(-1)[place]
    px, py = (place - y * width).astype(dtype) + 0.5, y.astype(dtype) + 0.5
    columns = np.empty((3, len(z)), dtype)
    for axis in range(3):
        columns[axis] = (start[axis, 0] * px + start[axis, 1] * py + start[axis, 2]) + z * (
            along[axis, 0] * px + along[axis, 1] * py + along[axis, 2]
        )
    return columns.T
