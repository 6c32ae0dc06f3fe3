"""Impostors in Blender: what is marked is drawn from its texture, keeps its identity, and is never shown where it would be wrong."""

import importlib
from types import SimpleNamespace

import numpy as np
import pytest

SIZE = (96, 64)


@pytest.fixture
def room(extension):
    return lambda name: importlib.import_module(f"{extension.__name__}.{name}")


@pytest.fixture
def api(room):
    return room("api")


@pytest.fixture
def ball(cube_scene, blend):
    """A ball beside the cube, dense enough to be worth an impostor, drawn as one whatever it costs."""
    blend.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=1.0, location=(2.5, 1, 1.2))
    cube_scene.cad_shadow.impostor_break_even = False
    return blend.context.object


@pytest.fixture
def view(api, room):
    """What the life cycle makes of the present view (F12 in the settings below captures anew each time)."""

    def draw(**arguments):
        result = api.preview(size=SIZE, samples=1, map_size=128, **({"impostor_fresh": False} | arguments))
        return result, {report.name: report for report in result.impostors}

    yield draw
    room("session").forget()


def without(draw, **arguments):
    return draw(impostor_use="off", **arguments)[0]


def difference(a, b):
    """Share of pixels that differ visibly, of all."""
    return float((np.abs(a.combined - b.combined).max(axis=-1) > 0.05).mean())


def test_a_marked_object_looks_as_its_geometry_where_it_was_captured_and_saves_its_triangles(ball, view):
    ball.cad_shadow_impostor = True
    shown, reports = view()
    truth = without(view)
    assert reports[ball.name].stage == "regenerated"
    assert difference(shown, truth) < 0.004
    assert (shown.passes["object"] != truth.passes["object"]).mean() < 0.006
    assert shown.report["geometry"]["triangles_saved"] == 2 * 48 * 23
    assert shown.report["geometry"]["triangles_saved"] == reports[ball.name].triangles == 2 * 48 * 23
    assert "triangles_saved" not in truth.report["geometry"] and "impostors" not in truth.report


def test_the_original_stays_as_it_is(ball, view, blend):
    before = ball.data.as_pointer(), ball.matrix_world.copy(), ball.name, len(blend.data.objects)
    ball.cad_shadow_impostor = True
    view()
    assert (ball.data.as_pointer(), ball.matrix_world, ball.name, len(blend.data.objects)) == before
    ball.select_set(True)
    assert ball in blend.context.selected_objects and not ball.hide_select and not ball.hide_render


def test_a_collection_is_one_impostor_and_its_objects_own_marks_win(ball, view, blend, cube_scene):
    group = blend.data.collections.new("Pumps")
    cube_scene.collection.children.link(group)
    cube = blend.data.objects["Cube"]
    for ob in (ball, cube):
        group.objects.link(ob)
    group.cad_shadow_impostor = True
    _, reports = view()
    assert set(reports) == {"Pumps"} and reports["Pumps"].triangles == 2 * 48 * 23 + 12
    cube.cad_shadow_impostor = True
    _, reports = view()
    assert {name: r.triangles for name, r in reports.items()} == {"Pumps": 2 * 48 * 23, "Cube": 12}


def test_a_marked_empty_stands_for_the_assembly_below_it(ball, view, blend):
    blend.ops.object.empty_add()
    empty = blend.context.object
    blend.data.objects["Cube"].parent = empty
    ball.parent = blend.data.objects["Cube"]
    empty.cad_shadow_impostor = True
    _, reports = view()
    assert reports[empty.name].triangles == 2 * 48 * 23 + 12


