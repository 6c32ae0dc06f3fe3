"""Impostors through the renderer: along paths, under changes of the scene, and in the pictures they stand in."""

from dataclasses import replace

import numpy as np
import pytest

from addon.maths.relief.frame import tilt_rad
from addon.maths.relief.life import LifeModel
from addon.maths.relief.settings import CASTERS, ImpostorSettings
from addon.maths.shadow import cut
from addon.maths.view import Light
from addon.pipeline.device import device_of
from addon.pipeline.impostors import ahead as impostor_ahead
from addon.pipeline.impostors import costs
from addon.pipeline.impostors.costs import START_PIXEL_NS
from addon.pipeline.impostors.life import library_of
from addon.pipeline.impostors.records import ImpostorChoice, ImpostorGroup
from addon.pipeline.impostors.shadows import casters_of
from addon.pipeline.job import Job
from addon.settings.groups import Settings
from addon.studies.run import run
from tests import scenes
from tests.pipeline.test_impostor_draw import PARTS, SIZE, orbit

SUN = scenes.sun(50.0)
FLOOR = scenes.floor(3.0)
SCENE = scenes.scene_of(*PARTS, FLOOR)
ALL = ImpostorChoice((ImpostorGroup("parts", (0, 1, 2), "Parts"),), ImpostorSettings(break_even=False))
CHEAP = Settings().replaced(test={"kind": "depth"}, fit={"kind": "scene", "size": 256}, partition={"kind": "none"})


def but(**settings) -> ImpostorChoice:
    """`ALL` with other settings."""
    return replace(ALL, settings=replace(ALL.settings, **settings))


@pytest.fixture
def film(renderer):
    """Renders frames with impostors; the library is emptied before and after."""

    def empty():
        renderer.worker.call(lambda context: library_of(device_of(context, renderer.worker)).release())

    def shot(camera, choice=ALL, scene=SCENE, passes=("combined", "object", "depth"), light=SUN):
        return run(Job(scene, camera, light, CHEAP, SIZE, passes, measure=False, impostors=choice), on=renderer).frame

    empty()
    shot.empty = empty
    yield shot
    empty()


def psnr(a, b):
    return -10.0 * np.log10(max(np.mean((a[..., :3] - b[..., :3]) ** 2), 1e-12))


def test_a_slow_orbit_is_captured_warped_and_renewed_and_always_close_to_the_geometry(film, renderer):
    stages, quality = [], []
    for angle in np.arange(0.0, 1.3, 0.1):
        frame = film(orbit(angle))
        stages.append(frame.impostors[0].stage)
        quality.append(psnr(frame.passes["combined"], film(orbit(angle), choice=None).passes["combined"]))
        assert frame.geometry["triangles_saved"] == sum(len(m.triangles) for m in SCENE.meshes[:3])
    assert stages[0] == "regenerated"
    assert stages[1] in ("sprite", "warp")
    assert 1 <= stages[1:].count("regenerated") <= 8
    assert "geometry" not in stages
    assert min(quality) > 22.0
    assert np.median(quality) > 26.0


def test_an_eye_that_moves_on_is_met_ahead_so_that_fewer_captures_hold_the_same_limit(film):
    captures = {}
    for ahead in (0.0, ImpostorSettings().ahead):
        film.empty()
        shown = [film(orbit(angle), but(ahead=ahead)).impostors[0] for angle in np.arange(0.0, 1.0, 0.02)]
        captures[ahead] = sum(r.captures for r in shown)
        assert {r.stage for r in shown} <= {"regenerated", "sprite", "warp"}
    here, ahead = captures.values()
    assert ahead <= 0.8 * here, captures


