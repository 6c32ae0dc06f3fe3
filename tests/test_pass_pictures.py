"""Passes as pictures: each says by eye what it holds."""

import numpy as np
import pytest

from addon.images.passes import depth_picture
from addon.pipeline.render_passes import picture_of


def test_texels_that_nothing_casts_into_are_black_and_the_farthest_caster_is_not(rng):
    depth = rng.uniform(0.2, 0.9, (2, 16, 16)).astype(np.float32)
    empty = rng.random((2, 16, 16)) < 0.5
    picture = picture_of("texel", {"shadow_depth": np.where(empty, np.float32(1.0), depth)})
    tiles = np.stack(np.split(picture, 2, axis=1))
    assert (tiles[empty] == 0).all()
    assert (tiles[~empty] > 6000).all()
    assert [tile.max() for tile in tiles] == [65535, 65535], "the nearest caster of each map is white"


@pytest.mark.parametrize("nothing", [np.inf, np.nan])
def test_a_depth_picture_of_nothing_is_black(nothing):
    assert not depth_picture(np.full((4, 4), nothing, np.float32)).any()
    assert not picture_of("texel", {"shadow_depth": np.ones((3, 4, 4), np.float32)}).any()
