"""Images on Blender's own GPU, to be drawn in its viewports. The pictures themselves are made by the pipeline's worker, not here."""

from __future__ import annotations

import numpy as np


def texture_of(image: np.ndarray) -> object:
    """A linear (h, w, 4) image, top row first, on Blender's GPU."""
    import gpu

    height, width = image.shape[:2]
    flat = np.ascontiguousarray(image[::-1], dtype=np.float32).ravel()
    return gpu.types.GPUTexture((width, height), format="RGBA16F", data=gpu.types.Buffer("FLOAT", len(flat), flat))