def test_an_orthographic_capture_lives_as_well_as_a_perspective_one(film):
    """From near by, where its rays differ most from the eye's."""
    captures = {}
    for perspective in (True, False):
        film.empty()
        choice = but(projection="perspective" if perspective else "orthographic")
        shown = [film(orbit(angle, distance=2.5), choice).impostors[0] for angle in np.arange(0.0, 0.4, 0.02)]
        captures[perspective] = sum(r.captures for r in shown)
        assert {r.stage for r in shown} <= {"regenerated", "sprite", "warp"}
    assert captures[False] <= captures[True] + 2, captures


def test_a_second_capture_is_not_drawn_with_one_that_is_within_the_limit(film):
    pictures = []
    for views in (1, 2):
        film.empty()
        pictures.append([film(orbit(angle), but(views=views)).passes["combined"] for angle in np.arange(0.0, 0.5, 0.1)])
    np.testing.assert_array_equal(*pictures)


def test_captures_take_the_memory_that_they_are_said_to(film, renderer):
    report = film(orbit(0.3)).impostors[0]
    textures = renderer.worker.call(lambda c: library_of(device_of(c, renderer.worker)).textures("parts"))
    held = list(vars(textures.texels).values())
    held_bytes = sum(t.width * t.height * t.components * {"f4": 4, "f2": 2, "u4": 4}[t.dtype] for t in held)
    assert held_bytes == 32 * report.size[0] * report.size[1] < report.bytes


def test_the_error_reported_is_of_what_is_shown_and_within_the_limit(film):
    for angle in np.arange(0.0, 1.0, 0.02):
        report = film(orbit(angle)).impostors[0]
        assert 0.0 < report.error <= report.limit == ImpostorSettings().effective_limit
        if angle == 0.0:
            assert report.error == pytest.approx(LifeModel().resampling * report.edges.contour_share)


def test_predictions_are_of_the_edges_there_are_and_not_of_those_there_were(film, renderer):
    """As when a new texture comes to lie where an old one lay in memory."""
    film(orbit(0.0))
    before = film(orbit(0.1)).impostors[0].errors["edge_fast_px"]

    def other_edges(context):
        textures = library_of(device_of(context, renderer.worker)).textures("parts")
        textures.edges = replace(textures.edges, sums=2.0 * textures.edges.sums, totals=textures.edges.totals * [2.0, 1.0, 1.0, 1.0])

    renderer.worker.call(other_edges)
    assert film(orbit(0.1)).impostors[0].errors["edge_fast_px"] == pytest.approx(2.0 * before)


def test_a_picture_from_ahead_is_warped_to_the_eye_and_close_to_the_geometry(film, renderer):
    turned = []
    for angle in np.arange(0.0, 1.0, 0.02):
        frame = film(orbit(angle))
        if frame.impostors[0].stage == "regenerated" and angle > 0.0:
            textures = renderer.worker.call(lambda c: library_of(device_of(c, renderer.worker)).textures("parts"))
            turned.append(tilt_rad(textures.frame, orbit(angle)))
            assert psnr(frame.passes["combined"], film(orbit(angle), choice=None).passes["combined"]) > 24.0
    assert max(turned) > 0.02


def test_a_capture_from_ahead_that_would_be_wrong_here_is_made_from_here(film, renderer, monkeypatch):
    """No texture holds from a radian ahead."""
    monkeypatch.setattr(impostor_ahead, "ahead_of", lambda current, before, camera, centre, share: camera.carried(centre, 1.0))
    for angle in np.arange(0.0, 0.6, 0.02):
        if film(orbit(angle)).impostors[0].stage == "regenerated":
            textures = renderer.worker.call(lambda c: library_of(device_of(c, renderer.worker)).textures("parts"))
            assert tilt_rad(textures.frame, orbit(angle)) == pytest.approx(0.0, abs=1e-6)


def test_the_floor_before_and_behind_impostors_and_their_shadows_stay(film):
    camera = orbit(0.3)
    frame, truth = film(camera), film(camera, choice=None)
    assert np.mean(frame.passes["object"] == truth.passes["object"]) > 0.985
    same = frame.passes["object"] == truth.passes["object"]
    assert np.mean(np.abs(frame.passes["combined"] - truth.passes["combined"])[same].max(axis=-1) < 0.02) > 0.98


