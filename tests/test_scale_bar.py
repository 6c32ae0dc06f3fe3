"""Numbers as colours over a bar."""

import numpy as np
import pytest

from addon.images.scale_bar import bar, scaled_picture, sun_colors, ticks


def test_more_is_brighter_and_unknown_is_grey():
    share = np.linspace(0.0, 1.0, 50)
    brightness = sun_colors(share).astype(float) @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(brightness) >= -0.5).all() and brightness[-1] > brightness[0] + 150
    grey = sun_colors(np.array([np.nan]))[0]
    assert np.ptp(grey.astype(int)) < 10


@pytest.mark.parametrize("most", [0.001, 0.4, 1.0, 7.83, 16.6, 24.0, 1000.0])
def test_ticks_are_a_few_round_numbers_from_zero(most):
    found = ticks(most)
    assert found[0] == 0.0 and found[-1] <= most * 1.0001 and 3 <= len(found) <= 6


@pytest.mark.parametrize("width", [20, 300, 1280])
def test_a_picture_stands_above_its_bar(width):
    values = np.full((10, width), 3.0)
    values[:5] = np.nan
    image = scaled_picture(values, 12.0, "hours of direct sun", np.ones((10, width)))
    assert image.dtype == np.uint8 and image.shape[1] == width
    assert (image[10:] == bar(width, 12.0, "hours of direct sun")).all()
    assert (image[9] == sun_colors(np.array(0.25))).all()
