"""From GL targets to images: the one place where rows are flipped (GL's row 0 is at the bottom, ours at the top). Worker thread only."""

from __future__ import annotations

import moderngl
import numpy as np

from .gl_raw import read_into

_DTYPES = {"f2": np.float32, "f4": np.float32, "i4": np.int32, "u4": np.uint32}
_KINDS = {"f2": 0x1406, "f4": 0x1406, "i4": 0x1404, "u4": 0x1405}  # GL_FLOAT, GL_INT, GL_UNSIGNED_INT
_FLOAT_FORMATS = {1: 0x1903, 2: 0x8227, 3: 0x1907, 4: 0x1908}  # GL_RED, GL_RG, GL_RGB, GL_RGBA
_INTEGER_FORMATS = {1: 0x8D94, 2: 0x8228, 3: 0x8D98, 4: 0x8D99}


def read_texture(texture: moderngl.Texture, *, flip: bool = True) -> np.ndarray:
    """(h, w) or (h, w, c) array of a texture; `flip` puts row 0 at the top."""
    width, height = texture.size
    shape = (height, width) if texture.components == 1 else (height, width, texture.components)
    image = np.empty(shape, _DTYPES[texture.dtype])
    formats = _FLOAT_FORMATS if texture.dtype in ("f2", "f4") else _INTEGER_FORMATS
    read_into(texture.ctx, texture, formats[texture.components], _KINDS[texture.dtype], image)
    return np.ascontiguousarray(image[::-1]) if flip else image
