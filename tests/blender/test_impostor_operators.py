"""Impostors in Blender: operators, list, report, what the file keeps, and how they leave as planes."""

import numpy as np
import pytest

from tests.blender.impostor_rig import SIZE, rendered, select, small


def test_make_impostors_marks_what_has_a_surface_and_undo_takes_it_back(ball, blend):
    blend.ops.ed.undo_push(message="before")
    select(blend, ball, blend.data.objects["Sun"])
    assert blend.ops.cad_shadow.impostor_create(target="OBJECTS") == {"FINISHED"}
    assert ball.cad_shadow_impostor and not blend.data.objects["Sun"].cad_shadow_impostor
    assert [row.name for row in blend.context.window_manager.cad_shadow_impostors] == [ball.name]
    name = ball.name
    blend.ops.ed.undo_push(message="after")
    blend.ops.ed.undo()
    assert not blend.data.objects[name].cad_shadow_impostor
    assert not len(blend.context.window_manager.cad_shadow_impostors)
    blend.ops.ed.redo()
    assert blend.data.objects[name].cad_shadow_impostor
    assert len(blend.context.window_manager.cad_shadow_impostors) == 1


def test_the_operators_say_why_they_are_grey(ball, blend, cube_scene):
    ops = blend.ops.cad_shadow
    select(blend, blend.data.objects["Camera"])
    for name, reason in (
        ("impostor_create", "Select an object with a surface"),
        ("impostor_remove", "Nothing is marked"),
        ("impostor_report", "Nothing is marked"),
        ("impostor_regenerate", "Nothing is marked"),
        ("impostor_export", "Nothing is marked"),
    ):
        assert not getattr(ops, name).poll()
        with pytest.raises(RuntimeError, match=reason):
            getattr(ops, name)()
    ball.cad_shadow_impostor = True
    cube_scene.cad_shadow.impostor_use = "off"
    with pytest.raises(RuntimeError, match="switched off"):
        ops.impostor_report()


def test_the_active_collection_becomes_one_impostor_but_never_the_scenes_own(ball, blend, cube_scene):
    ops = blend.ops.cad_shadow
    with pytest.raises(RuntimeError, match="scene's own collection"):
        select(blend, ball)
        ops.impostor_create(target="COLLECTION")
    group = blend.data.collections.new("Pumps")
    cube_scene.collection.children.link(group)
    group.objects.link(ball)
    layer = blend.context.view_layer
    layer.active_layer_collection = layer.layer_collection.children["Pumps"]
    assert ops.impostor_create(target="COLLECTION") == {"FINISHED"}
    assert group.cad_shadow_impostor and not ball.cad_shadow_impostor
    assert ops.impostor_remove(target="ALL") == {"FINISHED"}
    assert not group.cad_shadow_impostor


def test_regenerate_captures_those_it_is_told_to(ball, blend, cube_scene, room):
    small(cube_scene)
    cube = blend.data.objects["Cube"]
    ball.cad_shadow_impostor = cube.cad_shadow_impostor = True
    cube_scene.cad_shadow.impostor_use = "manual"
    ops, session = blend.ops.cad_shadow, room("blender.session")

    def stages():
        return {r.name: r.stage for r in session.impostors()}

    ops.analyse()
    assert set(stages().values()) == {"regenerated"}
    cube_scene.camera.location.x += 0.1
    select(blend, ball)
    assert ops.impostor_regenerate(target="SELECTED") == {"FINISHED"}
    assert stages()[ball.name] == "regenerated" and stages()["Cube"] in ("sprite", "warp")
    cube.location.x += 0.2
    ops.analyse()
    assert stages()["Cube"] == "geometry"
    assert ops.impostor_regenerate(target="STALE") == {"FINISHED"}
    assert stages()["Cube"] == "regenerated" and stages()[ball.name] != "regenerated"
    rows = blend.context.window_manager.cad_shadow_impostors
    blend.context.window_manager.cad_shadow_impostor_index = [row.name for row in rows].index(ball.name)
    assert ops.impostor_regenerate(target="ACTIVE") == {"FINISHED"}
    assert stages()[ball.name] == "regenerated" and stages()["Cube"] != "regenerated"
    assert ops.impostor_regenerate(target="ALL") == {"FINISHED"}
    assert set(stages().values()) == {"regenerated"}
    select(blend, blend.data.objects["Plane"])
    with pytest.raises(RuntimeError, match="None of the selected objects is an impostor"):
        ops.impostor_regenerate(target="SELECTED")


def test_the_report_has_every_predictor_and_shows_the_critical_points(ball, blend, cube_scene, room):
    small(cube_scene)
    ball.cad_shadow_impostor = True
    ops, session, predictors = blend.ops.cad_shadow, room("blender.session"), room("maths.relief.error").PREDICTORS
    ops.analyse()
    cube_scene.camera.location.x += 0.2
    assert ops.impostor_report() == {"FINISHED"}
    (report,) = session.impostors()
    assert set(predictors) <= set(report.errors) and report.errors["critical"] > 0.0
    row = session.last().report["impostors"][0]
    assert row["name"] == ball.name and row["beta_trans_p"] > 0.0 and row["predicted"].keys() == report.errors.keys()
    image = blend.data.images["CAD Shadow Preview: critical points"]
    assert tuple(image.size) == report.size
    assert blend.context.window_manager.cad_shadow_impostor_points
    points, quads = room("blender.hud.impostor_overlay").shapes(session.impostors(), session.impostor_origin())
    away = np.linalg.norm(points - np.array(ball.location), axis=1)
    assert len(points) and (away < 1.05).all() and len(quads) == 1
    pixels = np.array(image.pixels[:]).reshape(image.size[1], image.size[0], 4)[::-1]
    uv = room("studies.impostors.states").critical_places(report.edges)[0].astype(int)
    assert np.allclose(pixels[uv[:, 1], uv[:, 0], :3], room("studies.impostors.states").CROSS, atol=0.02)