def test_a_still_camera_shows_a_sprite_and_captures_once(film):
    reports = [film(orbit(0.3)).impostors[0] for _ in range(4)]
    assert [r.stage for r in reports] == ["regenerated", "sprite", "sprite", "sprite"]
    assert [r.age for r in reports] == [0, 1, 2, 3]
    assert reports[-1].betas.total <= reports[-1].betas.screen
    assert reports[-1].errors["edge_fast_px"] == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("change", ["moved", "mesh"])
def test_a_changed_object_is_captured_anew_at_once_and_another_objects_change_is_not(film, change):
    matrices = [np.eye(4) for _ in range(4)]
    film(orbit(0.3))
    other = [m.copy() for m in matrices]
    other[3][2, 3] = -0.1
    assert film(orbit(0.3), scene=scenes.scene_of(*PARTS, FLOOR, matrices=other)).impostors[0].stage == "sprite"
    if change == "moved":
        matrices[1][0, 3] = 0.2
        changed = scenes.scene_of(*PARTS, FLOOR, matrices=matrices)
    else:
        changed = scenes.scene_of(scenes.box((-0.6, -0.5, 0.0), (0.1, 0.3, 0.6)), *PARTS[1:], FLOOR)
    frame = film(orbit(0.3), scene=changed)
    assert frame.impostors[0].stage == "regenerated"
    truth = film(orbit(0.3), scene=changed, choice=None)
    assert np.mean(frame.passes["object"] == truth.passes["object"]) > 0.985


def test_without_room_for_a_capture_or_from_among_the_objects_the_geometry_is_drawn(film):
    tight = but(memory_mib=1, texels_per_pixel=8.0, max_texels=8192)
    frame, truth = film(orbit(0.3), tight), film(orbit(0.3), choice=None)
    assert frame.impostors[0].stage == "geometry"
    assert frame.impostors[0].bytes == 0
    np.testing.assert_array_equal(frame.passes["combined"], truth.passes["combined"])
    inside = scenes.look_at((0.25, 0.0, 0.55), (0.3, -0.3, 0.6), near=0.01, far=30.0)
    assert film(inside).impostors[0].stage == "geometry"


def test_cheap_geometry_is_never_replaced(film):
    thrifty = replace(but(break_even=True), triangle_ns=60.0, pixel_ns=150.0)
    assert film(orbit(0.3), thrifty).impostors[0].reason == "the geometry is cheaper"
    assert film(orbit(0.3), replace(thrifty, triangle_ns=1e6)).impostors[0].stage == "regenerated"


@pytest.mark.parametrize(("pixel_ns", "stage"), [(1e9, "geometry"), (1e-6, "regenerated")])
def test_what_the_triangles_cost_is_measured_when_nobody_says_it(film, monkeypatch, pixel_ns, stage):
    """Whatever was measured, it lies between a second and a femtosecond a pixel; captures are had for nothing here."""
    monkeypatch.setattr(costs, "START_TEXEL_NS", 0.0)
    monkeypatch.setattr(costs, "CAPTURE_PASSES", 0.0)
    report = film(orbit(0.3), replace(but(break_even=True), pixel_ns=pixel_ns)).impostors[0]
    assert report.stage == stage


def test_what_an_impostors_pixel_costs_is_measured_at_its_capture(film, renderer):
    film(orbit(0.3), replace(but(break_even=True), triangle_ns=1e9))
    cost = renderer.worker.call(lambda context: library_of(device_of(context, renderer.worker)).pixel_ns)
    assert 0.0 < cost < 1e9
    assert cost != START_PIXEL_NS


