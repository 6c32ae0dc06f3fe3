"""SceneReader: the meshes and instances that Blender's depsgraph shows, as arrays; nothing read twice."""

from math import radians

import bpy  # before mathutils and bpy_extras, which it brings
import numpy as np
import pytest

from addon.blender.snapshot import SceneReader
from addon.blender.snapshot.reader import local_origin
from addon.errors import SceneError
from addon.scene.cad_model import CREASED
from tests.blender.snapshot_rigs import add, depsgraph, mesh, read, triangle


def world_triangles(scene):
    """(T, 3, 3) all drawn triangles in absolute world coordinates, in order."""
    out = []
    for i, m in zip(scene.instances.mesh_index, scene.instances.world_from_object, strict=True):
        points = scene.meshes[i].positions @ m[:3, :3].T + m[:3, 3] + scene.origin_ws
        out.append(points[scene.meshes[i].triangles])
    return np.concatenate(out)


def blender_triangles():
    """The same through Blender's slow, plain interface."""
    out = []
    for instance in depsgraph().object_instances:
        if instance.show_self and instance.object.type == "MESH":
            data = instance.object.data
            data.calc_loop_triangles()
            out += [[instance.matrix_world @ data.vertices[v].co for v in t.vertices] for t in data.loop_triangles]
    return np.array(out)


def same_triangles(a, b):
    return len(a) == len(b) and np.allclose(a, b, atol=1e-4)


def without_slivers(triangles):
    """Those whose height is more than 1e-4 of their longest edge: whether thinner ones have an area is a matter of rounding here."""
    edges = triangles[:, [1, 2, 0]] - triangles
    area = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    return triangles[area > 1e-4 * np.square(edges).sum(axis=2).max(axis=1)]


