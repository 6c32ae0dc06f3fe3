"""Camera and sun helpers: they change what they say, can be undone, say why they are grey, and make the pictures promised."""

from math import degrees, pi, radians

import numpy as np
import pytest


@pytest.fixture
def noon(blend):
    """London at midsummer, one o'clock summer time, as the scene's place; gives the properties."""
    sun = blend.context.scene.cad_shadow.sun
    sun.latitude, sun.longitude, sun.year, sun.month, sun.day, sun.hours = 51.5074, -0.1278, 2026, 6, 21, 13.0
    sun.use_utc_offset, sun.utc_offset = True, 1.0
    return sun


def towards(ob):
    """The direction a light's light comes from."""
    return np.array(ob.matrix_world.col[2][:3])


def sun_of(bpy):
    return bpy.context.scene.cad_shadow.light


def test_the_sun_stands_in_the_south_at_noon_as_high_as_the_almanac_says(cube_scene, noon, blend):
    assert blend.ops.cad_shadow.place_sun() == {"FINISHED"}
    x, y, z = towards(sun_of(blend))
    assert degrees(np.arcsin(z)) == pytest.approx(90 - 51.51 + 23.44, abs=0.1)
    assert y < 0.0
    assert abs(x) < 0.01
    assert cube_scene.cad_shadow.light_source == "OBJECT"
    assert len([o for o in cube_scene.objects if o.type == "LIGHT"]) == 1, "the scene's own sun is taken"


@pytest.mark.parametrize("mode", ["XYZ", "ZYX", "QUATERNION", "AXIS_ANGLE"])
def test_whatever_the_rotation_mode_and_the_parent(cube_scene, noon, blend, mode):
    sun = next(o for o in cube_scene.objects if o.type == "LIGHT")
    sun.rotation_mode, sun.parent = mode, blend.data.objects["Cube"]
    sun.parent.rotation_euler = (0.4, 0.5, 0.6)
    blend.context.view_layer.update()
    blend.ops.cad_shadow.place_sun()
    assert degrees(np.arcsin(towards(sun)[2])) == pytest.approx(61.94, abs=0.1)


def test_north_may_lie_anywhere(cube_scene, noon, blend):
    noon.north_offset = pi / 2
    blend.ops.cad_shadow.place_sun()
    x, y, _ = towards(sun_of(blend))
    assert x < -0.4
    assert abs(y) < 0.01


def test_a_scene_without_a_sun_gets_one_and_undo_takes_it_away(blend, noon):
    blend.ops.mesh.primitive_cube_add()
    blend.ops.ed.undo_push(message="before")
    assert blend.ops.cad_shadow.place_sun() == {"FINISHED"}
    assert sun_of(blend).data.type == "SUN" and sun_of(blend).data.energy == 1.0, "as bright as one added by hand"
    blend.ops.ed.undo_push(message="after")  # what the window does after an operator with UNDO
    blend.ops.ed.undo()
    assert not [o for o in blend.context.scene.objects if o.type == "LIGHT"]


def test_a_date_that_does_not_exist_is_refused_in_a_line(cube_scene, noon, blend):
    noon.month, noon.day = 2, 30
    for operator in (blend.ops.cad_shadow.place_sun, blend.ops.cad_shadow.animate_sun, blend.ops.cad_shadow.sun_study):
        with pytest.raises(RuntimeError, match="There is no 2026-02-30"):
            operator()


def test_the_time_zone_follows_the_longitude_until_it_is_set(room, blend, noon):
    noon.use_utc_offset, noon.longitude = False, 103.8
    assert room("blender.sun_properties").sky_of(noon)[0].utc_offset_h == 7.0