def test_copies_made_by_an_instancer_are_impostors_of_their_own(ball, view, blend, cube_scene):
    hidden = blend.data.collections.new("Library")
    hidden.objects.link(ball)
    cube_scene.collection.objects.unlink(ball)
    for x in (-1.0, 0.5):
        empty = blend.data.objects.new("Copy", None)
        empty.instance_type, empty.instance_collection, empty.location.x = "COLLECTION", hidden, x
        cube_scene.collection.objects.link(empty)
    ball.cad_shadow_impostor = True
    shown, _ = view(impostor_captures=4)
    assert len(shown.impostors) == 2 and len({r.key for r in shown.impostors}) == 2
    assert {r.name for r in shown.impostors} == {ball.name}
    assert difference(shown, without(view)) < 0.006
    states = importlib.import_module(type(shown).__module__.replace(".api", ".impostor_states")).states
    assert [s.copies for s in states(shown.impostors, "edge_fast_px").values()] == [2]


def test_text_and_curves_are_impostors_too(cube_scene, view, blend):
    blend.ops.object.text_add(location=(1, 0, 1))
    text = blend.context.object
    text.data.extrude = 0.2
    text.cad_shadow_impostor = True
    cube_scene.cad_shadow.impostor_break_even = False
    _, reports = view()
    assert reports[text.name].stage == "regenerated"


def test_it_lives_on_while_the_camera_moves_a_little_and_is_captured_anew_after_a_lot(ball, view, cube_scene):
    ball.cad_shadow_impostor = True
    view()
    stages = []
    for _ in range(3):
        cube_scene.camera.location.x += 0.05
        shown, reports = view()
        stages.append(reports[ball.name].stage)
        assert difference(shown, without(view)) < 0.02
    assert set(stages) <= {"sprite", "warp"} and reports[ball.name].age == 3
    cube_scene.camera.location, cube_scene.camera.rotation_euler = (-6, 6, 5), (1.02, 0, 3.93)
    assert view()[1][ball.name].stage == "regenerated"


@pytest.mark.parametrize("options", ({"impostor_views": 2}, {"impostor_directions": 6, "impostor_views": 2}), ids=("last two", "set"))
def test_several_captures_can_be_kept_and_drawn_together(ball, view, cube_scene, options):
    ball.cad_shadow_impostor = True
    bytes_of = [view(**options)[1][ball.name].bytes]
    for _ in range(2):
        cube_scene.camera.location.x += 0.8
        cube_scene.camera.location.y += 0.8
        bytes_of.append(view(impostor_limit=0.001, **options)[1][ball.name].bytes)
    shown, reports = view(**options)
    assert max(bytes_of) > 1.5 * bytes_of[0] > 0, "more than one capture is kept"
    assert reports[ball.name].stage != "geometry" and difference(shown, without(view)) < 0.02


def test_its_shadow_can_be_cast_by_an_impostor_too(ball, view):
    ball.cad_shadow_impostor = True
    shown, reports = view(impostor_casters="impostor")
    truth = without(view)
    assert reports[ball.name].stage == "regenerated"
    assert difference(shown, truth) < 0.02
    dark = [(p.passes["shadow"] < 0.5) & (p.passes["object"] == truth.passes["object"]) for p in (shown, truth)]
    assert (dark[0] & dark[1]).sum() / (dark[0] | dark[1]).sum() > 0.9


def test_renamed_it_keeps_its_texture(ball, view):
    ball.cad_shadow_impostor = True
    view()
    ball.name = "Separator"
    _, reports = view()
    assert reports["Separator"].stage in ("sprite", "warp") and reports["Separator"].age == 1


def test_deleted_it_is_gone_from_picture_and_list(ball, view, blend):
    ball.cad_shadow_impostor = True
    view()
    blend.data.objects.remove(ball)
    blend.context.view_layer.update()
    shown, reports = view()
    assert not reports and "impostors" not in shown.report
    assert not len(blend.context.window_manager.cad_shadow_impostors)


@pytest.mark.parametrize("change", ("mesh", "place", "modifier"))
@pytest.mark.parametrize(("use", "stage"), (("automatic", "regenerated"), ("manual", "geometry")))
def test_changed_it_is_stale_at_once_and_never_shown_as_it_was(ball, view, change, use, stage):
    ball.cad_shadow_impostor = True
    view(impostor_use=use)
    if change == "mesh":
        for vertex in ball.data.vertices:
            vertex.co *= 0.6
        ball.data.update()
    elif change == "place":
        ball.location.x -= 1.0
    else:
        ball.modifiers.new("Thin", "DECIMATE").ratio = 0.5
    shown, reports = view(impostor_use=use)
    assert reports[ball.name].stage == stage and "changed" in reports[ball.name].reason
    assert difference(shown, without(view)) < 0.004


