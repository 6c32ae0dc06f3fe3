"""The settings on a scene: they mirror the frozen dataclasses, and every option reaches its field."""

import math
from dataclasses import fields

import numpy as np
import pytest


@pytest.fixture
def modules(extension):
    import importlib

    return {
        name: importlib.import_module(f"{extension.__name__}.{name}")
        for name in ("settings.options", "blender.properties", "settings.groups")
    }


@pytest.fixture
def props(blend):
    return blend.context.scene.cad_shadow


def test_untouched_properties_are_the_dataclass_defaults(props, modules):
    assert modules["blender.properties"].settings_from(props) == modules["settings.groups"].Settings()


def test_every_field_of_the_settings_has_an_option(modules):
    settings = modules["settings.groups"].Settings()
    everything = {(group.name, field.name) for group in fields(settings) for field in fields(getattr(settings, group.name))}
    everything.remove(("section", "planes"))  # from the section planes' own properties: test_sections.py
    assert everything == {target for option in modules["settings.options"].OPTIONS for target in option.targets}


def test_every_property_explains_itself(props):
    mute = [p.identifier for p in props.bl_rna.properties if p.identifier not in ("rna_type", "name") and len(p.description) < 12]
    assert not mute


def test_every_choice_is_the_command_lines_and_explains_itself(props, modules):
    for option in modules["settings.options"].OPTIONS:
        if option.kind == "choice":
            items = props.bl_rna.properties[option.name].enum_items
            assert [item.identifier for item in items] == [identifier for identifier, _, _ in option.items]
            assert all(item.description for item in items)


CHANGES = {
    "warp": "psm", "eta": 0.25, "warp_parameter": 12.5, "pseudo_near": 3.5, "convergence": "sine", "log_bend": 1.5,
    "partition": "z-pssm", "partitions": 6, "cut": "view", "split_weight": 0.7, "alpha": (2.0, 2.5, 4.0),
    "map_size": 2048, "fit": "scene", "margin": 2.5,
    "test": "id-depth", "depths": 4, "pcf": "9", "filter_unit": "pixel", "filter_width": 2.5, "bias_strategy": "slope-scaled",
    "bias": 0.75, "epsilon": 0.002, "epsilon_far": 0.25, "id_per_material": True, "outlines": True,
    "casters": "coarse", "caster_error": 0.25, "smoothing": "9",
    "lights": "one", "light_samples": 32, "softness": 2.5, "sun_angle": 1.5, "sky": "uniform", "sky_samples": 96,
    "display": "aliasing", "samples": "9", "light_strength": 1.5, "own_sun": 0.5, "exposure": 1.25,
    "ambient_sky": (0.1, 0.2, 0.3), "ambient_ground": (0.3, 0.2, 0.1),
    "use_object_colors": False, "clay": (0.7, 0.6, 0.5), "background": (0.0, 0.1, 0.2, 0.5),
    "impostor_use": "manual", "impostor_fresh": False, "impostor_projection": "orthographic", "impostor_back": False,
    "impostor_warp": "forward", "impostor_predictor": "critical", "impostor_limit": 0.125, "impostor_texels": 1.5,
    "impostor_max_texels": 512, "impostor_tilt": 30.0, "impostor_captures": 3, "impostor_memory": 64, "impostor_fade": 4,
    "impostor_sprite": 0.5, "impostor_ahead": 0.5,
    "impostor_break_even": False, "impostor_views": 2, "impostor_directions": 8, "impostor_fill": False,
    "impostor_casters": "impostor",
    "edges": 1.5, "edge_color": (0.1, 0.2, 0.3), "edge_strength": 0.5, "edge_angle": 45.0,
    "ground": "height", "ground_height": 2.5, "ground_strength": 0.5,
    "section_caps": "hatch", "section_color": (0.3, 0.2, 0.1), "section_whole": True,
}  # fmt: skip


def test_every_option_has_a_case_here(modules):
    assert set(CHANGES) == set(modules["settings.options"].BY_NAME)


