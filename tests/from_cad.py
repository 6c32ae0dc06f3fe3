"""A `CadModel` straight to a `Scene`, without Blender: for tests and benchmarks. Same preparation as `blender/snapshot`'s."""

from __future__ import annotations

import numpy as np

from addon.scene.cad_model import CadMesh, CadModel
from addon.scene.mesh_pieces import RawMesh, prepare_all
from addon.scene.mesh_prep import DEFAULT_CREASE_RAD
from addon.scene.records import Instances, Scene

GREY = (0.8, 0.8, 0.8, 1.0)


def scene_from_model(model: CadModel, crease_angle_rad: float = DEFAULT_CREASE_RAD) -> Scene:
    """The parts of a model as a scene without lights and cameras, relative to the rounded centre of its bounds."""
    prepared = prepare_all([_raw(m) for m in model.meshes], [(model.name, i) for i in range(len(model.meshes))], crease_angle_rad)
    first = np.cumsum([0] + [len(p.meshes) for p in prepared])
    world = model.world_from_part()
    rows = [
        (first[part.mesh] + k, i, slot)
        for i, part in enumerate(model.parts)
        if part.mesh >= 0
        for k, slot in enumerate(prepared[part.mesh].slots)
    ]
    mesh_index, part_index, slots = (np.array(column, dtype=np.int64) for column in zip(*rows, strict=True))
    offsets = np.array([prepared[model.parts[i].mesh].offset_os for i in part_index])
    matrices = world[part_index].copy()
    matrices[:, :3, 3] += np.einsum("nij,nj->ni", matrices[:, :3, :3], offsets)
    colors = np.array([_color(model, model.parts[i].mesh, s) for i, s in zip(part_index, slots, strict=True)])
    shown, object_id = np.unique(part_index, return_inverse=True)
    origin = np.round(model.bounds().mean(axis=0))
    matrices[:, :3, 3] -= origin
    instances = Instances(mesh_index, matrices, object_id, slots, colors)
    return Scene(
        tuple(m for p in prepared for m in p.meshes), instances, tuple(model.parts[i].name for i in shown), origin, warnings=model.warnings
    )


def _raw(mesh: CadMesh) -> RawMesh:
    normals = None if mesh.normals is None else mesh.normals[mesh.triangles]
    return RawMesh(mesh.positions, mesh.triangles, mesh.triangle_slots, normals)


def _color(model: CadModel, mesh: int, slot: int) -> tuple[float, float, float, float]:
    slots = model.meshes[mesh].materials
    return model.materials[slots[min(slot, len(slots) - 1)]].base_color if slots else GREY