def test_an_object_thinner_than_its_texels_is_geometry_until_it_is_seen_larger(film):
    """A fence of rods less than a pixel wide from afar."""
    rods = [scenes.rod((x, 0.0, 0.0), (x, 0.0, 1.0), 0.03) for x in np.linspace(-0.5, 0.5, 6)]
    fence = replace(ALL, groups=(ImpostorGroup("fence", tuple(range(6))),))
    scene = scenes.scene_of(*rods)
    stages = [film(orbit(0.02 * i, distance=12.0), fence, scene).impostors[0] for i in range(4)]
    assert [r.stage for r in stages] == ["geometry"] * 4
    assert stages[2].reason == "finer than its texels"
    assert stages[2].bytes == 0
    assert film(orbit(0.06, distance=2.0), fence, scene).impostors[0].stage == "regenerated"


def test_a_deleted_object_a_hidden_one_and_one_out_of_view_draw_nothing_and_do_not_fail(film):
    gone = replace(ALL, groups=(ImpostorGroup("gone", (77,)), *ALL.groups))
    frame = film(orbit(0.3), gone)
    assert [r.stage for r in frame.impostors] == ["hidden", "regenerated"]
    away = film(scenes.look_at((0, -5, 0.5), (0, -9, 0.5), near=0.1, far=30.0), gone)
    assert [r.stage for r in away.impostors] == ["hidden", "hidden"]


def test_manual_impostors_are_renewed_only_when_asked_and_never_shown_wrong(film):
    manual = but(use="manual")
    assert film(orbit(0.0), manual).impostors[0].stage == "regenerated"
    assert film(orbit(0.5), manual).impostors[0].stage == "warp"
    assert film(orbit(1.4), manual).impostors[0].stage == "geometry"
    assert film(orbit(1.4), replace(manual, regenerate=frozenset({"parts"}))).impostors[0].stage == "regenerated"


def test_impostors_nobody_asks_for_any_more_give_their_memory_back(film, renderer):
    film(orbit(0.3))

    def held(context):
        return library_of(device_of(context, renderer.worker)).textures("parts")

    assert renderer.worker.call(held) is not None
    film(orbit(0.3), replace(ALL, groups=()))
    assert renderer.worker.call(held) is None


@pytest.mark.parametrize("method", ["inverse", "forward"])
def test_both_warps_can_be_chosen(film, method):
    choice = but(warp=method)
    film(orbit(0.3), choice)
    frame, truth = film(orbit(0.4), choice), film(orbit(0.4), choice=None)
    assert frame.impostors[0].stage == "warp"
    assert psnr(frame.passes["combined"], truth.passes["combined"]) > 20.0


def test_orthographic_cameras_have_impostors_too(film):
    film(orbit(0.3, ortho_height=2.2))
    frame, truth = film(orbit(0.4, ortho_height=2.2)), film(orbit(0.4, ortho_height=2.2), choice=None)
    assert frame.impostors[0].stage == "warp"
    assert np.mean(frame.passes["object"] == truth.passes["object"]) > 0.97


def test_a_set_of_directions_is_captured_on_the_first_round_and_serves_the_second(film):
    """Two of 8 × 8 directions at a time: the second time round nothing is captured, and the pictures hold."""
    choice = but(directions=8, views=2, regenerations=2)
    angles = np.arange(0.0, 2.0 * np.pi, 0.7)
    first = [film(orbit(angle), choice).impostors[0] for angle in np.repeat(angles, 2)]
    assert sum(r.stage == "regenerated" for r in first) >= 6
    assert first[-1].bytes > first[0].bytes
    for angle in angles:
        frame = film(orbit(angle), choice)
        assert frame.impostors[0].stage in ("warp", "sprite")
        assert frame.impostors[0].bytes == first[-1].bytes
        assert psnr(frame.passes["combined"], film(orbit(angle), choice=None).passes["combined"]) > 22.0


def test_a_set_of_directions_keeps_within_its_memory(film):
    whole = film(orbit(0.0), but(directions=8)).impostors[0].bytes
    tight = but(directions=8, memory_mib=int(2.5 * whole) >> 20)
    for angle in np.arange(0.0, 2.0 * np.pi, 0.7):
        report = film(orbit(angle), tight).impostors[0]
        assert 0 < report.bytes <= 2.5 * whole