def test_sun_position_gets_place_time_and_sun_when_it_is_enabled(cube_scene, noon, blend, room):
    """A stand-in with the add-on's property names that refuses impossible dates on the way, as the add-on's own update does."""
    from datetime import date

    seen = []

    def update(self, _context):
        date(self.year, self.month, self.day)
        seen.append((self.latitude, self.time, self.UTC_zone, self.day, self.sun_object))

    props = blend.props
    numbers = dict.fromkeys(("latitude", "longitude", "north_offset", "UTC_zone", "time"), props.FloatProperty(update=update))
    whole = dict.fromkeys(("year", "month"), props.IntProperty(default=1, update=update))
    flags = dict.fromkeys(("use_day_of_year", "use_daylight_savings"), props.BoolProperty(default=True, update=update))
    fields = {
        "usage_mode": props.StringProperty(update=update),
        "day": props.IntProperty(default=31, update=update),
        "sun_object": props.PointerProperty(type=blend.types.Object, update=update),
    }
    stand_in = type("StandIn", (blend.types.PropertyGroup,), {"__annotations__": numbers | whole | flags | fields})
    blend.utils.register_class(stand_in)
    blend.types.Scene.sun_pos_properties = props.PointerProperty(type=stand_in)
    try:
        before = [towards(o) for o in cube_scene.objects if o.type == "LIGHT"]
        assert blend.ops.cad_shadow.place_sun() == {"FINISHED"}
        latitude, time, zone, day, sun = seen[-1]
        assert (round(latitude, 4), time, zone, day) == (51.5074, 13.0, 1.0, 21)
        assert sun == sun_of(blend)
        assert np.array_equal(towards(sun), before[0]), "the add-on moves it, not we"
    finally:
        del blend.types.Scene.sun_pos_properties
        blend.utils.unregister_class(stand_in)


def test_the_animation_goes_from_sunrise_to_sunset_without_a_jump(cube_scene, noon, blend):
    cube_scene.frame_start, cube_scene.frame_end = 5, 29
    assert blend.ops.cad_shadow.animate_sun() == {"FINISHED"}
    directions = []
    for frame in range(5, 30):
        cube_scene.frame_set(frame)
        directions.append(towards(sun_of(blend)))
    heights = [degrees(np.arcsin(d[2])) for d in directions]
    assert abs(heights[0]) < 1.0
    assert abs(heights[-1]) < 1.0
    assert max(heights) == pytest.approx(61.9, abs=0.5)
    assert max(degrees(np.arccos(np.clip(a @ b, -1, 1))) for a, b in zip(directions, directions[1:], strict=False)) < 15.0
    cube_scene.frame_set(17, subframe=0.5)
    between = towards(sun_of(blend))
    assert min(between @ directions[12], between @ directions[13]) > directions[12] @ directions[13], "no swinging around"


def test_a_sun_study_is_a_sheet_of_the_steps(cube_scene, noon, blend):
    noon.use_hours, noon.start, noon.end, noon.steps = True, 0.0, 12.0, 4
    assert blend.ops.cad_shadow.sun_study() == {"FINISHED"}
    image = blend.data.images["CAD Shadow Preview: sun study"]
    width, height = image.size
    assert width > 2 * 96
    assert height > 2 * 64
    values = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(values)
    picture = values.reshape(height, width, 4)[::-1]
    night, day = picture[8:72, 8:104], picture[-88:-24, -104:-8]
    assert day.mean() > night.mean()


def test_fitting_near_and_far_puts_everything_between_them(cube_scene, blend):
    camera = cube_scene.camera
    camera.data.clip_start, camera.data.clip_end = 0.001, 100000.0
    assert blend.ops.cad_shadow.fit_clip() == {"FINISHED"}
    inverse = np.linalg.inv(np.array(camera.matrix_world))
    points = [inverse @ [*(o.matrix_world @ v.co), 1] for o in cube_scene.objects if o.type == "MESH" for v in o.data.vertices]
    depth = -np.array(points)[:, 2]
    assert camera.data.clip_start <= depth.min()
    assert camera.data.clip_end >= depth.max()
    assert camera.data.clip_end / camera.data.clip_start < 10.0


def test_a_camera_that_looks_away_is_told_so(cube_scene, blend):
    cube_scene.camera.rotation_euler.x += pi
    with pytest.raises(RuntimeError, match="behind the camera"):
        blend.ops.cad_shadow.fit_clip()


