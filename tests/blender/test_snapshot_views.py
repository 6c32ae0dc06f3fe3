"""Cameras, lights and viewports of a snapshot are as Blender has them."""

from math import pi
from types import SimpleNamespace

import bpy  # before mathutils and bpy_extras, which it brings
import numpy as np
import pytest
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Matrix, Vector

from addon.blender.snapshot import camera_from_object, camera_from_region, choose_light, reaches
from addon.errors import SceneError
from tests.blender.snapshot_rigs import SIZE, add, depsgraph, read, triangle


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_cameras_project_as_blender_does(blend, kind):
    add(triangle(), (100, 50, 0))
    data = bpy.data.cameras.new("camera")
    data.type, data.shift_x, data.shift_y, data.clip_start, data.clip_end = kind, 0.1, -0.2, 0.5, 200
    camera = add(data, (107, 43, 5))
    camera.rotation_euler, camera.scale = (1.1, 0.1, 0.7), (2, 3, 4)
    bpy.context.scene.camera = camera
    bpy.context.scene.render.resolution_x, bpy.context.scene.render.resolution_y = SIZE
    scene = read()
    made = scene.cameras[0]
    assert made.name == "camera" and made.is_orthographic == (kind == "ORTHO")
    assert np.isclose(made.near, 0.5) and np.isclose(made.far, 200)
    for point in ((100, 50, 0), (98, 52, 1), (103, 47, 2)):
        x, y, depth = world_to_camera_view(bpy.context.scene, camera, Vector(point))
        clip = made.clip_from_world @ np.append(np.array(point) - scene.origin_ws, 1)
        assert np.allclose(clip[:2] / clip[3], (2 * x - 1, 2 * y - 1), atol=1e-4)
        view = made.view_from_world @ np.append(np.array(point) - scene.origin_ws, 1)
        assert np.isclose(-view[2], depth, atol=1e-3)
    assert np.allclose(made.view_from_world[:3, :3] @ made.view_from_world[:3, :3].T, np.eye(3), atol=1e-6)


def test_the_active_camera_comes_first_and_a_panoramic_one_complains(blend):
    for name in ("a", "b", "wide"):
        add(bpy.data.cameras.new(name))
    bpy.data.cameras["wide"].type = "PANO"
    bpy.context.scene.camera = bpy.data.objects["b"]
    scene = read()
    assert [c.name for c in scene.cameras] == ["b", "a"] and any("'wide' is panoramic" in w for w in scene.warnings)
    with pytest.raises(SceneError, match="Perspective"):
        camera_from_object(bpy.data.objects["wide"], depsgraph(), SIZE, np.zeros(3))


def light(kind, name, energy, location=(0, 0, 0), rotation=(0, 0, 0)):
    data = bpy.data.lights.new(name, kind)
    data.energy = energy
    ob = add(data, location)
    ob.rotation_euler = rotation
    return ob


def test_lights_point_where_blenders_do(blend):
    add(triangle(), (1000, 0, 0))
    light("SUN", "sun", 3, rotation=(0.4, 0.3, 0.2)).scale = (5, 5, 5)
    spot = light("SPOT", "spot", 100, (1001, 2, 3), (0.1, 0, 0))
    spot.data.spot_size, spot.data.spot_blend, spot.data.color = 1.0, 0.3, (1, 0.5, 0)
    light("POINT", "point", 10, (1004, 0, 1))
    light("AREA", "area", 10, (1000, 0, 9))
    hidden = light("SUN", "hidden", 99)
    hidden.hide_viewport = hidden.hide_render = True
    scene = read()
    found = {entry.name: entry for entry in scene.lights}
    assert set(found) == {"sun", "spot", "point", "area"}
    shining = bpy.data.objects["sun"].matrix_world.to_3x3() @ Vector((0, 0, -1))
    assert np.allclose(found["sun"].direction_ws, -shining.normalized(), atol=1e-6) and np.allclose(found["sun"].color, (3, 3, 3))
    assert np.allclose(found["spot"].position_ws + scene.origin_ws, (1001, 2, 3)) and np.isclose(found["spot"].cone_rad, 0.5)
    assert np.allclose(found["spot"].color, np.array([1, 0.5, 0]) * 100 / (4 * pi)) and np.isclose(found["spot"].cone_blend, 0.3)
    assert np.allclose(found["area"].half_axes_ws, np.eye(3)[:2] * 0.5 * bpy.data.lights["area"].size)
    assert np.isclose(found["sun"].half_angle_rad, bpy.data.lights["sun"].angle / 2.0)
    assert np.isclose(found["point"].radius, bpy.data.lights["point"].shadow_soft_size)
    assert np.allclose(found["point"].position_ws + scene.origin_ws, (1004, 0, 1)) and found["point"].direction_ws is None