@pytest.fixture
def zoo(blend):
    """One of everything that shows a mesh: modifiers, linked data, curve, text, metaball, surface, instances of collections and nodes."""
    ops = bpy.ops
    ops.object.text_add(location=(0, 0, 5))
    ops.curve.primitive_bezier_circle_add(location=(5, 0, 0))
    bpy.context.object.data.bevel_depth = 0.1
    ops.object.metaball_add(location=(0, 5, 0))
    ops.surface.primitive_nurbs_surface_sphere_add(location=(5, 5, 0))
    ops.mesh.primitive_cube_add(location=(-5, 0, 0))
    cube = bpy.context.object
    cube.modifiers.new("array", "ARRAY")
    add(cube.data, (-5, 5, 0), "linked").scale = (1, -2, 0.5)
    collection = bpy.data.collections.new("assembly")
    collection.objects.link(bpy.data.objects.new("member", cube.data))
    for x in (10, 20):
        empty = add(None, (x, 0, 0), f"instance {x}")
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
    tree = bpy.data.node_groups.new("nodes", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    nodes = {
        kind: tree.nodes.new(kind)
        for kind in ("GeometryNodeMeshGrid", "GeometryNodeMeshCube", "GeometryNodeInstanceOnPoints", "NodeGroupOutput")
    }
    spread = nodes["GeometryNodeInstanceOnPoints"]
    tree.links.new(nodes["GeometryNodeMeshGrid"].outputs[0], spread.inputs["Points"])
    tree.links.new(nodes["GeometryNodeMeshCube"].outputs[0], spread.inputs["Instance"])
    tree.links.new(spread.outputs[0], nodes["NodeGroupOutput"].inputs[0])
    add(bpy.data.meshes.new("grown"), (0, 20, 0)).modifiers.new("nodes", "NODES").node_group = tree
    hidden = add(triangle(), (0, 0, 50), "hidden")
    hidden.hide_viewport = hidden.hide_render = True
    return collection


def test_everything_blender_shows_is_there_once(zoo):
    scene = read()
    expected = blender_triangles()
    assert same_triangles(without_slivers(world_triangles(scene)), without_slivers(expected))
    assert {"Text", "BézierCircle", "Mball", "SurfSphere", "Cube", "linked", "member", "grown"} == set(scene.object_names)
    assert "hidden" not in scene.object_names
    assert scene.object_names.count("member") == 2 and scene.object_names.count("grown") == 9


def test_linked_data_and_instances_share_one_mesh(zoo):
    scene = read()
    of = {name: scene.instances.mesh_index[i] for i, name in zip(scene.instances.object_id, scene.object_names, strict=True)}
    assert of["linked"] == of["member"] != of["Cube"]
    assert len(scene.meshes) == 7 and len(scene.instances) == len(scene.object_names) == 17
    assert np.array_equal(scene.instances.object_id, np.arange(17)), "every instance has an id of its own"


def test_what_did_not_change_is_not_fetched_again(zoo):
    reader = SceneReader()
    first = read(reader)
    assert reader.counts.fetched > 0
    again = read(reader)
    assert (reader.counts.fetched, reader.counts.prepared) == (0, 0)
    assert all(a is b for a, b in zip(first.meshes, again.meshes, strict=True))
    bpy.data.objects["linked"].location.x += 3
    moved = read(reader)
    assert reader.counts.fetched == 0 and not np.array_equal(moved.instances.world_from_object, first.instances.world_from_object)


def test_a_changed_mesh_is_read_and_the_others_keep_their_keys(zoo):
    reader = SceneReader()
    first = read(reader)
    data = bpy.data.objects["linked"].data
    data.vertices[0].co.x += 0.25
    data.update()
    second = read(reader)
    assert not same_triangles(world_triangles(second), world_triangles(first))
    assert len({m.key for m in first.meshes} & {m.key for m in second.meshes}) == 5, "all but the cube and its array"
    data.vertices[0].co.x -= 0.25
    data.update()
    assert {m.key for m in read(reader).meshes} == {m.key for m in first.meshes}, "equal content, equal key"


def test_the_key_depends_on_the_crease_angle_and_survives_a_new_reader(blend):
    add(triangle())
    key = read().meshes[0].key
    assert read().meshes[0].key == key != read(crease_angle_rad=1.0).meshes[0].key


def test_nothing_of_blender_is_kept_between_reads(zoo):
    reader = SceneReader()
    read(reader)
    seen, todo = set(), [vars(reader)]
    while todo:
        thing = todo.pop()
        if id(thing) in seen:
            continue
        seen.add(id(thing))
        assert not isinstance(thing, bpy.types.bpy_struct), thing
        if isinstance(thing, dict):
            todo += [*thing.keys(), *thing.values()]
        elif isinstance(thing, list | tuple | set):
            todo += list(thing)
        else:
            names = [*getattr(thing, "__dict__", ()), *(s for kind in type(thing).__mro__ for s in getattr(kind, "__slots__", ()))]
            todo += [getattr(thing, name) for name in names if hasattr(thing, name)]


def test_edits_in_edit_mode_are_seen(blend):
    ob = add(triangle())
    bpy.context.view_layer.objects.active = ob
    ob.select_set(True)
    reader = SceneReader()
    read(reader)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.transform.translate(value=(0, 0, 7))
    assert np.allclose(world_triangles(read(reader))[:, :, 2], 7)
    bpy.ops.object.mode_set(mode="OBJECT")


def painted(name, color):
    material = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    next(n for n in material.node_tree.nodes if n.type == "BSDF_PRINCIPLED").inputs["Base Color"].default_value = color
    return material


def test_a_slot_is_a_mesh_of_its_own_with_its_colour_and_the_objects_id(blend):
    data = mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 1, 2), (0, 1, 3), (0, 2, 3)])
    for name, color in (("red", (1, 0, 0, 1)), ("unused", (0, 0, 0, 1)), ("blue", (0, 0, 1, 1))):
        data.materials.append(painted(name, color))
    data.polygons.foreach_set("material_index", [0, 2, 2])
    add(data)
    other = add(data, name="own")
    other.material_slots[2].link, other.material_slots[2].material = "OBJECT", painted("own", (0, 1, 0, 1))
    scene = read()
    assert len(scene.meshes) == 2 and [len(m.triangles) for m in scene.meshes] == [1, 2]
    assert scene.instances.object_id.tolist() == [0, 0, 1, 1] and scene.instances.material_slot.tolist() == [0, 2, 0, 2]
    assert scene.instances.base_color[:, :3].tolist() == [[1, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0]]


def test_the_first_of_several_materials_may_be_none_and_the_object_may_override_the_second(blend):
    data = mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 1, 2), (0, 1, 3)])
    data.materials.append(None)
    data.materials.append(painted("red", (1, 0, 0, 1)))
    data.polygons.foreach_set("material_index", [0, 1])
    own = add(data)
    own.active_material_index = 0  # so that its active material is none
    own.material_slots[1].link, own.material_slots[1].material = "OBJECT", painted("own", (0, 1, 0, 1))
    assert read().instances.base_color[1, :3].tolist() == [0, 1, 0]


