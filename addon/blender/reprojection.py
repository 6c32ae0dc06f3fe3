"""A finished picture drawn in a viewport: flat, or, once the view has moved on, where it lies in space.

In space it is a mesh over the picture, its corners moved to the depth that was seen there. What was hidden is not there yet: there the mesh
is stretched, and beside the model lies the background.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from ..maths.spaces import translation
from ..settings.groups import ShadingWorld
from .textures import texture_of

if TYPE_CHECKING:
    from ..maths.view import Camera
    from ..studies.run import Outcome

MOST_CORNERS = 40_000  # of the mesh
VERTEX = "void main() { gl_Position = from_place * vec4(place, 1.0); at = uv; }"
FRAGMENT = """
void main() {
    vec2 size = vec2(textureSize(picture, 0)), from = at * size - 0.5, share = fract(from);
    ivec2 low = ivec2(floor(from)), last = ivec2(size) - 1;
    vec4 lower = mix(texelFetch(picture, clamp(low, ivec2(0), last), 0),
                     texelFetch(picture, clamp(low + ivec2(1, 0), ivec2(0), last), 0), share.x);
    vec4 upper = mix(texelFetch(picture, clamp(low + ivec2(0, 1), ivec2(0), last), 0),
                     texelFetch(picture, clamp(low + ivec2(1, 1), ivec2(0), last), 0), share.x);
    color = is_filled ? filled : mix(lower, upper, share.y);
}
"""


def lattice(length: int, step: int) -> np.ndarray:
    """Pixels `step` apart, the last one too."""
    return np.unique(np.append(np.arange(0, length, step), length - 1))


def picture_mesh(view_depth: np.ndarray, camera: Camera, most: int = MOST_CORNERS) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places (V, 3) in the world, picture coordinates 0 … 1 from the bottom left (V, 2), and triangles (T, 3), the farthest first.

    `view_depth` (h, w), row 0 at the top, 0 where nothing is seen: there is no mesh, but for one cell round what is seen.
    """
    from ..pipeline.passes.gbuffer import pixel_rays

    height, width = view_depth.shape
    step = max(1, int(np.ceil((width * height / most) ** 0.5)))
    columns, rows = lattice(width, step), lattice(height, step)
    depth = view_depth[::-1][np.ix_(rows, columns)].astype(np.float64)
    padded = np.pad(depth, 1)
    around = np.lib.stride_tricks.sliding_window_view(padded, (3, 3)).max(axis=(2, 3))
    depth = np.where(depth == 0.0, around, depth)
    along, start = pixel_rays(camera, (width, height))
    x, y = np.meshgrid(columns + 0.5, rows + 0.5)
    h = np.stack([x, y, np.ones_like(x)], axis=-1)
    places = h @ start.T + depth[..., None] * (h @ along.T)
    number = np.arange(depth.size).reshape(depth.shape)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    corners = np.stack([np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)], axis=2).reshape(-1, 3)
    deep = depth.reshape(-1)[corners]
    corners = corners[(deep > 0.0).all(axis=1)]
    order = np.argsort(-depth.reshape(-1)[corners].min(axis=1), kind="stable")
    return places.reshape(-1, 3), np.stack([x / width, y / height], axis=-1).reshape(-1, 2), corners[order]


@cache
def _shader() -> object:
    import gpu

    info = gpu.types.GPUShaderCreateInfo()
    carried = gpu.types.GPUStageInterfaceInfo("cad_shadow_picture")
    carried.smooth("VEC2", "at")
    info.vertex_in(0, "VEC3", "place")
    info.vertex_in(1, "VEC2", "uv")
    info.vertex_out(carried)
    info.push_constant("MAT4", "from_place")
    info.push_constant("VEC4", "filled")
    info.push_constant("BOOL", "is_filled")
    info.sampler(0, "FLOAT_2D", "picture")
    info.fragment_out(0, "VEC4", "color")
    info.vertex_source(VERTEX)
    info.fragment_source(FRAGMENT)
    return gpu.shader.create_from_info(info)


class DrawnPicture:
    """A linear, premultiplied (h, w, 4) picture on Blender's GPU."""

    def __init__(self, image: np.ndarray) -> None:
        self._texture = texture_of(image)
        self._mesh: tuple[object, np.ndarray] | None = None

    def draw_flat(self) -> None:
        """Over the whole region, smoothly enlarged where it has fewer pixels."""
        self._draw(_whole(), np.eye(4))

    def draw_in_space(self, outcome: Outcome, clip_from_true_world: np.ndarray) -> None:
        """Where what it shows lies, over the background; seen through that matrix (4, 4) of Blender's world."""
        from gpu_extras.batch import batch_for_shader

        job = outcome.job
        if self._mesh is None:
            places, uvs, triangles = picture_mesh(outcome.frame.view_depth, job.camera)
            middle = places[triangles].reshape(-1, 3).mean(axis=0) if len(triangles) else np.zeros(3)
            content = {"place": (places - middle).astype(np.float32), "uv": uvs.astype(np.float32)}
            batch = batch_for_shader(_shader(), "TRIS", content, indices=triangles.astype(np.int32))
            self._mesh = batch, middle + job.scene.origin_ws
        batch, middle = self._mesh
        self._draw(_whole(), np.eye(4), job.settings.shading.under(ShadingWorld()).background)
        self._draw(batch, clip_from_true_world @ translation(middle))

    def _draw(self, batch: object, clip_from_place: np.ndarray, filled: tuple[float, ...] | None = None) -> None:
        import gpu
        from mathutils import Matrix

        shader = _shader()
        shader.bind()
        shader.uniform_float("from_place", Matrix(clip_from_place.tolist()))
        shader.uniform_bool("is_filled", [filled is not None])
        shader.uniform_float("filled", filled or (0.0,) * 4)
        shader.uniform_sampler("picture", self._texture)
        gpu.state.blend_set("ALPHA_PREMULT")
        batch.draw(shader)
        gpu.state.blend_set("NONE")


def _whole() -> object:
    """A batch that covers the region."""
    from gpu_extras.batch import batch_for_shader

    places = [(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0)]
    uvs = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
    return batch_for_shader(_shader(), "TRIS", {"place": places, "uv": uvs}, indices=[(0, 1, 2), (0, 2, 3)])