def test_the_report_lists_the_largest_error_first(ball, blend, cube_scene, room):
    small(cube_scene)
    cube = blend.data.objects["Cube"]
    ball.cad_shadow_impostor = cube.cad_shadow_impostor = True
    cube_scene.cad_shadow.impostor_captures = 2
    cube_scene.cad_shadow.impostor_use = "manual"
    blend.ops.cad_shadow.analyse()
    cube_scene.camera.location.x += 0.3
    blend.ops.cad_shadow.impostor_report()
    room_of = room("operators.impostor_report")
    ranked = [r.error for r in room_of.by_error(room("blender.session").impostors())]
    assert len(ranked) == 2 and ranked == sorted(ranked, reverse=True) and ranked[0] > ranked[1] > 0.0


def test_overrides_of_linked_objects_can_be_marked(blend):
    assert all(kind.bl_rna.properties["cad_shadow_impostor"].is_overridable for kind in (blend.types.Object, blend.types.Collection))


def test_marks_and_settings_are_saved_and_the_textures_on_request(ball, blend, cube_scene, tmp_path):
    small(cube_scene)
    name = ball.name
    ball.cad_shadow_impostor = True
    cube_scene.cad_shadow.impostor_predictor, cube_scene.cad_shadow.impostor_tilt = "critical", 20.0
    assert blend.ops.cad_shadow.impostor_export(to="PACKED") == {"FINISHED"}
    path = tmp_path / "saved.blend"
    blend.ops.wm.save_as_mainfile(filepath=str(path))
    blend.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    assert not len(blend.context.window_manager.cad_shadow_impostors)
    blend.ops.wm.open_mainfile(filepath=str(path))
    props = blend.context.scene.cad_shadow
    assert blend.data.objects[name].cad_shadow_impostor and (props.impostor_predictor, props.impostor_tilt) == ("critical", 20.0)
    assert [row.name for row in blend.context.window_manager.cad_shadow_impostors] == [name]
    color = blend.data.images[f"Impostor {name} color"]
    assert color.packed_file and min(color.size) > 10 and "world_from_plane" in color["cad_shadow_impostor"]
    depth = blend.data.images[f"Impostor {name} depth"]
    assert depth.packed_file and depth.is_float and tuple(depth.size) == tuple(color.size)


def test_a_plane_shows_the_impostor_in_another_engine_where_it_was_captured(ball, api, blend, cube_scene, room):
    ball.cad_shadow_impostor = True
    (captured,) = api.impostors([ball.name], size=SIZE, samples=1, map_size=128)
    plane = captured.to_plane()
    camera = room("blender.impostors.plane").capture_camera(captured.baked, captured.metadata)
    cube_scene.collection.objects.link(camera)
    for ob in cube_scene.objects:
        ob.hide_render = ob not in (plane, camera)
    height, width = captured.mask.shape
    render = cube_scene.render
    cube_scene.camera, render.engine, render.film_transparent = camera, "CYCLES", True
    render.resolution_x, render.resolution_y = width, height
    cube_scene.cycles.samples, cube_scene.cycles.use_denoising, cube_scene.cycles.pixel_filter_type = 1, False, "BOX"
    picture = rendered(blend, cube_scene)
    shown = picture[..., 3] > 0.5
    assert (shown & captured.mask).sum() / (shown | captured.mask).sum() > 0.97
    inner = captured.mask & shown
    assert np.median(np.abs(picture - captured.color)[inner][:, :3]) < 0.02


def test_unlit_captures_hold_the_objects_own_colour(ball, api, blend):
    material = blend.data.materials.new("Red")
    material.diffuse_color = (0.8, 0.1, 0.05, 1.0)
    if blend.app.version < (5, 0, 0):
        material.use_nodes = True
    material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.8, 0.1, 0.05, 1.0)
    ball.data.materials.append(material)
    (captured,) = api.impostors([ball.name], size=SIZE, unlit=True)
    assert np.allclose(captured.color[captured.mask], (0.8, 0.1, 0.05, 1.0), atol=1e-3)


def test_naming_what_is_not_there_and_what_cannot_be_captured_says_so(ball, api, blend, room):
    error = room("errors").SceneError
    with pytest.raises(error, match="no object or collection 'Pump'"):
        api.impostors(["Pump"])
    with pytest.raises(error, match="'Sun' has no surface"):
        api.impostors(["Sun"])
    ball.location = (60, -60, 48)
    with pytest.raises(error, match="behind"):
        api.impostors([ball.name], size=SIZE)
    with pytest.raises(error, match="where the camera goes"):
        api.impostor_path([ball.name])
    assert not ball.cad_shadow_impostor, "naming it does not mark it"