def test_a_scene_collected_in_slices_is_the_scene_collected_at_once(zoo):
    sliced, calls = SceneReader(), 1
    while (collected := sliced.collect(depsgraph(), seconds=0.0)) is None:
        calls += 1
    found, whole = collected.scene(), read()
    sliced.take(collected)
    assert calls == sliced.counts.fetched > 5  # one mesh each, none of them twice
    assert [m.key for m in found.meshes] == [m.key for m in whole.meshes]
    assert np.array_equal(world_triangles(found), world_triangles(whole))
    read(sliced)
    assert sliced.counts.fetched == 0


def test_what_changes_between_two_slices_is_fetched_again(blend):
    objects = [add(triangle(f"t{i}"), (0, 0, i)) for i in range(4)]
    reader = SceneReader()
    assert reader.collect(depsgraph(), seconds=0.0) is None
    for ob in objects:
        ob.data.vertices[0].co.x = 5.0
        ob.data.update()
    while (collected := reader.collect(depsgraph(), seconds=0.0)) is None:
        pass
    assert (world_triangles(collected.scene())[:, 0, 0] == 5.0).all()


def test_colours_come_from_the_shader_else_the_viewport_colour(blend):
    material = painted("m", (0.9, 0.8, 0.7, 1))
    material.diffuse_color = (0.1, 0.2, 0.3, 1)
    shader = next(n for n in material.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    shader.inputs["Alpha"].default_value = 0.5
    data = triangle()
    data.materials.append(material)
    ob = add(data)
    assert np.allclose(read().instances.base_color, [[0.9, 0.8, 0.7, 0.5]])
    texture = material.node_tree.nodes.new("ShaderNodeTexChecker")
    material.node_tree.links.new(texture.outputs[0], shader.inputs["Base Color"])
    assert np.allclose(read().instances.base_color, [[0.1, 0.2, 0.3, 1]])
    ob.color = (0.4, 0.5, 0.6, 1)
    assert np.allclose(read(use_object_color=True).instances.base_color, [[0.4, 0.5, 0.6, 1]])


def cylinder(sides=24):
    bpy.ops.mesh.primitive_cylinder_add(vertices=sides, radius=1, depth=2)
    return bpy.context.object


def test_a_mesh_is_flat_or_smooth_as_its_author_says(blend):
    ob = cylinder()
    bpy.ops.object.shade_flat()
    assert read().meshes[0].normals.shape == (24 * 4 + 48, 3), "every side has its own normals"
    bpy.ops.object.shade_smooth()
    bpy.context.view_layer.update()
    scene = read()
    normals = scene.meshes[0].normals
    assert len(normals) == 48, "one normal at each corner"
    assert (np.abs(normals[:, 2]) > 0.5).all(), "sides and caps share it"
    assert np.allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-4)
    loose = mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 1, 2), (3, 4, 5)], "loose")
    loose.shade_smooth()
    ob.data = loose
    bpy.context.view_layer.update()
    assert len(read().meshes[0].normals) == 6, "faces that only touch do not share normals"


def test_smooth_by_angle_is_obeyed(blend):
    cylinder()
    bpy.ops.object.shade_smooth()
    bpy.context.object.data.set_sharp_from_angle(angle=radians(40))
    bpy.context.view_layer.update()
    normals = read().meshes[0].normals
    assert np.allclose(np.sort(np.abs(normals[:, 2])), [0] * 48 + [1] * 48, atol=1e-5), "smooth sides, flat caps"


def test_flat_cad_gets_the_crease_angle_and_sharp_edges_are_obeyed(blend):
    ob = cylinder()
    bpy.ops.object.shade_flat()
    ob.data[CREASED] = True
    normals = read().meshes[0].normals
    assert np.allclose(np.sort(np.abs(normals[:, 2])), [0] * 48 + [1] * 48, atol=1e-5), "smooth sides, flat caps"
    assert read(crease_angle_rad=radians(1)).meshes[0].normals.shape == (24 * 4 + 48, 3)
    ob.data.set_sharp_from_angle(angle=radians(5))
    ob.data.update()
    bpy.context.view_layer.update()
    assert len(read().meshes[0].positions) == 24 * 4 + 48, "the author's sharp edges win over the crease angle"