def test_the_capture_before_is_drawn_beside_the_last_one_where_two_are_wanted(film):
    """Back to where the first was captured, after a second was asked for elsewhere: what only the first saw is there again."""
    missing = {}
    for views in (1, 2):
        choice = but(use="manual", views=views)
        film(orbit(0.0), choice)
        film(orbit(0.6, height=0.1), replace(choice, regenerate=frozenset({"parts"})))
        there, truth = (film(orbit(0.05), c).passes["object"] for c in (choice, None))
        seen = (truth >= 0) & (truth < 3)
        missing[views] = (there != truth)[seen].mean()
        film(orbit(0.0), replace(choice, groups=()))
    assert missing[2] < 0.8 * missing[1]


LAMPS = {
    "sun": SUN,
    "spot": Light("spot", np.array([0.0, -0.6, 0.8]), np.array([0.0, -2.4, 3.7]), 0.8),
}


@pytest.mark.parametrize("lamp", LAMPS)
def test_impostors_cast_the_shadows_of_their_geometry(film, lamp):
    """From textures captured from the light, the floor's shadow is that of the triangles but for its edges, while the camera moves."""
    light = LAMPS[lamp]
    choices = {casters: but(casters=casters) for casters in CASTERS}
    for angle in (0.3, 0.5):
        shadows = {k: film(orbit(angle), c, passes=("shadow", "object"), light=light).passes for k, c in choices.items()}
        floor = shadows["geometry"]["object"] == 3
        there, truth = (shadows[k]["shadow"][floor] for k in ("impostor", "geometry"))
        assert 0.03 < np.mean(truth < 0.5) < 0.9
        assert np.mean(np.abs(there - truth) > 0.5) < 0.02


def test_shadows_of_impostors_follow_the_light_and_the_object(film, renderer):
    """The texture from the light is kept while nothing changes, and captured anew when the light or the object moves."""
    choice = but(casters="impostor")

    def kept(context):
        held = casters_of(device_of(context, renderer.worker))._kept
        return id(held["parts"][1]) if "parts" in held else None

    def after(camera, **how):
        film(camera, choice, **how)
        return renderer.worker.call(kept)

    first = after(orbit(0.3))
    assert first == after(orbit(0.4))
    low = after(orbit(0.4), light=scenes.sun(30.0))
    assert low not in (None, first)
    matrices = [np.eye(4) for _ in range(4)]
    matrices[1][0, 3] = 0.2
    moved = after(orbit(0.4), light=scenes.sun(30.0), scene=scenes.scene_of(*PARTS, FLOOR, matrices=matrices))
    assert moved not in (None, low)
    film(orbit(0.4), replace(but(casters="impostor"), groups=()))
    assert renderer.worker.call(kept) is None


def test_shadow_tests_that_need_ids_get_triangles_as_casters(film, renderer):
    by_id = CHEAP.replaced(test={"kind": "id-depth"})
    frames = [
        run(Job(SCENE, orbit(0.3), SUN, by_id, SIZE, ("shadow",), measure=False, impostors=but(casters=casters)), on=renderer).frame
        for casters in CASTERS
    ]
    np.testing.assert_array_equal(frames[1].passes["shadow"], frames[0].passes["shadow"])


def test_an_impostor_far_larger_than_a_map_casts_as_geometry(film, monkeypatch):
    """Its blocks would reach farther beyond the map than float32 can draw; with no room beyond, that is every impostor."""
    monkeypatch.setattr(cut, "LARGE", 1e-3)
    frames = [film(orbit(0.3), but(casters=casters), passes=("shadow",)) for casters in CASTERS]
    np.testing.assert_array_equal(frames[1].passes["shadow"], frames[0].passes["shadow"])
