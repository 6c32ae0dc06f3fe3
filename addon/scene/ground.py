"""The ground that only catches shadows: a plane under a scene, as one more instance of it. numpy only."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .looks import GROUND, NO_SHADOW
from .records import Ground, Instances, Mesh, Scene

CELLS = 24  # a side: a few large triangles would be drawn with fewer digits
BELOW = 1e-4  # of the model's size, by which it lies below: a floor of the model's own is in front of it
REACH = 3.0  # heights of the model that shadows are caught beside it: down to a sun of 18 degrees
REACH_FLAT = 0.5  # and extents
NAME = "Ground"


def ground_height(scene: Scene) -> float:
    """Just below the lowest part of the scene, metres over its origin. Raises `SceneError` for an empty one."""
    low, high = scene.bounds_ws()
    return float(low[2] - BELOW * (high - low).max())


def with_ground(scene: Scene, height: float, bounds_ws: np.ndarray | None = None) -> Scene:
    """The scene with a ground at `height` over its origin, wide enough for the shadows of what `bounds_ws` (2, 3) holds (None: of the
    scene): one more object, the last."""
    low, high = scene.bounds_ws() if bounds_ws is None else bounds_ws
    size = high - low
    reach = REACH * float(size[2]) + REACH_FLAT * float(size[:2].max()) + 1e-6
    ground = Ground(tuple(0.5 * (low + high)[:2]), tuple(0.5 * size[:2]), reach)
    half = 0.5 * size[:2] + reach
    world_from_ground = np.eye(4)
    world_from_ground[:3, 3] = *ground.centre, height
    old, number = scene.instances, len(scene.object_names)
    instances = Instances(
        np.append(old.mesh_index, len(scene.meshes)),
        np.concatenate([old.world_from_object, world_from_ground[None]]),
        np.append(old.object_id, number),
        np.append(old.material_slot, 0),
        np.concatenate([old.base_color, np.ones((1, 4))]),
        np.append(old.look, 0),
        np.append(old.flags, np.uint8(GROUND | NO_SHADOW)),
    )
    return replace(
        scene,
        meshes=(*scene.meshes, _sheet(half)),
        instances=instances,
        object_names=(*scene.object_names, NAME),
        marks=(*scene.marks, None) if scene.marks else (),
        object_index=np.append(scene.object_index[:number], np.int32(0)),
        links={name: (np.append(unlit, False), np.append(free, False)) for name, (unlit, free) in scene.links.items()},
        ground=ground,
    )


def _sheet(half: np.ndarray) -> Mesh:
    """A grid about the origin that faces up."""
    step = np.linspace(-1.0, 1.0, CELLS + 1)
    x, y = np.meshgrid(step * half[0], step * half[1], indexing="ij")
    positions = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(CELLS), np.arange(CELLS), indexing="ij")
    a = (i * (CELLS + 1) + j).ravel()
    b, c, d = a + CELLS + 1, a + CELLS + 2, a + 1
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return Mesh(("ground", *map(float, half)), positions, np.tile([0.0, 0.0, 1.0], (len(positions), 1)), triangles)
