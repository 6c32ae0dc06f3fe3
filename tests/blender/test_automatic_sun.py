"""The sun of a scene that has none stands in the world, whatever looks at it from wherever; one that follows the view is a choice."""

import numpy as np
import pytest

from addon.scene.default_view import VIEWS, world_sun

EYES = [(9.0, -9.0, 6.0), (-7.0, 2.0, 5.0), (0.5, 8.0, -3.0)]


@pytest.fixture
def dark(cube_scene, blend):
    """The scene without its sun."""
    blend.data.objects.remove(blend.data.objects["Sun"])
    return cube_scene


def looking_from(dark, eye):
    """Move the scene's camera."""
    from mathutils import Vector

    dark.camera.location = eye
    dark.camera.rotation_euler = (-Vector(eye)).to_track_quat("-Z", "Y").to_euler()


def of_a_render(blend, room, dark):
    assert blend.ops.render.render(scene=dark.name) == {"FINISHED"}
    return room("blender.session").last().job


def of_the_window(blend, room, dark):
    blend.context.view_layer.update()
    return room("blender.sources").ViewReading().job(blend.context)


@pytest.mark.parametrize("made", [of_a_render, of_the_window])
def test_it_stays_where_it_is_when_the_camera_moves(blend, room, dark, made):
    found = []
    for eye in EYES:
        looking_from(dark, eye)
        found.append(made(blend, room, dark).light.direction_ws)
    assert np.allclose(found, world_sun().direction_ws)


def test_it_stays_from_frame_to_frame_of_an_animation(blend, room, dark):
    for frame, turn in ((1, 0.0), (2, 2.0)):
        dark.camera.rotation_euler = (1.0, 0.0, turn)
        dark.camera.keyframe_insert("rotation_euler", frame=frame)
    found = []
    for frame in (1, 2):
        dark.frame_set(frame)
        found.append(of_a_render(blend, room, dark).light.direction_ws)
    assert np.array_equal(*found)


def test_it_stays_for_a_script_that_goes_round_the_model(api, dark):
    found = [api.preview(eye=eye, target=(0, 0, 0), size=(16, 16)).light.direction_ws for eye in EYES]
    assert np.allclose(found, world_sun().direction_ws)


def test_a_lamp_that_hardly_reaches_the_model_does_not_make_it_turn(blend, room, dark):
    blend.ops.object.light_add(type="POINT", location=(0, 0, 500))
    found = []
    for eye in EYES:
        looking_from(dark, eye)
        job = of_the_window(blend, room, dark)
        found.append(job.light.direction_ws)
        assert any("hardly reaches" in warning for warning in job.warnings)
    assert np.allclose(found, world_sun().direction_ws)


def test_follows_the_view_is_a_sun_at_the_upper_left_of_every_view_whatever_lights_there_are(blend, room, dark):
    blend.ops.object.light_add(type="SUN")
    dark.cad_shadow.light_source = "VIEW"
    for eye in EYES[:2]:
        looking_from(dark, eye)
        job = of_the_window(blend, room, dark)
        x, y, _ = job.camera.view_from_world[:3, :3] @ job.light.direction_ws
        assert x < 0 < y and job.light.kind == "sun"
        assert not any("light" in warning for warning in job.warnings)


@pytest.mark.parametrize("view", ["iso", "front", "back", "left", "right"])
def test_standard_views_are_lit_as_drawings_are(api, dark, view):
    preview = api.preview(view=view, size=(16, 16))
    x, y, _ = preview.camera.view_from_world[:3, :3] @ preview.light.direction_ws
    assert view in VIEWS and x < 0 < y


def test_files_made_before_keep_their_choice(blend):
    numbers = {item.identifier: item.value for item in blend.context.scene.cad_shadow.bl_rna.properties["light_source"].enum_items}
    assert numbers == {"AUTOMATIC": 0, "OBJECT": 1, "DIRECTION": 2, "VIEW": 3}
