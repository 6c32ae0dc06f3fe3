"""A `CadModel` as Blender objects: parts share mesh data, groups are empties, everything in one new collection.

No operator is called and no Python loop runs over elements: datablocks are filled with `foreach_set` on attributes of the exact type,
which Blender copies in one go. If anything fails, all that was made is removed again.
"""

from __future__ import annotations

import bpy
import numpy as np
from mathutils import Matrix

from ..scene.cad_model import CREASED, CadCamera, CadLight, CadMesh, CadModel, CadPart
from .cad_materials import COLORS, UVS, Made, material_of, mean_tints


def to_blender(model: CadModel, parent: bpy.types.Collection) -> bpy.types.Collection:
    """Make the model's objects in a new collection under `parent` and return that collection.

    The collection's custom property `cad_units` tells the unit that was taken. Parts of one mesh share it; names are kept (Blender
    numbers doubles). Materials are matched by name and colour with those already there, so a second import adds none.
    """
    made = Made()
    try:
        collection = made.add(bpy.data.collections, model.name)
        collection["cad_units"] = model.units
        tints = mean_tints(model)
        materials = [material_of(made, m, tint) for m, tint in zip(model.materials, tints, strict=True)]
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


def _object(made: Made, part: CadPart, meshes: list[bpy.types.Mesh]) -> bpy.types.Object:
    if isinstance(part.item, CadLight):
        data = _light(made, part.item)
    elif isinstance(part.item, CadCamera):
        data = _camera(made, part.item)
    else:
        data = meshes[part.mesh] if part.mesh >= 0 else None
    ob = made.add(bpy.data.objects, part.name, data)
    if data is None:
        ob.empty_display_size = 0.01
    if part.is_hidden:
        ob.hide_viewport = ob.hide_render = True
    return ob


def _light(made: Made, light: CadLight) -> bpy.types.Light:
    data = made.add(bpy.data.lights, light.name, light.kind.upper())
    data.color, data.energy = light.color, light.energy
    if light.kind == "spot":
        data.spot_size, data.spot_blend = light.cone, light.blend
    if light.kind == "sun":
        data.angle = 0.0
    else:
        data.shadow_soft_size = 0.0
    return data


def _camera(made: Made, camera: CadCamera) -> bpy.types.Camera:
    data = made.add(bpy.data.cameras, camera.name)
    data.sensor_fit = "VERTICAL"
    if camera.fov_y is None:
        data.type, data.ortho_scale = "ORTHO", camera.height
    else:
        data.angle_y = camera.fov_y
    data.clip_start = max(camera.near, 1e-6)
    data.clip_end = camera.far if camera.far is not None else max(1e4 * camera.near, 1e4)
    return data


def _mesh(made: Made, mesh: CadMesh, materials: list[bpy.types.Material]) -> bpy.types.Mesh:
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
    if mesh.corner_colors is not None:
        data.attributes.new(COLORS, "FLOAT_COLOR", "CORNER").data.foreach_set("color", mesh.corner_colors.ravel())
    if mesh.corner_uvs is not None:
        data.attributes.new(UVS, "FLOAT2", "CORNER").data.foreach_set("vector", mesh.corner_uvs.ravel())
    data.update(calc_edges=True)
    if mesh.normals is None:
        data.attributes.new("sharp_face", "BOOLEAN", "FACE").data.foreach_set("value", np.ones(count, dtype=bool))
        data[CREASED] = True
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
