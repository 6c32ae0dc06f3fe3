"""The error the picture shows against the error the texts predict, on cards that have no error of their own.

The cards stand close round the view axis, from near to far, and face the mid direction of light and eye, so that the error of the surface's
slope is gone and m_x, m_z of the `aliasing` pass are T4's perspective errors. The fit is the whole view frustum, one map: the theory's P.
"""

from dataclasses import replace

import numpy as np
import pytest

from addon.maths.choices import WARPS, FitChoice, PartitionChoice, WarpChoice
from addon.maths.error.aliasing import beam_error_z, error_x
from addon.maths.error.warped_map import WarpedMap
from addon.maths.shadow.fit import plan_shadows
from addon.maths.shadow.light_space import round_core
from addon.maths.shadow.strength import Range, method_strength, steady_strength
from addon.maths.shadow.warps import warp_parameter
from addon.maths.view import Light
from addon.maths.warping.formulas import gamma_lim_rad
from addon.pipeline.job import Job
from addon.settings.groups import Settings
from addon.studies.run import run
from tests import scenes

NEAR, FAR = 1.0, 50.0
SIZE, MAP = (320, 180), 512
CAMERA = scenes.look_at((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), fov_y_deg=60.0, near=NEAR, far=FAR)
PHI = CAMERA.half_fov_rad
GAMMA_LIM = gamma_lim_rad(NEAR, FAR, PHI)
GAMMAS = tuple(np.linspace(GAMMA_LIM, np.pi / 2.0, 5))
DISTANCES = np.geomspace(1.02 * NEAR, 0.98 * FAR, 8)
MARGIN = 1.0 / (1.0 - 2.0 * Settings().fit.margin_texels / MAP)  # texels kept free at the border are as many fewer for the view
WITHIN = 0.02


def sun_at(gamma, up=1.0, right=0.0):
    """A sun behind the eye at angle γ to the view, in the plane of the view and the picture's `up`, `right`."""
    return Light("sun", np.array([right * np.sin(gamma), -np.cos(gamma), up * np.sin(gamma)]))


def measured_on(renderer, light, warp):
    """(view depth, m_x, m_z) of every card's pixels, one row per card, medians; and the map."""
    scene = scenes.calibration_cards(CAMERA, light.direction_ws, DISTANCES, size_px=0.006, spread=0.1)
    kind = warp if isinstance(warp, dict) else {"kind": warp}
    settings = Settings().replaced(warp=kind, partition={"kind": "none"}, fit={"kind": "frustum", "size": MAP})
    frame = run(Job(scene, CAMERA, light, settings, SIZE, ("depth", "aliasing", "object")), on=renderer).frame
    cards = [frame.passes["object"] == i for i in range(len(DISTANCES))]
    assert all(card.any() for card in cards), "a card is hidden or falls between the pixels"
    rows = [[np.median(frame.passes["depth"][card]), *np.median(frame.passes["aliasing"][card][:, 1:], axis=0)] for card in cards]
    return np.array(rows, np.float64).T, frame.plan.projections[0]


def map_of(warp, gamma, parameter, half_angle=PHI):
    return WarpedMap(NEAR, FAR, half_angle, gamma, parameter, warp in ("log", "logpsm"), warp != "log")


@pytest.mark.parametrize("gamma", GAMMAS, ids=lambda g: f"{np.degrees(g):.0f}°")
@pytest.mark.parametrize("warp", WARPS)
def test_measured_errors_are_the_theorys_within_two_percent(renderer, warp, gamma):
    """(25), (26), (37)·sin γ and LogPSM 5.41 with the resolution terms, at the n' the fit has."""
    (z, m_x, m_z), projection = measured_on(renderer, sun_at(gamma), warp)
    m = map_of(warp, gamma, projection.warp_parameter)
    expected_x, expected_z = (MARGIN * e for e in (error_x(m, z, SIZE[0] / MAP), beam_error_z(m, z, SIZE[1] / MAP)))
    assert np.abs(m_x * m_z / (expected_x * expected_z) - 1.0).max() < WITHIN
    # where m_x = m_z a texel's footprint is round, and rounding says which singular value is which
    distinct = np.abs(expected_x / expected_z - 1.0) > 0.1
    assert distinct.sum() >= 4
    assert np.abs(m_x / expected_x - 1.0)[distinct].max() < WITHIN
    assert np.abs(m_z / expected_z - 1.0)[distinct].max() < WITHIN


