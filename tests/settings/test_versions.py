"""Settings files of older versions keep their look."""

import math

import pytest

from addon.errors import SettingsError
from addon.settings.versions import VERSION, migrated


@pytest.mark.parametrize("name", ["light_strength", "light-strength"])
def test_a_strength_of_the_first_version_is_as_bright_as_it_was(name):
    now = migrated({name: 0.85, "map_size": 2048})
    assert now[name] == pytest.approx(0.85 * math.pi), "of a scene's light, which is divided by pi"
    assert now[name] * now["own_sun"] == pytest.approx(0.85), "of a sun of our own"
    assert now["map_size"] == 2048


def test_a_table_copied_from_an_old_report_is_as_bright_as_it_was():
    now = migrated({"shading": {"light_strength": 0.5, "ambient_sky": [0.1, 0.1, 0.1]}})
    assert now["shading"]["light_strength"] * now["shading"]["own_sun"] == pytest.approx(0.5)
    assert now["shading"]["ambient_sky"] == [0.1, 0.1, 0.1]


def test_what_says_nothing_of_light_is_left_alone():
    assert migrated({"map_size": 512, "shading": {"samples": 9}}) == {"map_size": 512, "shading": {"samples": 9}}


def test_this_version_is_taken_as_it_is():
    assert migrated({"settings_version": VERSION, "light_strength": 0.85}) == {"light_strength": 0.85}


@pytest.mark.parametrize("version", [VERSION + 1, 0, "2", None])
def test_an_unknown_version_is_refused(version):
    with pytest.raises(SettingsError, match="version"):
        migrated({"settings_version": version})


def test_odd_values_are_left_for_the_check():
    assert migrated({"light_strength": "bright"}) == {"light_strength": "bright"}
    assert migrated({"light_strength": -1.0}) == {"light_strength": -1.0}


@pytest.mark.parametrize("version", [1, 2])
def test_files_of_versions_that_drew_one_light_keep_it(version):
    assert migrated({"settings_version": version, "map_size": 512})["lights"] == "one"
    assert migrated({"settings_version": version, "lights": "all"})["lights"] == "all"
    assert migrated({"settings_version": VERSION, "map_size": 512}) == {"map_size": 512}
