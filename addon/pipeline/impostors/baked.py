"""What an impostor is when it is read back: images and numbers. Data only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...maths.relief.edges import ReliefEdges
from ...maths.relief.warp import CaptureFrame


@dataclass(frozen=True, eq=False)
class BakedImpostor:
    """An impostor read back: images (h, w[, c]), row 0 at the top, texel (column, row) at u, v = column + ½, row + ½ of the `frame`.

    `color` RGBA float32 linear, alpha 1 where the texel's centre sees the object, as in `mask` bool; `depth_m`, `back_m` float32 metres
    behind the plane of the first surface, and of where the solid behind it ends; `normal` world; `object_id` int32, −1 = none; `edges`
    the critical points and depth edges; `triangles` it stands for, `bytes` it takes on the GPU.
    """

    name: str
    frame: CaptureFrame
    color: np.ndarray
    depth_m: np.ndarray
    back_m: np.ndarray
    mask: np.ndarray
    normal: np.ndarray
    object_id: np.ndarray
    edges: ReliefEdges
    triangles: int
    bytes: int
    gl: dict[str, str]
