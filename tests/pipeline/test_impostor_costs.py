"""The break-even of impostors counts what a picture really takes: camera samples, captures, and how long these serve. No GL."""

from types import SimpleNamespace

import numpy as np
import pytest

from addon.maths.relief.settings import ImpostorSettings
from addon.pipeline.impostors import costs
from addon.pipeline.impostors.costs import Costs
from addon.pipeline.impostors.records import ImpostorChoice

PIXELS, TEXELS = 50_000.0, 200_000.0


def view(samples=1, fresh=False, triangle_ns=None, pixel_ns=None, break_even=True):
    choice = ImpostorChoice((), ImpostorSettings(break_even=break_even), triangle_ns=triangle_ns, pixel_ns=pixel_ns, alone=fresh)
    return SimpleNamespace(samples=samples, choice=choice)


def part(triangles=100_000):
    return SimpleNamespace(triangles=triangles, group=SimpleNamespace(key="a"))


def known(geometry_ns=1e7, capture_ns=None, lives=()):
    found = Costs()
    found.geometry(part(), geometry_ns)
    for age in lives or ((0,) if capture_ns else ()):
        found.captured("a", capture_ns or 1e8, age)
    return found


def test_camera_samples_multiply_an_impostors_pixels_and_neither_the_triangles_nor_the_capture():
    one, four, many = (known(capture_ns=8e7).of(part(), view(samples), PIXELS, TEXELS, 0) for samples in (1, 4, 16))
    assert four[0] == many[0] == 2.0 * one[0]
    capture = 8e7 / costs.START_LIFE
    assert many[1] - capture > 3.5 * (four[1] - capture) > 10.0 * (one[1] - capture)


def test_a_capture_weighs_by_the_pictures_that_it_serves():
    short, long = (known(1e7, 1e8, (age,)).of(part(), view(), PIXELS, TEXELS, 0)[1] for age in (1, 100))
    assert short - long == pytest.approx(1e8 * (1.0 - 1.0 / 100.0))
    assert known(1e7, 1e8, (1,)).of(part(), view(), PIXELS, TEXELS, 50)[1] == pytest.approx(long + 1e8 * (1 / 50 - 1 / 100))


def test_a_fresh_picture_pays_its_captures_alone_and_forgets_what_was_measured():
    """So that it is the same on every machine."""
    fixed = view(4, True, 60.0, 150.0)
    new, old = (found.of(part(), fixed, PIXELS, TEXELS, age) for found, age in ((Costs(), 0), (known(1e3, 1.0, (1000,)), 1000)))
    assert new == old
    geometry, impostor = new
    assert geometry == 2 * 60.0 * 100_000
    assert impostor > costs.CAPTURE_PASSES * 60.0 * 100_000 + costs.START_TEXEL_NS * TEXELS


@pytest.mark.parametrize("samples", [1, 4, 16])
def test_a_fresh_picture_has_no_impostor_as_a_capture_draws_the_triangles_more_often_than_it_does(samples):
    for triangles in (10_000, 1_000_000, 100_000_000):
        geometry, impostor = Costs().of(part(triangles), view(samples, True, 60.0, 150.0), PIXELS, TEXELS, 0)
        assert impostor > geometry


def test_impostors_drawn_however_cheap_the_geometry_cost_nothing():
    assert Costs().of(part(), view(break_even=False), PIXELS, TEXELS, 0) == (np.inf, 0.0)
