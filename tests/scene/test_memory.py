"""Memory handed back, and meshes prepared in blocks."""

import sys
import tracemalloc

import numpy as np

from addon.scene.memory import give_back
from addon.scene.mesh_prep import TRIANGLES_AT_ONCE, shade_by_crease


def sheet(side):
    """A wavy sheet of 2·side² triangles."""
    x, y = np.meshgrid(np.arange(side + 1.0), np.arange(side + 1.0))
    first = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    triangles = np.stack([first, first + 1, first + side + 2, first, first + side + 2, first + side + 1], axis=-1).reshape(-1, 3)
    return np.stack([x, y, np.sin(0.3 * x) * np.cos(0.2 * y)], axis=-1).reshape(-1, 3).astype(np.float32), triangles.astype(np.int32)


def test_the_c_library_is_asked_where_there_is_one_that_can():
    assert give_back() == sys.platform.startswith("linux")


def test_normals_of_a_large_mesh_take_little_more_memory_than_they_fill():
    """Per triangle: float64 columns of all its edges, normals and angles at once would be some 300 bytes."""
    positions, triangles = sheet(400)
    assert len(triangles) > 4 * TRIANGLES_AT_ONCE
    tracemalloc.start()
    shaded = shade_by_crease(positions, triangles)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(shaded.triangles) == len(triangles)
    assert peak / len(triangles) < 160.0
