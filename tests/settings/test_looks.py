"""Looks: each is whole, none touches how shadows are made, and uncoloured parts stand out from every background."""

import numpy as np
import pytest

from addon.errors import SettingsError
from addon.settings.groups import Settings, ShadingWorld
from addon.settings.looks import HELD, LOOKS, look_of, with_look
from addon.settings.options import BY_NAME

THE_SIX = {"clay", "cad", "technical", "sun-study", "oil-platform", "reference"}


def test_the_looks_are_those_promised():
    assert set(LOOKS) == THE_SIX


@pytest.mark.parametrize("name", sorted(THE_SIX))
def test_a_look_is_whole_whatever_was_set_before_and_touches_nothing_else(name):
    changed = Settings().replaced(
        edges={"width": 5.0}, shading={"clay": (0.1, 0.1, 0.1), "samples": 9}, ground={"kind": "height"}, fit={"size": 64}
    )
    made = with_look(changed, name)
    fresh = with_look(Settings(), name)
    assert made == fresh.replaced(shading={"samples": 9}, fit={"size": 64})
    assert look_of(made) == name
    assert set(LOOKS[name].values) <= set(HELD)


def test_looks_have_their_marks():
    on = {name: with_look(Settings(), name) for name in LOOKS}
    assert on["cad"].edges.is_on and on["cad"].ground.kind == "auto" and on["cad"].shading.use_object_colors
    assert not on["clay"].edges.is_on and not on["clay"].shading.use_object_colors
    assert on["technical"].edges.is_on and on["technical"].ground.kind == "off"
    assert on["reference"] == Settings()


def test_settings_by_hand_are_no_look():
    assert look_of(Settings().replaced(edges={"width": 3.3})) is None


def test_an_unknown_look_names_those_there_are():
    with pytest.raises(SettingsError, match="no look 'shiny'.*cad, clay"):
        with_look(Settings(), "shiny")


def test_every_held_option_is_one():
    assert set(HELD) <= set(BY_NAME)


@pytest.mark.parametrize("name", ["cad", "clay", "sun-study", "oil-platform"])
def test_parts_without_color_stand_out_from_the_background(name):
    """A surface of Blender's usual gray (0.8), lit and in shadow, against the background, by the ratio of their luminance."""
    shading = with_look(Settings(), name).shading.under(ShadingWorld())
    color = np.full(3, 0.8) if shading.use_object_colors else np.array(shading.clay)
    sky, ground = np.array(shading.ambient_sky), np.array(shading.ambient_ground)
    shade = color * (0.5 * sky + 0.5 * ground)
    lit = shade + 0.6 * color * shading.light_strength * shading.own_sun
    weights = np.array([0.2126, 0.7152, 0.0722])
    behind = weights @ np.array(shading.background[:3])
    ratios = [max(weights @ one, behind) / min(weights @ one, behind) for one in (lit, shade)]
    assert max(ratios) > 2.0
    assert min(ratios) > 1.1


def test_a_quick_sky_has_few_samples_and_stays_what_it_is():
    from addon.settings.sky import QUICK_SAMPLES, SkyChoice

    many, few = SkyChoice("cie", 256), SkyChoice("overcast", 8)
    assert many.quick == SkyChoice("cie", QUICK_SAMPLES) and few.quick == few
