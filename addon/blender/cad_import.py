"""A `CadModel` as Blender objects: parts share mesh data, groups are empties, everything in one new collection.

No operator is called and no Python loop runs over elements: datablocks are filled with `foreach_set` on attributes of the exact type,
which Blender copies in one go. If anything fails, all that was made is removed again.
"""

from __future__ import annotations

import bpy
import numpy as np
from mathutils import Matrix

from ..scene.cad_model import CadMaterial, CadMesh, CadModel, CadPart


def to_blender(model: CadModel, parent: bpy.types.Collection) -> bpy.types.Collection:
    """Make the model's objects in a new collection under `parent` and return that collection.

    The collection's custom property `cad_units` tells the unit that was taken. Parts of one mesh share it; names are kept (Blender
    numbers doubles). Materials are matched by name and colour with those already there, so a second import adds none.
    """
    made = _Made()
    try:
        collection = made.add(bpy.data.collections, model.name)
        collection["cad_units"] = model.units
        materials = [_material(made, m) for m in model.materials]
        meshes = [_mesh(made, m, materials) for m in model.meshes]
        objects = [_object(made, part, meshes) for part in model.parts]
        for part, ob in zip(model.parts, objects, strict=True):
            if part.parent >= 0:
                ob.parent = objects[part.parent]
            ob.matrix_local = Matrix(part.parent_from_part.tolist())
            collection.objects.link(ob)
        parent.children.link(collection)
    except BaseException:
        made.remove_all()
        raise
    return collection


class _Made:
    """The datablocks made so far, to be taken back on failure."""

    def __init__(self) -> None:
        self.blocks: list[bpy.types.ID] = []

    def add(self, kind: bpy.types.bpy_prop_collection, name: str, *args: object) -> bpy.types.ID:
        """`kind.new(name, *args)`, remembered."""
        block = kind.new(name, *args)
        self.blocks.append(block)
        return block

    def remove_all(self) -> None:
        """Remove everything made, users first."""
        bpy.data.batch_remove(reversed(self.blocks))


def _object(made: _Made, part: CadPart, meshes: list[bpy.types.Mesh]) -> bpy.types.Object:
    ob = made.add(bpy.data.objects, part.name, meshes[part.mesh] if part.mesh >= 0 else None)
    if part.mesh < 0:
        ob.empty_display_size = 0.01
    return ob


def _material(made: _Made, material: CadMaterial) -> bpy.types.Material:
    """The material of that name and colour, made if there is none."""
    existing = bpy.data.materials.get(material.name)
    if existing is not None and np.allclose(existing.diffuse_color, material.base_color, atol=1e-5):
        return existing
    new = made.add(bpy.data.materials, material.name)
    new.diffuse_color = material.base_color
    new.metallic, new.roughness = material.metallic, material.roughness
    if bpy.app.version < (5, 0, 0):
        new.use_nodes = True
    node = next((n for n in new.node_tree.nodes if n.type == "BSDF_PRINCIPLED"), None)
    if node is not None:
        node.inputs["Base Color"].default_value = material.base_color
        node.inputs["Alpha"].default_value = material.base_color[3]
        node.inputs["Metallic"].default_value = material.metallic
        node.inputs["Roughness"].default_value = material.roughness
    return new


def _mesh(made: _Made, mesh: CadMesh, materials: list[bpy.types.Material]) -> bpy.types.Mesh:
    data = made.add(bpy.data.meshes, mesh.name)
    count = len(mesh.triangles)
    data.vertices.add(len(mesh.positions))
    data.loops.add(3 * count)
    data.polygons.add(count)
    data.attributes["position"].data.foreach_set("vector", mesh.positions.ravel())
    data.polygons.foreach_set("loop_start", np.arange(0, 3 * count, 3, dtype=np.int32))
    _corner_vertices(data).data.foreach_set("value", mesh.triangles.ravel())
    for index in mesh.materials:
        data.materials.append(materials[index])
    if mesh.triangle_slots is not None:
        data.attributes.new("material_index", "INT", "FACE").data.foreach_set("value", mesh.triangle_slots)
    data.update(calc_edges=True)
    if mesh.normals is None:
        data.attributes.new("sharp_face", "BOOLEAN", "FACE").data.foreach_set("value", np.ones(count, dtype=bool))
    else:
        _custom_normals(data, mesh.normals)
    return data


def _corner_vertices(data: bpy.types.Mesh) -> bpy.types.Attribute:
    return data.attributes.get(".corner_vert") or data.attributes.new(".corner_vert", "INT", "CORNER")


def _custom_normals(data: bpy.types.Mesh, normals: np.ndarray) -> None:
    """Free normals on the vertices where Blender has them (4.5), else its own encoding (slow, but exact)."""
    if bpy.app.version >= (4, 5, 0):
        data.attributes.new("custom_normal", "FLOAT_VECTOR", "POINT").data.foreach_set("vector", normals.ravel())
    else:
        data.normals_split_custom_set_from_vertices(normals.tolist())
