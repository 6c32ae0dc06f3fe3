"""Near and far of a viewport follow what is imported, and go back."""

import pytest


@pytest.fixture
def fit(blend, room):
    """Moves the distances of a viewport for a size; gives them as they are then."""
    blend.ops.wm.read_homefile(use_factory_startup=True)
    screen = blend.data.screens["Layout"]
    space = next(area.spaces.active for area in screen.areas if area.type == "VIEW_3D")
    screen.pop(room("blender.clip_range").KEPT, None)  # a file opened without its windows leaves those of the test before
    space.clip_start, space.clip_end = 0.01, 1000.0

    def moved(size=None):
        if size is not None:
            room("blender.clip_range").fit(screen, space, size)
        return round(space.clip_start, 7), round(space.clip_end, 3)

    moved.space = space
    return moved


def test_a_plant_after_a_small_part_is_seen_as_if_there_had_been_no_part(fit):
    before = fit()
    assert fit(0.004) == (2e-5, 1000.0)
    assert fit(2.0) == before
    for size in (0.25, 0.004, 30.0):
        fit(size)
    assert fit() == before


def test_a_part_after_a_plant_has_its_near_and_no_farther_far_than_needed(fit):
    assert fit(300.0) == (0.01, 6000.0)
    assert fit(0.004) == (2e-5, 1000.0)


def test_what_the_user_has_set_is_kept_and_gone_back_to(fit):
    fit(0.004)
    fit.space.clip_start, fit.space.clip_end = 0.5, 200.0
    assert fit(20.0) == (0.1, 400.0)
    assert fit(5.0) == (0.025, 200.0)
    assert fit(200.0) == (0.5, 4000.0)


def test_it_is_remembered_with_the_file(fit, blend, room, tmp_path):
    fit(0.004)
    path = str(tmp_path / "part.blend")
    blend.ops.wm.save_as_mainfile(filepath=path)
    blend.ops.wm.open_mainfile(filepath=path, load_ui=True)
    screen = blend.data.screens["Layout"]
    space = next(area.spaces.active for area in screen.areas if area.type == "VIEW_3D")
    assert space.clip_start < 1e-4
    room("blender.clip_range").fit(screen, space, 100.0)
    assert round(space.clip_start, 6) == 0.01


@pytest.mark.parametrize("size", [0.0, 1e-9, 1e7])
def test_no_size_is_too_small_or_too_large(fit, size):
    near, far = fit(size)
    assert 0.0 < near <= 0.01 and far >= 1000.0