def test_the_strongest_sun_is_chosen_unless_one_is_named(blend):
    light("POINT", "lamp", 5000)
    assert choose_light(read().lights).name == "lamp" and choose_light(()) is None
    light("SUN", "weak", 1)
    light("SUN", "strong", 2)
    lights = read().lights
    assert choose_light(lights).name == "strong" and choose_light(lights, "lamp").kind == "point"
    with pytest.raises(SceneError, match="choose one of"):
        choose_light(lights, "gone")


def test_a_lamp_too_faint_for_the_model_is_known_as_such(blend):
    """Blender's own start-up lamp lights a cube but not a plant."""
    light("POINT", "lamp", 1000)
    lamp = read().lights[0]
    around = np.array([[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]])
    assert reaches(lamp, around) and not reaches(lamp, 60.0 * around)
    light("SUN", "sun", 0.001)
    assert reaches(choose_light(read().lights), 1e5 * around)


def test_viewports_are_cameras(blend):
    view = Matrix.LocRotScale((5, -8, 3), Matrix.Rotation(1.1, 3, "X"), None).inverted()
    perspective = Matrix(((1.5, 0, 0, 0), (0, 2.5, 0, 0), (0, 0, -1.002, -0.2002), (0, 0, -1, 0)))
    flat = Matrix(((0.2, 0, 0, 0), (0, 0.3, 0, 0), (0, 0, -0.002, 0), (0, 0, 0, 1)))
    for matrix, is_perspective, near, far in ((perspective, True, 0.1, 100.1), (flat, False, -500, 500)):
        region = SimpleNamespace(view_matrix=view, window_matrix=matrix, is_perspective=is_perspective, view_perspective="PERSP")
        camera = camera_from_region(region, SimpleNamespace(clip_start=0.1, clip_end=200), np.array([1.0, 2.0, 3.0]), SIZE)
        assert np.allclose(camera.eye_ws, (4, -10, 0), atol=1e-5)
        assert np.isclose(camera.near, near, rtol=2e-3) and np.isclose(camera.far, far, rtol=2e-2)
        assert camera.is_orthographic != is_perspective


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
@pytest.mark.parametrize(("near", "far"), [(0.001, 1e5), (1e-4, 5.0), (0.1, 2e7)])
def test_near_and_far_are_exact_however_far_apart(blend, kind, near, far):
    """Blender's matrices are float32: of a far plane 1e8 times as far as the near one they hold nothing."""
    data = bpy.data.cameras.new("camera")
    data.type, data.clip_start, data.clip_end = kind, near, far
    camera = add(data, (7, -3, 5))
    bpy.context.view_layer.update()
    rendered = camera_from_object(camera, depsgraph(), SIZE, np.zeros(3))
    window = camera.calc_matrix_camera(depsgraph(), x=SIZE[0], y=SIZE[1])
    region = SimpleNamespace(view_matrix=Matrix(), window_matrix=window, is_perspective=kind == "PERSP", view_perspective="CAMERA")
    seen = camera_from_region(region, SimpleNamespace(clip_start=0.01, clip_end=1000.0, camera=camera), np.zeros(3), SIZE)
    for made in (rendered, seen):
        assert (made.near, made.far) == (data.clip_start, data.clip_end)
        ends = made.clip_from_view @ np.array([[0.0, 0.0], [0.0, 0.0], [-made.near, -made.far], [1.0, 1.0]])
        assert np.allclose(ends[2] / ends[3], [-1.0, 1.0], rtol=0.0, atol=1e-9)
