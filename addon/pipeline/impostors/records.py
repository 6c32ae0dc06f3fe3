"""The records of impostors: what is wanted, what was found in the scene, for whom it is looked at. Data only."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field

import numpy as np

from ...maths.domains import one_of, require, require_fields, same_as, within
from ...maths.frusta import box_corners
from ...maths.relief.edges import EdgeChoice
from ...maths.relief.frame import CaptureChoice
from ...maths.relief.life import LifeSettings, ViewedImpostor
from ...maths.relief.warp import CaptureFrame
from ...maths.view import Camera
from ...scene.records import Scene
from ...settings.groups import ImpostorSettings

MODES = ("automatic", "manual")


@dataclass(frozen=True)
class ImpostorGroup:
    """What one impostor stands for: `object_ids` of the scene (an object, or all of a collection). `key` tells it from others."""

    key: Hashable
    object_ids: tuple[int, ...]
    name: str = ""


@dataclass(frozen=True)
class ImpostorChoice:
    """The impostors wanted in a picture, and how they live: fields that `ImpostorSettings` has too mean the same.

    `mode` 'manual' captures only the keys in `regenerate` (and what has no texture yet); 'automatic' lets the life cycle decide. `warp`
    'inverse' follows view rays, 'forward' is the texts' pre-warp. `triangle_ns`, `pixel_ns`: what a triangle and an impostor's pixel cost,
    for the break-even (None: measured), which counts captures and camera samples; `break_even` False draws impostors however cheap the
    geometry is. `exact` also computes
    the sums over all edges.
    `views` captures at most are drawn together, where one alone is over the limit: the last ones or, with `directions` n > 0, those
    nearest of n × n directions round the object, which are captured when first needed and kept. `fill`: what lay hidden behind a nearer
    part at capture is taken to go on there.
    `casters` 'impostor': what is drawn as impostor casts its shadow as one, captured from the light (`shadows.py`).
    `fresh`: nothing is remembered of frames before, and nothing of this one by those that are not fresh.
    """

    groups: tuple[ImpostorGroup, ...] = ()
    life: LifeSettings = field(default_factory=LifeSettings)
    capture: CaptureChoice = field(default_factory=lambda: CaptureChoice(texels_per_pixel=ImpostorSettings().texels_per_pixel))
    edges: EdgeChoice = field(default_factory=EdgeChoice)
    back_layer: bool = same_as(ImpostorSettings, "back_layer")
    mode: str = one_of("automatic", "Impostor mode", MODES)
    warp: str = same_as(ImpostorSettings, "warp")
    regenerate: frozenset[Hashable] = frozenset()
    triangle_ns: float | None = within(None, "The cost of a triangle (ns)", 1e-9)
    pixel_ns: float | None = within(None, "The cost of a pixel (ns)", 1e-9)
    break_even: bool = same_as(ImpostorSettings, "break_even")
    exact: bool = False
    fresh: bool = False
    views: int = same_as(ImpostorSettings, "views")
    directions: int = same_as(ImpostorSettings, "directions")
    fill: bool = same_as(ImpostorSettings, "fill")
    casters: str = same_as(ImpostorSettings, "casters")

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
    """The groups' rows and bounds; a group without instances (deleted, hidden) has no rows."""
    bounds = scene.instance_bounds_ws()
    counts = np.array([len(m.triangles) for m in scene.meshes], np.int64)[scene.instances.mesh_index]
    parts = []
    for group in groups:
        rows = np.isin(scene.instances.object_id, group.object_ids)
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
