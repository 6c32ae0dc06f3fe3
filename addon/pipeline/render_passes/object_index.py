"""The index that its author gave the object that is seen."""

import numpy as np

from .row import ShadedImages, author_index


def index_of(shaded: ShadedImages) -> np.ndarray:
    """(h, w) whole numbers."""
    objects = shaded.ids[..., 0]
    return np.where(objects < 0, 0, shaded.job.scene.object_index[objects])


ROW = author_index("object", 77, "IndexOB", index_of)