# what must be chosen for an option to apply at all
NEEDS = {
    "edge_color": {"edges": 1.0},
    "edge_strength": {"edges": 1.0},
    "edge_angle": {"edges": 1.0},
    "ground_height": {"ground": "height"},
    "ground_strength": {"ground": "auto"},
    "log_bend": {"warp": "logpsm"},
    "split_weight": {"partition": "z-pssm"},
    "bias": {"bias_strategy": "constant"},
    "clay": {"use_object_colors": False},
    "filter_unit": {"pcf": "9"},
    "filter_width": {"pcf": "9"},
    "outlines": {"test": "triangle"},
    "softness": {"light_samples": 16},
    "sun_angle": {"light_samples": 16},
    "sky_samples": {"sky": "uniform"},
    "alpha": {"cut": "view"},  # as many values as seams: four slices, not two of two halves
}
NEEDS |= dict.fromkeys(("epsilon", "epsilon_far", "id_per_material"), {"test": "id-depth"})


@pytest.mark.parametrize("name", CHANGES)
def test_each_property_reaches_its_field_exactly(props, modules, name):
    options, properties = modules["settings.options"], modules["blender.properties"]
    values = NEEDS.get(name, {}) | {name: CHANGES[name]}
    properties.store(props, values)
    expected = options.with_options(modules["settings.groups"].Settings(), values)
    assert properties.settings_from(props) == expected
    assert options.values_of(expected)[name] == options.typed(options.BY_NAME[name], CHANGES[name])


def test_what_does_not_apply_is_left_at_its_default(props, modules):
    properties = modules["blender.properties"]
    properties.store(props, {"depths": 4, "epsilon": 0.5, "test": "triangle", "warp": "uniform", "eta": 0.5})
    settings = properties.settings_from(props)
    assert (settings.test.depths, settings.test.epsilon, settings.warp.eta) == (1, None, None)


def test_a_stored_float_comes_back_as_the_number_typed(props, modules, rng):
    shortest = modules["blender.properties"].shortest
    typed = [round(float(x), 5) for x in 10.0 ** rng.uniform(-3, 1, 200)]
    for value in typed:
        props.light_strength = value
        assert shortest(props.light_strength) == pytest.approx(value, rel=1e-7)
        assert len(repr(shortest(props.light_strength))) <= len(repr(float(np.float32(value))))
    props.light_strength = 0.85
    assert shortest(props.light_strength) == 0.85 != props.light_strength


def test_parameter_wins_over_eta_where_both_are_set(props, modules):
    modules["blender.properties"].store(props, {"eta": 0.5, "warp_parameter": 7.0})
    warp = modules["blender.properties"].settings_from(props).warp
    assert (warp.eta, warp.parameter) == (None, 7.0)


def test_an_unknown_option_and_a_wrong_type_are_refused(modules):
    options, settings = modules["settings.options"], modules["settings.groups"].Settings()
    for values in (
        {"wrap": "psm"},
        {"partitions": 2.5},
        {"map_size": "big"},
        {"id_per_material": 1},
        {"clay": (1.0, 1.0)},
        {"eta": math.nan},
    ):
        with pytest.raises(ValueError, match=r"[a-z]"):
            options.with_options(settings, values)


def test_saved_settings_carry_their_version(blend, tmp_path, modules):
    path = str(tmp_path / "kept.blend")
    blend.context.scene.cad_shadow.partitions = 3
    blend.ops.wm.save_as_mainfile(filepath=path)
    blend.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    blend.ops.wm.open_mainfile(filepath=path)
    props = blend.context.scene.cad_shadow
    assert (props.partitions, props.settings_version) == (3, modules["blender.properties"].SETTINGS_VERSION)


def groups(blend):
    """The settings of the scene, those of its sun and of a section plane."""
    props = blend.context.scene.cad_shadow
    return props, props.sun, props.section_1


def test_setting_any_property_from_python_has_the_areas_drawn_again(blend, room, monkeypatch):
    """Blender tells nobody of what a script, an operator or a preset sets, unless the property has an update of its own."""
    drawn, silent = [], []
    monkeypatch.setattr(room("blender.redraw"), "redraw", drawn.append)
    for group in groups(blend):
        for prop in group.bl_rna.properties:
            if prop.identifier in ("rna_type", "name", "sun", "section_1", "section_2", "section_3", "settings_version"):
                continue
            drawn.clear()
            setattr(group, prop.identifier, getattr(group, prop.identifier))
            if not drawn:
                silent.append(prop.identifier)
    assert silent == []


@pytest.mark.parametrize("name", ["balanced", "fast"])
def test_a_preset_has_the_areas_drawn_again_also_where_it_only_goes_back_to_defaults(blend, room, monkeypatch, name):
    drawn, presets = [], room("blender.presets")
    monkeypatch.setattr(presets, "redraw", drawn.append)
    presets.apply(blend.context.scene, name)
    assert drawn
