"""A CAD file as somebody might have one: the example deck as a glTF assembly, its parts sharing meshes, in metres, Y up."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh

from addon.scene.platform_deck import build

Y_UP_FROM_Z_UP = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])


def write_plant(path: Path, triangles: int) -> None:
    """Write about so many triangles to `path` (.glb)."""
    model, scene = build(triangles), trimesh.Scene()
    for mesh in model.meshes:
        scene.geometry[mesh.name] = trimesh.Trimesh(mesh.positions, mesh.triangles, process=False)
        colors = [model.materials[slot].base_color for slot in mesh.materials[:1]]
        for color in colors:
            material = trimesh.visual.material.PBRMaterial(baseColorFactor=[round(255 * c) for c in color], metallicFactor=0.0)
            scene.geometry[mesh.name].visual = trimesh.visual.TextureVisuals(material=material)
    for i, (part, world) in enumerate(zip(model.parts, model.world_from_part(), strict=True)):
        if part.mesh >= 0:
            scene.graph.update(f"{part.name} {i}", matrix=Y_UP_FROM_Z_UP @ world, geometry=model.meshes[part.mesh].name)
    path.write_bytes(scene.export(file_type="glb"))
