"""Presets: the shipped ones load completely and make pictures, the user's are kept and removed, nothing of them stays in Blender."""

import importlib
from pathlib import Path

import pytest

SHIPPED = ("balanced", "fast", "oil-platform", "reference", "sharp", "single-part")


@pytest.fixture
def presets(extension):
    return importlib.import_module(extension.__name__ + ".blender.presets")


@pytest.fixture
def settings_from(extension):
    return importlib.import_module(extension.__name__ + ".blender.properties").settings_from


def load(bpy, path):
    """As a click in the popover does."""
    assert bpy.ops.script.execute_preset(filepath=str(path), menu_idname="CAD_SHADOW_PT_presets") == {"FINISHED"}


def scrambled(props):
    """Settings far from every default."""
    props.warp, props.use_eta, props.eta, props.partition, props.partitions = "psm", True, 0.5, "z-log", 2
    props.test, props.epsilon, props.use_epsilon, props.pcf, props.map_size, props.samples = "id-depth", 0.5, True, "9", 64, "16"
    props.clay, props.display = (0.1, 0.2, 0.3), "aliasing"


def test_the_shipped_presets_are_those_promised(presets, blend):
    assert tuple(sorted(presets.files())) == SHIPPED
    assert set(blend.utils.preset_paths(presets.SUBDIR)) >= {str(presets.SHIPPED)}


@pytest.mark.parametrize("name", SHIPPED)
def test_a_preset_gives_the_same_settings_whatever_was_set_before(presets, settings_from, blend, name):
    props, path = blend.context.scene.cad_shadow, presets.files()[name]
    load(blend, path)
    fresh = settings_from(props)
    scrambled(props)
    load(blend, path)
    again = settings_from(props)
    assert again.replaced(shading={"display": "shaded", "clay": fresh.shading.clay}) == fresh
    assert [round(v, 3) for v in props.clay] == [0.1, 0.2, 0.3], "colours are the scene's"
    assert props.display == "aliasing"


def test_balanced_is_the_defaults(presets, settings_from, blend, extension):
    scrambled(blend.context.scene.cad_shadow)
    presets.apply(blend.context.scene, "Balanced")
    blend.context.scene.cad_shadow.property_unset("clay")
    blend.context.scene.cad_shadow.property_unset("display")
    settings = importlib.import_module(extension.__name__ + ".settings.groups").Settings()
    assert settings_from(blend.context.scene.cad_shadow) == settings


def test_presets_grow_in_cost_from_fast_to_reference(presets, settings_from, blend):
    def texels(name):
        presets.apply(blend.context.scene, name)
        settings = settings_from(blend.context.scene.cad_shadow)
        return settings.partition.z_count * settings.fit.size**2 * settings.shading.samples

    costs = [texels(name) for name in ("Fast", "Balanced", "Sharp", "Reference")]
    assert costs == sorted(set(costs))


@pytest.mark.parametrize("name", ["fast", "sharp", "single-part"])
def test_presets_make_pictures(presets, cube_scene, blend, name):
    presets.apply(cube_scene, name)
    cube_scene.cad_shadow.map_size = 64
    assert blend.ops.cad_shadow.analyse() == {"FINISHED"}


def test_a_preset_of_the_users_own_comes_back_as_it_was_and_can_be_removed(presets, settings_from, blend, user_resources):
    props = blend.context.scene.cad_shadow
    scrambled(props)
    wanted = settings_from(props)
    assert blend.ops.cad_shadow.preset_add(name="My plant 2") == {"FINISHED"}
    path = Path(user_resources, "scripts", "presets", presets.SUBDIR, "My_plant_2.py")
    assert presets.files()["my-plant-2"] == path
    presets.apply(blend.context.scene, "fast")
    presets.apply(blend.context.scene, "My plant 2")
    assert settings_from(props) == wanted
    assert blend.ops.cad_shadow.preset_add(name="My plant 2", remove_name=True) == {"FINISHED"}
    assert not path.exists()
    assert "my-plant-2" not in presets.files()


def test_shipped_presets_can_neither_be_overwritten_nor_removed(presets, blend):
    before = presets.files()["sharp"].read_text()
    for arguments in ({"name": "Sharp"}, {"name": "Sharp", "remove_name": True}):
        blend.ops.cad_shadow.preset_add(**arguments)
    assert presets.files()["sharp"] == presets.SHIPPED / "Sharp.py"
    assert presets.files()["sharp"].read_text() == before


def test_an_unknown_preset_names_those_there_are(presets, blend):
    with pytest.raises(Exception, match="no preset 'shiny'.*balanced, fast"):
        presets.apply(blend.context.scene, "shiny")


def test_a_preset_can_hold_nothing_but_existing_settings(presets, blend):
    props = blend.context.scene.cad_shadow
    for path in presets.SHIPPED.glob("*.py"):
        names = [line.split(" = ")[0].removeprefix("settings.") for line in path.read_text().splitlines() if line.startswith("settings.")]
        assert set(names) <= set(presets.HELD), path.name
        assert set(names) <= set(dir(props)), path.name


def test_disabling_takes_the_presets_out_of_blender(presets, extension, blend):
    addon_utils = importlib.import_module("addon_utils")
    module = extension.__name__.removesuffix(".addon")
    addon_utils.disable(module, default_set=True)
    try:
        assert str(presets.SHIPPED) not in blend.utils.preset_paths(presets.SUBDIR)
        assert not hasattr(blend.types, "CAD_SHADOW_PT_presets")
    finally:
        addon_utils.enable(module, default_set=True)
    assert str(presets.SHIPPED) in blend.utils.preset_paths(presets.SUBDIR)