@pytest.mark.parametrize("gamma", GAMMAS, ids=lambda g: f"{np.degrees(g):.0f}°")
@pytest.mark.parametrize("warp", WARPS)
def test_the_fits_warp_is_the_methods_but_for_the_limit_on_its_growth(warp, gamma):
    """n' is the text's, or, close above γ_lim, that of `steady_strength` (at most 16 % of f'/n' per degree; docs/laboratory.md)."""
    choice, view = WarpChoice(warp), Range(NEAR, FAR, PHI, PHI)
    plan = plan_shadows(
        CAMERA,
        sun_at(gamma),
        choice,
        PartitionChoice("none"),
        FitChoice("frustum"),
        receivers_ws=None,
        scene_bounds_ws=np.zeros((2, 3)),
        caster_bounds_ws=np.zeros((0, 2, 3)),
        image_size=SIZE,
    )
    parameter = plan.projections[0].warp_parameter
    expected = warp_parameter(choice, NEAR, FAR, PHI, gamma)
    if expected == np.inf:
        assert parameter == np.inf
        return
    own, steady = method_strength(choice, view, gamma), steady_strength(choice, view, gamma, round_core(GAMMA_LIM))
    assert steady == own or gamma < np.radians(50.0)
    if steady == own:
        assert parameter == pytest.approx(expected, rel=1e-6)
    else:
        assert parameter > expected


@pytest.mark.parametrize("gamma_deg", [50.0, 70.0, 90.0])
def test_the_error_of_logpsm_along_the_view_is_flat(renderer, gamma_deg):
    (_, _, m_z), _ = measured_on(renderer, sun_at(np.radians(gamma_deg)), "logpsm")
    assert np.abs(m_z / np.median(m_z) - 1.0).max() < WITHIN


@pytest.mark.parametrize("bend", [-0.8, 1.0, 20.0, 1000.0])
@pytest.mark.parametrize("gamma_deg", [35.0, 50.0, 90.0])
def test_the_bent_log_maps_are_the_theorys_too(renderer, bend, gamma_deg):
    """LogPSM 5.50 with general b, below γ = 90° as `faded_bend` has it; b = 1/1000 is far beyond the perspective map's 1/49."""
    gamma = np.radians(gamma_deg)
    (z, m_x, m_z), projection = measured_on(renderer, sun_at(gamma), {"kind": "logpsm", "log_bend": bend})
    m = replace(map_of("logpsm", gamma, projection.warp_parameter), bend=projection.log.bend)
    assert m.bend == pytest.approx(bend, rel=0.02) or gamma_deg < 90.0
    expected = MARGIN**2 * error_x(m, z, SIZE[0] / MAP) * beam_error_z(m, z, SIZE[1] / MAP)
    assert np.abs(m_x * m_z / expected - 1.0).max() < WITHIN


@pytest.mark.parametrize("warp", ["uniform", "psm", "lispsm-general", "logpsm"])
def test_a_light_from_the_side_sees_the_pictures_width(renderer, warp):
    """In the plane of light and view the half angle is that of the width: m_z follows it, and m_x the height."""
    gamma, wide = np.radians(90.0), np.arctan(np.tan(PHI) * 16.0 / 9.0)
    (z, m_x, m_z), projection = measured_on(renderer, sun_at(gamma, up=0.0, right=1.0), warp)
    m = map_of(warp, gamma, projection.warp_parameter, wide)
    expected_x, expected_z = (MARGIN * e for e in (error_x(m, z, SIZE[1] / MAP), beam_error_z(m, z, SIZE[0] / MAP)))
    assert np.abs(m_x * m_z / (expected_x * expected_z) - 1.0).max() < WITHIN
