"""From GL targets to images: the one place where rows are flipped (GL's row 0 is at the bottom, ours at the top). Worker thread only."""

from __future__ import annotations

import moderngl
import numpy as np

from .gl_raw import read_into

_DTYPES = {"f4": np.float32, "i4": np.int32, "u4": np.uint32}
_KINDS = {"f4": 0x1406, "i4": 0x1404, "u4": 0x1405}  # GL_FLOAT, GL_INT, GL_UNSIGNED_INT
_FLOAT_FORMATS = {1: 0x1903, 2: 0x8227, 3: 0x1907, 4: 0x1908}  # GL_RED, GL_RG, GL_RGB, GL_RGBA
_INTEGER_FORMATS = {1: 0x8D94, 2: 0x8228, 3: 0x8D98, 4: 0x8D99}


def read_texture(texture: moderngl.Texture, *, flip: bool = True) -> np.ndarray:
    """(h, w) or (h, w, c) array of a texture; `flip` puts row 0 at the top."""
    width, height = texture.size
    shape = (height, width) if texture.components == 1 else (height, width, texture.components)
    image = np.empty(shape, _DTYPES[texture.dtype])
    formats = _FLOAT_FORMATS if texture.dtype == "f4" else _INTEGER_FORMATS
    read_into(texture.ctx, texture, formats[texture.components], _KINDS[texture.dtype], image)
    return np.ascontiguousarray(image[::-1]) if flip else image


def frame_passes(combined: np.ndarray, data: list[np.ndarray] | None, wanted: tuple[str, ...]) -> dict[str, np.ndarray]:
    """The contract's images from the shading targets (combined; errors, normal, ids), only those asked for.

    No surface: depth inf, object −1, partition −1, normal 0, shadow 1, aliasing NaN. No map there: aliasing NaN.
    """
    passes = {"combined": combined} if "combined" in wanted else {}
    if data is None:
        return passes
    errors, normal, ids = data
    nothing = ids[..., 0] < 0
    makers = {
        "shadow": lambda: np.ascontiguousarray(errors[..., 3]),
        "depth": lambda: np.where(nothing, np.float32(np.inf), normal[..., 3]),
        "normal": lambda: np.ascontiguousarray(normal[..., :3]),
        "object": lambda: np.ascontiguousarray(ids[..., 0]),
        "partition": lambda: np.ascontiguousarray(ids[..., 1]),
        "aliasing": lambda: aliasing_image(errors),
    }
    passes.update({name: make() for name, make in makers.items() if name in wanted})
    return passes


def aliasing_image(errors: np.ndarray) -> np.ndarray:
    """(h, w, 3) m, m_x, m_z with NaN where there is no surface or no map (the shader writes −1)."""
    image = np.ascontiguousarray(errors[..., :3])
    image[image < 0.0] = np.nan
    return image