@pytest.mark.parametrize("view", ["ISO", "TOP", "FRONT"])
@pytest.mark.parametrize("size", [(160, 90), (90, 160)])
def test_a_framing_camera_sees_everything(cube_scene, blend, view, size):
    from bpy_extras.object_utils import world_to_camera_view
    from mathutils import Vector

    cube_scene.render.resolution_x, cube_scene.render.resolution_y = size
    for ob in cube_scene.objects:
        ob.location.x += 3000.0
    assert blend.ops.cad_shadow.frame_camera(view=view, fov_y=radians(35.0)) == {"FINISHED"}
    camera = cube_scene.camera
    assert degrees(camera.data.angle_y) == pytest.approx(35.0, abs=1e-3)
    blend.context.view_layer.update()
    seen = np.array(
        [
            world_to_camera_view(cube_scene, camera, o.matrix_world @ Vector(c))
            for o in cube_scene.objects
            if o.type == "MESH"
            for c in o.bound_box
        ]
    )
    assert seen[:, :2].min() > 0.0
    assert seen[:, :2].max() < 1.0
    assert np.ptp(seen[:, :2], axis=0).max() == pytest.approx(0.94, abs=0.01), "and fills the picture"
    assert camera.data.clip_start < seen[:, 2].min()
    assert camera.data.clip_end > seen[:, 2].max()


def test_helpers_are_grey_and_say_why(blend):
    for operator in (blend.ops.cad_shadow.fit_clip, blend.ops.cad_shadow.frame_camera, blend.ops.cad_shadow.sun_study):
        assert not operator.poll()
        with pytest.raises(RuntimeError, match="no mesh to draw"):
            operator()
    blend.ops.mesh.primitive_cube_add()
    with pytest.raises(RuntimeError, match="has no camera"):
        blend.ops.cad_shadow.fit_clip()


def test_what_changes_data_can_be_undone(blend):
    for name in ("fit_clip", "frame_camera", "place_sun", "animate_sun"):
        assert "UNDO" in getattr(blend.types, f"CAD_SHADOW_OT_{name}").bl_options


def test_a_change_of_time_or_place_moves_the_sun_at_once(blend):
    blend.ops.cad_shadow.place_sun()
    props, sun = blend.context.scene.cad_shadow, blend.context.scene.cad_shadow.light
    was = sun.matrix_world.copy()
    for name, value in (("hours", 15.5), ("latitude", 10.0), ("month", 1)):
        setattr(props.sun, name, value)
        assert sun.matrix_world != was, name
        was = sun.matrix_world.copy()
    placed = sun.matrix_world.to_3x3().col[2].copy()
    blend.ops.cad_shadow.place_sun()
    assert (sun.matrix_world.to_3x3().col[2] - placed).length < 1e-5
    props.sun.month = 2
    placed = sun.matrix_world.to_3x3().col[2].copy()
    props.sun.day = 31
    assert (sun.matrix_world.to_3x3().col[2] - placed).length < 1e-5, "a day that does not exist moved it"
    props.light_source = "AUTOMATIC"
    props.sun.day = 3
    assert (sun.matrix_world.to_3x3().col[2] - placed).length < 1e-5, "a sun that is not the chosen light moved"


def test_the_suns_path_rises_in_the_east_and_is_highest_in_the_south(room):
    maths, path = room("maths.sun"), room("blender.hud.sun_path")
    from datetime import date

    found = path.path_of(maths.Clock(date(2026, 6, 21), 2.0), maths.Place(1.0, 0.2), 12.0)
    way = found["path"].reshape(-1, 3)
    assert np.allclose(np.linalg.norm(way, axis=1), 1.0) and (way[:, 2] > -0.02).all()
    assert way[0, 0] > 0.5 and way[-1, 0] < -0.5 and way[way[:, 2].argmax(), 1] < -0.3
    assert 14 <= len(found["hours"]) <= 19 and len(found["now"]) == 1
    assert len(path.path_of(maths.Clock(date(2026, 6, 21), 2.0), maths.Place(1.0, 0.2), 1.0)["now"]) == 0
