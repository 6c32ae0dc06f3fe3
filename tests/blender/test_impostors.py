"""Impostors in Blender: what is marked is drawn from its texture, keeps its identity, and is never shown where it would be wrong."""

import importlib
from types import SimpleNamespace

import numpy as np
import pytest

from tests.blender.impostor_rig import difference, select, without


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
    states = importlib.import_module(type(shown).__module__.replace(".api", ".studies.impostors.states")).states
    assert [s.copies for s in states(shown.impostors).values()] == [2]


def test_text_and_curves_are_impostors_too(cube_scene, view, blend):
    blend.ops.object.text_add(location=(1, 0, 1))
    text = blend.context.object
    text.data.extrude, text.data.size = 0.2, 3.0
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
    f12 = room("blender.session").last().frame
    assert f12.impostors and np.array_equal(console, f12.passes["combined"])
    room("blender.session").clear()
    assert blend.ops.cad_shadow.preview() == {"FINISHED"}
    assert np.array_equal(console, room("blender.session").last().frame.passes["combined"])


def test_the_live_view_asks_again_while_impostors_wait_but_not_for_ever(room):
    viewport = room("blender.viewport")
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
