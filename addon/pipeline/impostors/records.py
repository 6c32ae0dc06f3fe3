"""The records of impostors: what is wanted, what was found in the scene, for whom it is looked at. Data only."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field

import numpy as np

from ...maths.domains import require, require_fields, within
from ...maths.frusta import box_corners
from ...maths.relief.edges import EdgeChoice
from ...maths.relief.frame import capture_frame
from ...maths.relief.life import LifeModel, ViewedImpostor
from ...maths.relief.settings import USUAL, ImpostorSettings
from ...maths.relief.warp import CaptureFrame
from ...maths.view import Camera
from ...scene.records import Scene


@dataclass(frozen=True)
class ImpostorGroup:
    """What one impostor stands for: `object_ids` of the scene (an object, or all of a collection). `key` tells it from others."""

    key: Hashable
    object_ids: tuple[int, ...]
    name: str = ""


@dataclass(frozen=True)
class ImpostorChoice:
    """The impostors wanted in a picture: the `groups`, the user's `settings`, and what this picture asks beyond them.

    With 'manual' use only the keys in `regenerate` are captured (and what has no texture yet). `triangle_ns`, `pixel_ns`: what a triangle
    and an impostor's pixel cost, for the break-even (None: measured), which counts captures and camera samples. `exact` also computes the
    sums over all edges. `alone`: nothing is remembered of frames before, and nothing of this one by those that are not alone.
    """

    groups: tuple[ImpostorGroup, ...] = ()
    settings: ImpostorSettings = USUAL
    model: LifeModel = field(default_factory=LifeModel)
    edges: EdgeChoice = field(default_factory=EdgeChoice)
    regenerate: frozenset[Hashable] = frozenset()
    triangle_ns: float | None = within(None, "The cost of a triangle (ns)", 1e-9)
    pixel_ns: float | None = within(None, "The cost of a pixel (ns)", 1e-9)
    exact: bool = False
    alone: bool = False

    def __post_init__(self) -> None:
        require_fields(self)
        require(len({g.key for g in self.groups}) == len(self.groups), "Two impostors have the same key.")


@dataclass(frozen=True, eq=False)
class Part:
    """A group found in the scene: its rows (I,), the corners (8, 3) and box (2, 3) of its bounds, its triangles."""

    group: ImpostorGroup
    rows: np.ndarray
    hull_ws: np.ndarray
    bounds_ws: np.ndarray
    triangles: int
    scene: Scene

    def is_cut(self, camera: Camera) -> bool:
        """True when the camera's near plane passes through the object: of the triangles that it cuts one sees the inside."""
        away = -camera.view_from_world[2]
        instances = self.scene.instances
        rows = away @ instances.world_from_object[self.rows]
        meshes = (self.scene.meshes[i].positions for i in instances.mesh_index[self.rows])
        nearest = (float((mesh @ row[:3].astype(np.float32)).min() + row[3]) for mesh, row in zip(meshes, rows, strict=True))
        return any(depth < camera.near for depth in nearest)


def parts_of(scene: Scene, groups: Sequence[ImpostorGroup]) -> list[Part]:
    """The groups' rows and bounds; a group without instances (deleted, hidden) has no rows. What is see-through is of no impostor."""
    bounds = scene.instance_bounds_ws()
    counts = np.array([len(m.triangles) for m in scene.meshes], np.int64)[scene.instances.mesh_index]
    clear = [rows for rows in (scene.see_through, scene.shines_through) if rows is not None]
    whole, parts = ~np.any([np.zeros(len(counts), bool), *clear], axis=0), []
    for group in groups:
        rows = np.isin(scene.instances.object_id, group.object_ids) & whole
        box = np.zeros((2, 3))
        if rows.any():
            box = np.stack([bounds[rows, 0].min(axis=0), bounds[rows, 1].max(axis=0)])
        parts.append(Part(group, rows, box_corners(box), box, int(counts[rows].sum()), scene))
    return parts


@dataclass(frozen=True, eq=False)
class Predicted:
    """An impostor as viewed, the frame of a capture from here (None: not worked out, or none is possible), the predictors by name."""

    impostor: ViewedImpostor
    frame: CaptureFrame | None
    errors: dict[str, float]


@dataclass(frozen=True)
class ImpostorView:
    """For whom impostors are predicted: camera, picture size (w, h), what is chosen, and the camera `samples` of a pixel."""

    camera: Camera
    size: tuple[int, int]
    choice: ImpostorChoice
    samples: int = 1

    def frame_of(self, hull_ws: np.ndarray, camera: Camera | None = None) -> CaptureFrame:
        """The frame of a capture from `camera` (None: from here), laid so that the picture's samples fall on the texels' own.

        Raises `SceneError` where none is possible.
        """
        return capture_frame(hull_ws, camera or self.camera, self.size, self.choice.settings, round(self.samples**0.5))
