"""What the picture shows instead of the lit model: errors and maps, in the colours of the legends."""

import numpy as np
import pytest

from addon.images.color_bar import NOTHING
from addon.images.heatmap import scale_colors
from addon.images.passes import id_colors
from addon.pipeline.job import Job
from addon.settings.groups import Settings
from addon.studies.run import run
from tests import scenes

SIZE = (96, 64)
CAMERA = scenes.look_at((14.0, -16.0, 9.0), (0.0, 0.0, 0.7), fov_y_deg=35.0, near=1.0, far=80.0)
SUN = scenes.sun(40.0)


def shown(renderer, display, light=SUN, camera=CAMERA):
    """sRGB 0…255 of the picture alone, as a live view asks for it, and the data of the same view."""
    chosen = Settings().replaced(shading={"display": display, "samples": 1}, fit={"size": 64})
    alone = run(Job(scenes.railing(), camera, light, chosen, SIZE, measure=False), on=renderer).frame.passes["combined"]
    data = run(Job(scenes.railing(), camera, light, chosen, SIZE, ("combined", "aliasing", "partition", "depth")), on=renderer).frame.passes
    assert np.array_equal(data["combined"], alone)
    linear = alone[..., :3].astype(np.float64)
    srgb = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-9) ** (1.0 / 2.4) - 0.055)
    return 255.0 * srgb, data


def shades(picture, colors):
    """(P,) by how much each colour is darkened; fails where it is not the same in every channel (within rounding)."""
    colors = colors.astype(np.float64)
    shade = (picture * colors).sum(axis=-1) / (colors * colors).sum(axis=-1)
    assert np.abs(picture - shade[:, None] * colors).max() < 1.0
    return shade


@pytest.mark.parametrize(("display", "name", "colors_of"), [("aliasing", "aliasing", scale_colors), ("partitions", "partition", id_colors)])
def test_a_data_display_has_the_legends_colours_darkened_only_in_brightness(renderer, display, name, colors_of):
    picture, data = shown(renderer, display)
    surface = np.isfinite(data["depth"])
    values = data[name][..., 0] if name == "aliasing" else data[name]
    assert len(np.unique(colors_of(values[surface]), axis=0)) > 1
    shade = shades(picture[surface], colors_of(values[surface]))
    assert shade.min() > 0.49
    assert shade.max() < 1.01
    assert np.ptp(shade) > 0.2  # shape and shadows stay readable


@pytest.mark.parametrize("display", ["aliasing", "partitions"])
def test_without_a_light_a_data_display_is_the_legends_grey(renderer, display):
    picture, data = shown(renderer, display, light=None)
    surface = np.isfinite(data["depth"])
    shades(picture[surface], np.broadcast_to(NOTHING, picture[surface].shape))


def test_a_stop_of_exposure_is_twice_the_light_and_leaves_alpha_and_pictures_of_data_alone(renderer):
    def picture(display, exposure):
        chosen = Settings().replaced(shading={"display": display, "samples": 1, "exposure": exposure}, fit={"size": 64})
        return run(Job(scenes.railing(), CAMERA, SUN, chosen, SIZE, measure=False), on=renderer).frame.passes["combined"]

    usual, brighter = picture("shaded", 0.0), picture("shaded", 1.5)
    assert np.allclose(brighter[..., :3], 2.0**1.5 * usual[..., :3], rtol=1e-6)
    assert np.array_equal(brighter[..., 3], usual[..., 3])
    assert np.array_equal(picture("aliasing", 0.0), picture("aliasing", 1.5))