@pytest.mark.parametrize(("place", "size"), (((60, -60, 48), 1.0), ((6, -6, 5), 4.0)), ids=("behind", "around"))
def test_behind_or_around_the_camera_it_is_geometry(ball, view, place, size):
    ball.location, ball.scale = place, (size,) * 3
    ball.cad_shadow_impostor = True
    shown, reports = view()
    assert reports[ball.name].stage in ("geometry", "hidden")
    assert np.array_equal(shown.combined, without(view).combined)


def test_cut_open_by_the_near_distance_it_is_geometry(ball, view, cube_scene):
    ball.cad_shadow_impostor = True
    distance = float(-(cube_scene.camera.matrix_world.inverted() @ ball.location).z)
    shown, reports = view(near=distance)
    assert reports[ball.name].stage == "geometry" and "near distance" in reports[ball.name].reason
    assert np.array_equal(shown.combined, without(view, near=distance).combined)
    assert view(near=distance - 1.05)[1][ball.name].stage == "regenerated", "only just before it"


def test_a_flat_object_is_captured_as_flat(cube_scene, view, blend):
    plane = blend.data.objects["Plane"]
    plane.cad_shadow_impostor = True
    cube_scene.cad_shadow.impostor_break_even = False
    blend.data.objects["Cube"].location.z = 1.001
    shown, reports = view()
    assert reports["Plane"].stage in ("regenerated", "geometry")
    assert difference(shown, without(view)) < 0.02


def test_what_has_no_surface_is_left_out_and_refused(cube_scene, view, blend):
    point = blend.data.objects.new("Point", blend.data.meshes.new("Point"))
    point.data.from_pydata([(0, 0, 3)], [], [])
    cube_scene.collection.objects.link(point)
    point.cad_shadow_impostor = True
    shown, reports = view()
    assert not reports
    assert np.array_equal(shown.combined, without(view).combined)
    point.cad_shadow_impostor = False
    select(blend, point)
    assert not blend.ops.cad_shadow.impostor_create.poll()


def test_vertices_that_are_not_finite_spoil_nothing(ball, view):
    ball.data.vertices[100].co = (float("nan"),) * 3
    ball.data.vertices[7].co.x = float("inf")
    ball.cad_shadow_impostor = True
    shown, reports = view()
    assert reports[ball.name].stage == "regenerated" and np.isfinite(reports[ball.name].edges.edges).all()
    assert np.isfinite(shown.combined).all() and difference(shown, without(view)) < 0.01


def test_its_texture_never_exceeds_the_largest_one_allowed(ball, view, cube_scene):
    ball.cad_shadow_impostor = True
    ball.location = (3.5, -3.5, 3.2)
    _, reports = view(impostor_max_texels=32, impostor_texels=8)
    assert max(reports[ball.name].size) <= 32


def test_small_objects_are_geometry_unless_asked_otherwise(cube_scene, view, blend):
    blend.data.objects["Cube"].cad_shadow_impostor = True
    shown, reports = view(impostor_fresh=True)
    assert reports["Cube"].stage == "geometry" and "cheaper" in reports["Cube"].reason
    assert np.array_equal(shown.combined, without(view).combined)


def test_renders_depend_on_no_picture_before_them(ball, view, cube_scene):
    ball.cad_shadow_impostor = True
    first = view(impostor_fresh=True)[0]
    cube_scene.camera.location.x += 0.3
    view(impostor_fresh=True)
    view(impostor_fresh=False)
    cube_scene.camera.location.x -= 0.3
    again = view(impostor_fresh=True)[0]
    assert np.array_equal(first.combined, again.combined)


