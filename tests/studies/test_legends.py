"""The live view's legends: their colours stand at the numbers beside them, and everything lies within its box."""

import numpy as np
import pytest

from addon.images.heatmap import scale_colors
from addon.images.passes import id_colors
from addon.maths.shadow.projection import ShadowPlan, ShadowProjection
from addon.studies.legends import MOST_MAPS, heat_legend, legend_of, map_legend


def srgb(color):
    """Bytes of a linear colour."""
    c = np.asarray(color, float)[..., :3]
    return np.rint(255.0 * np.where(c <= 0.0031308, 12.92 * c, 1.055 * c ** (1.0 / 2.4) - 0.055))


def plan_of(count, empty=()):
    projections = [ShadowProjection(np.eye(4), float(i + 1), float(i + 2), is_empty=i in empty) for i in range(count)]
    return ShadowPlan(tuple(projections), 1.0, 0.2, np.eye(4))


def check_within(legend):
    width, height = legend.size
    x, y, w, h = legend.colors_at
    assert legend.colors.shape == (h, w, 4)
    assert x >= 0
    assert y >= 0
    assert x + w <= width
    assert y + h <= height
    for word in legend.words:
        assert 0 <= word.x <= width
        assert 0 <= word.y <= height - 8
        assert not (x <= word.x < x + w and y - 4 < word.y < y + h), f"{word.text} lies on the colours"


@pytest.mark.parametrize("scale", [0.8, 1.0, 1.5, 2.0])
def test_every_number_of_the_heat_legend_stands_at_its_colour(scale):
    legend = heat_legend(scale)
    check_within(legend)
    x0, _, width, _ = legend.colors_at
    numbers = [w for w in legend.words if w.text[0].isdigit()]
    assert [w.text for w in numbers] == ["1/4", "1/2", "1", "2", "4", "8", "16"]
    for word in numbers:
        value = 1.0 / float(word.text[2:]) if "/" in word.text else float(word.text)
        column = min(round(word.x - x0), width - 1)
        assert np.abs(srgb(legend.colors[0, column]) - scale_colors(np.array(value))).max() <= 4


@pytest.mark.parametrize("scale", [1.0, 2.0])
def test_every_map_in_use_has_its_colour_beside_its_name(scale):
    legend = map_legend(plan_of(5, empty=(1,)), scale)
    check_within(legend)
    x0, y0, _, height = legend.colors_at
    named = [w for w in legend.words if w.text.startswith("Map ")]
    assert [w.text for w in named] == ["Map 1:  1 … 2 m", "Map 3:  3 … 4 m", "Map 4:  4 … 5 m", "Map 5:  5 … 6 m"]
    for word in named:
        row = height - 1 - round(word.y - y0 + 5 * scale)
        index = int(word.text[4]) - 1
        assert (srgb(legend.colors[row, 4]) == id_colors(np.array([index]))[0]).all()


def test_a_plan_of_many_maps_is_cut_short_and_says_so():
    legend = map_legend(plan_of(MOST_MAPS + 8), 1.0)
    check_within(legend)
    assert legend.words[-1].text == "and 8 more"


def test_only_data_displays_have_a_legend():
    assert legend_of("shaded", plan_of(2), 1.0) is None
    assert legend_of("shadow", plan_of(2), 1.0) is None
    assert legend_of("partitions", None, 1.0) is None
    assert legend_of("aliasing", None, 1.0) is heat_legend(1.0)