def test_custom_normals_are_kept(blend):
    data = triangle()
    data.normals_split_custom_set([(0.6, 0, 0.8)] * 3)
    add(data)
    assert np.allclose(read().meshes[0].normals, [[0.6, 0, 0.8]] * 3, atol=1e-3)


@pytest.mark.parametrize("scale", [(1, 1, -1), (-1, -1, -1), (3, 1, 0.2), (-0.01, 0.01, 0.01)])
def test_normals_stand_on_their_surface_under_any_scale(blend, scale):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16)
    ob = bpy.context.object
    ob.scale, ob.rotation_euler = scale, (0.3, 0.5, 0.7)
    scene = read()
    m, mesh_ = scene.instances.world_from_object[0], scene.meshes[0]
    points = mesh_.positions @ m[:3, :3].T
    normals = mesh_.normals @ np.linalg.inv(m[:3, :3])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    p = points[mesh_.triangles]
    flat = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    agreement = np.abs(np.einsum("tci,ti->tc", normals[mesh_.triangles], flat))
    assert agreement.min() > 0.5 and np.median(agreement) > 0.98


def test_zero_scale_is_left_out_with_a_warning_and_the_rest_is_drawn(blend):
    add(triangle(), name="good")
    add(triangle(), name="squashed").scale = (0, 1, 1)
    scene = read()
    assert scene.object_names == ("good",) and any("'squashed'" in w and "scale" in w for w in scene.warnings)


def test_bad_vertices_and_flat_faces_are_left_out_with_a_count(blend):
    data = mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (2, 0, 0), (float("nan"), 0, 0)], [(0, 1, 2), (0, 1, 3), (0, 2, 4)], "dirty")
    add(data)
    add(mesh([(float("inf"), 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)], "hopeless"))
    add(bpy.data.meshes.new("empty"))
    scene = read()
    assert scene.object_names == ("dirty",) and scene.triangle_count == 1
    assert any("'dirty'" in w and "1 vertices" in w and "1 faces without area" in w for w in scene.warnings)
    assert any("Not drawn" in w and "'hopeless'" in w for w in scene.warnings)
    assert not any("empty" in w for w in scene.warnings)


def test_an_empty_scene_is_a_scene_that_says_so_when_drawn(blend):
    scene = read()
    assert len(scene.instances) == 0 and scene.meshes == ()
    with pytest.raises(SceneError, match="nothing to draw"):
        scene.bounds_ws()


def test_far_from_the_origin_the_millimetres_stay(blend):
    points = np.array([(0, 0, 0), (0.001, 0, 0), (0, 0.002, 0)], dtype=np.float32)
    add(mesh(points, [(0, 1, 2)], "near"), (300, -400, 20))
    add(mesh(points + np.float32([300, -400, 20]), [(0, 1, 2)], "far vertices"))
    scene = read()
    assert np.allclose(scene.origin_ws, (300, -400, 20), atol=0.01)
    assert np.abs(scene.instances.world_from_object[:, :3, 3]).max() < 0.01
    assert max(np.abs(m.positions).max() for m in scene.meshes) < 0.01
    for index, matrix in zip(scene.instances.mesh_index, scene.instances.world_from_object.astype(np.float32), strict=True):
        drawn = scene.meshes[index].positions @ matrix[:3, :3].T + matrix[:3, 3]
        size = drawn.max(axis=0) - drawn.min(axis=0)
        assert np.allclose(size, (0.001, 0.002, 0), atol=1e-8 if index == 0 else 4e-5), "float32 in Blender's own mesh is all that is lost"


@pytest.mark.parametrize("low", [(0, 0, 0), (-3, 1, 2), (1e5, -2e6, 40)])
def test_the_local_origin_is_near_and_steady(low):
    bounds = np.array([low, np.add(low, (10, 20, 5))], dtype=float)
    origin = local_origin(bounds)
    assert np.abs(bounds - origin).max() <= 20 + 16 and np.array_equal(origin, local_origin(bounds + 0.01))
    assert np.array_equal(local_origin(np.array([(-1.0, -2, 0), (1, 2, 3)])), (0, 0, 0))