def test_f12_the_api_and_the_preview_operator_draw_the_same(ball, view, blend, cube_scene, room):
    ball.cad_shadow_impostor = True
    cube_scene.cad_shadow.samples, cube_scene.cad_shadow.map_size = "1", 128
    console = view(impostor_fresh=True)[0].combined
    blend.ops.render.render()
    f12 = room("session").last().frame
    assert f12.impostors and np.array_equal(console, f12.passes["combined"])
    room("session").forget()
    assert blend.ops.cad_shadow.preview() == {"FINISHED"}
    assert np.array_equal(console, room("session").last().frame.passes["combined"])


def test_the_live_view_asks_again_while_impostors_wait_but_not_for_ever(room):
    viewport = room("viewport")
    live = viewport.LiveView()
    try:
        frame = SimpleNamespace(impostors=(SimpleNamespace(waits=True), SimpleNamespace(waits=False)))
        asked = []
        for wish in (viewport.Wish(("a",), 2), *[viewport.Wish(("a",), 1)] * 4, viewport.Wish(("b",), 1)):
            live._count_repeats(wish, frame)
            live._shown = wish
            asked.append(live._wants_more)
        assert asked == [False, True, True, False, False, True]
        live._count_repeats(viewport.Wish(("c",), 1), SimpleNamespace(impostors=(SimpleNamespace(waits=False),)))
        assert not live.needs_redraw
    finally:
        live.close()


def test_those_that_wait_get_their_turn_one_by_one(ball, view, blend):
    blend.data.objects["Cube"].cad_shadow_impostor = ball.cad_shadow_impostor = True
    waiting = [sum(r.waits for r in view()[0].impostors) for _ in range(3)]
    assert waiting == [1, 0, 0]


def select(blend, *objects):
    for ob in blend.context.view_layer.objects:
        ob.select_set(ob in objects)
    blend.context.view_layer.objects.active = objects[0] if objects else None


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


def small(scene):
    scene.cad_shadow.samples, scene.cad_shadow.map_size = "1", 128


def test_regenerate_captures_those_it_is_told_to(ball, blend, cube_scene, room):
    small(cube_scene)
    cube = blend.data.objects["Cube"]
    ball.cad_shadow_impostor = cube.cad_shadow_impostor = True
    cube_scene.cad_shadow.impostor_use = "manual"
    ops, session = blend.ops.cad_shadow, room("session")

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
    ops, session, predictors = blend.ops.cad_shadow, room("session"), room("maths.relief_error").PREDICTORS
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
    points, quads = room("impostor_overlay").shapes(session.impostors(), session.impostor_origin())
    away = np.linalg.norm(points - np.array(ball.location), axis=1)
    assert len(points) and (away < 1.05).all() and len(quads) == 1
    pixels = np.array(image.pixels[:]).reshape(image.size[1], image.size[0], 4)[::-1]
    uv = room("impostor_states").critical_places(report.edges)[0].astype(int)
    assert np.allclose(pixels[uv[:, 1], uv[:, 0], :3], room("impostor_states").CROSS, atol=0.02)


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
    ranked = [room_of.error_of(r, "edge_fast_px") for r in room_of.by_error(room("session").impostors(), "edge_fast_px")]
    assert len(ranked) == 2 and ranked == sorted(ranked, reverse=True)


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
    camera = room("impostor_plane").capture_camera(captured.baked, captured.metadata)
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


def rendered(blend, scene):
    """A render's combined image (h, w, 4), row 0 at the top."""
    import tempfile
    from pathlib import Path

    with tempfile.TemporaryDirectory() as folder:
        image_settings = scene.render.image_settings
        if hasattr(image_settings, "media_type"):
            image_settings.media_type = "IMAGE"
        image_settings.file_format, image_settings.color_mode, image_settings.color_depth = "OPEN_EXR", "RGBA", "32"
        scene.render.filepath = str(Path(folder, "x.exr"))
        blend.ops.render.render(write_still=True)
        image = blend.data.images.load(scene.render.filepath)
        out = np.array(image.pixels[:], np.float32).reshape(image.size[1], image.size[0], 4)[::-1]
        blend.data.images.remove(image)
    return out


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
