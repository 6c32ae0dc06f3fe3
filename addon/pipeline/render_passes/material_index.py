"""The index that its author gave the material that is seen."""

import numpy as np

from .row import ShadedImages, author_index, materials_seen


def index_of(shaded: ShadedImages) -> np.ndarray:
    """(h, w) whole numbers."""
    return np.array([*(index for _, index in shaded.job.scene.materials), 0], np.int32)[materials_seen(shaded)]  # -1: the last, nothing


ROW = author_index("material", 71, "IndexMA", index_of)
