"""Panels and operators without a window: they register in order, draw without an error, and say why they are grey."""

import importlib
import json
import re

import pytest


class Layout:
    """Stands in for Blender's layout, which needs a window: notes what is drawn, refuses properties and operators that do not exist."""

    def __init__(self, bpy):
        self.bpy, self.shown, self.texts, self.menus = bpy, [], [], {}

    def __getattr__(self, name):
        if name in ("column", "row", "box", "split"):
            return lambda **_: self
        raise AttributeError(name)

    def prop(self, data, name, index=-1, text="", icon="NONE", toggle=False, expand=False, emboss=True):
        assert name in data.bl_rna.properties, name
        self.shown.append(name)

    def operator(self, idname, text="", icon="NONE", depress=False):
        group, name = idname.split(".")
        assert name in dir(getattr(self.bpy.ops, group)), idname
        self.shown.append(idname)
        return Pressed(getattr(getattr(self.bpy.ops, group), name).get_rna_type())

    def template_list(self, kind, _list_id, data, rows, active_data, index, **_):
        assert hasattr(self.bpy.types, kind), kind
        assert rows in data.bl_rna.properties and index in active_data.bl_rna.properties
        self.shown.append(kind)

    def popover(self, panel, text="", icon="NONE"):
        assert hasattr(self.bpy.types, panel), panel
        self.menus[panel] = text

    def menu(self, menu, text="", icon="NONE"):
        assert hasattr(self.bpy.types, menu), menu
        self.menus[menu] = text

    def label(self, text="", icon="NONE"):
        self.texts.append(text)


class Pressed:
    """What a button will call the operator with; refuses what the operator does not take."""

    def __init__(self, operator):
        object.__setattr__(self, "operator", operator)

    def __setattr__(self, name, value):
        known = self.operator.properties[name]
        assert known.type != "ENUM" or value in known.enum_items, (self.operator.identifier, name, value)


@pytest.fixture
def drawn(blend, room):
    """What a section of the sidebar shows now."""

    class Panel:
        pass

    def draw(key):
        panel = Panel()
        panel.layout = Layout(blend)
        section = next(s for s in room("blender.panels.settings").SECTIONS if s.key == key)
        section.draw(panel, blend.context)
        return set(panel.layout.shown)

    return draw


def test_every_option_is_in_exactly_one_section(drawn, room, blend):
    props = blend.context.scene.cad_shadow
    sections = [s.key for s in room("blender.panels.settings").SECTIONS]
    for option in room("settings.options").OPTIONS:
        shown = []
        for warp, partition, test in (
            ("lispsm-general", "z-adaptive", "id-depth"),
            ("psm", "z-pssm", "depth"),
            ("uniform", "none", "triangle"),
            ("logpsm", "faces", "depth"),
        ):
            props.warp, props.partition, props.test = warp, partition, test
            props.bias_strategy, props.use_object_colors, props.pcf = "constant", False, "1" if test == "triangle" else "9"
            props.edges, props.ground, props.light_samples = 1.0, "height", 16
            shown.append({key for key in sections if option.name in drawn(key)})
        assert len(set.union(*shown)) == 1, option.name


def test_only_what_applies_is_shown(drawn, blend):
    props = blend.context.scene.cad_shadow
    props.partition, props.warp = "none", "uniform"
    assert drawn("partition") == {"partition"}
    assert not drawn("warp_expert") & {"eta", "warp_parameter", "convergence"}
    props.partition = "z-adaptive"
    assert drawn("partition") == {"partition", "partitions", "cut", "use_alpha", "alpha"}
    props.partition = "z-pssm"
    assert drawn("partition") == {"partition", "partitions", "cut", "split_weight"}
    props.test, props.bias_strategy = "depth", "automatic"
    assert "bias" not in drawn("map_expert")
    props.bias_strategy = "constant"
    assert "bias" in drawn("map_expert")


def test_light_section_shows_what_its_source_needs(drawn, blend):
    props = blend.context.scene.cad_shadow
    for source, names in (("AUTOMATIC", ("lights",)), ("OBJECT", ("light",)), ("DIRECTION", ("light_azimuth", "light_elevation"))):
        props.light_source = source
        assert drawn("light") == {"light_source", "light_strength", "light_samples"} | set(names)
    props.light_samples = 16
    assert {"softness", "use_sun_angle"} <= drawn("light")


def first_panel(blend, room):
    panel = type("Panel", (), {})()
    panel.layout = Layout(blend)
    room("blender.panels.settings").draw_preview(panel, blend.context)
    return panel.layout


def test_the_tab_opens_with_what_a_beginner_needs_and_the_rest_is_closed(blend, room):
    opened = [section.key for section in room("blender.panels.settings").SECTIONS if not section.closed]
    assert opened == ["preview", "light"]
    layout = first_panel(blend, room)
    assert layout.shown == ["cad_shadow.preview", "cad_shadow.live_view"]
    assert list(layout.menus) == ["CAD_SHADOW_MT_looks", "CAD_SHADOW_PT_presets"]


def test_the_first_panel_says_which_look_and_which_preset_are_on(blend, room):
    props = blend.context.scene.cad_shadow
    assert first_panel(blend, room).menus == {"CAD_SHADOW_MT_looks": "Reference", "CAD_SHADOW_PT_presets": "Balanced"}
    assert blend.ops.cad_shadow.look(look="clay") == {"FINISHED"}
    room("blender.presets").apply(blend.context.scene, "oil-platform")
    assert first_panel(blend, room).menus == {"CAD_SHADOW_MT_looks": "Clay", "CAD_SHADOW_PT_presets": "Oil platform"}
    props.clay, props.map_size = (0.1, 0.2, 0.3), 333
    assert first_panel(blend, room).menus == {"CAD_SHADOW_MT_looks": "Custom", "CAD_SHADOW_PT_presets": "Custom"}


def test_the_first_panel_says_in_words_how_sharp_the_last_picture_is(cube_scene, blend, room):
    blend.context.view_layer.update()
    assert not first_panel(blend, room).texts[2:]
    assert blend.ops.cad_shadow.analyse() == {"FINISHED"}
    error = room("blender.session").last().report["measured"]["m_p95"]
    words = " ".join(first_panel(blend, room).texts)
    assert ("coarser than a pixel" if error > 1.0 else "sharper than a pixel") in words
    assert f"({error:.3g} pixels)" in words


def test_every_preset_and_every_look_is_known_again(blend, room):
    presets, looks, chosen = room("blender.presets"), room("settings.looks"), room("blender.panels.chosen")
    props = blend.context.scene.cad_shadow
    for path in sorted(presets.SHIPPED.glob("*.py")):
        presets.apply(blend.context.scene, path.stem)
        assert presets.preset_of(props) == path.stem.replace("_", " ")
    for name, look in looks.LOOKS.items():
        assert blend.ops.cad_shadow.look(look=name) == {"FINISHED"}
        assert chosen.look_label(props) == look.label
    assert blend.context.scene.view_settings.view_transform == "Standard"


def test_a_look_leaves_how_shadows_are_made_alone(blend, room):
    props = blend.context.scene.cad_shadow
    props.map_size, props.display, props.samples = 333, "aliasing", "9"
    for name in room("settings.looks").LOOKS:
        blend.ops.cad_shadow.look(look=name)
        assert (props.map_size, props.display, props.samples) == (333, "aliasing", "9")


def test_the_light_is_turned_by_its_angles(blend):
    props = blend.context.scene.cad_shadow
    props.light_azimuth, props.light_elevation = 0.5, 0.8
    assert (props.light_azimuth, props.light_elevation) == pytest.approx((0.5, 0.8), abs=1e-5)
    props.light_elevation = 1.5707963
    props.light_elevation = 0.3
    assert props.light_azimuth == pytest.approx(0.5, abs=1e-3)


def test_quality_lists_the_last_report(cube_scene, blend, room):
    class Panel:
        pass

    quality = room("blender.panels.quality")
    panel = Panel()
    panel.layout = Layout(blend)
    quality.CAD_SHADOW_PT_sidebar_quality.draw(panel, blend.context)
    assert "Press CAD Shadow Preview" in " ".join(panel.layout.texts)
    assert blend.ops.cad_shadow.analyse() == {"FINISHED"}
    panel.layout = Layout(blend)
    quality.CAD_SHADOW_PT_sidebar_quality.draw(panel, blend.context)
    assert {"γ", "γ_lim", "n'", "η", "M_x, M_z", "S", "Median", "Largest"} <= set(panel.layout.texts)
    assert sum(text.startswith("Map ") for text in panel.layout.texts) == len(room("blender.session").last().report["partitions"])
    listed, panel.layout = panel.layout.texts, Layout(blend)
    quality.CAD_SHADOW_PT_sidebar_quality_words.draw(panel, blend.context)
    symbols = re.compile(r"γ_lim|γ|n'|η|M_x|M_z|\bS\b")
    assert set(symbols.findall(" ".join(listed))) <= set(symbols.findall(" ".join(panel.layout.texts)))


def test_blenders_own_panels_know_the_engine_and_forget_it(room, blend):
    compatible = room("blender.panels.compatible")
    names = {cls.__name__ for cls in compatible.fitting_panels()}
    assert {"RENDER_PT_output", "RENDER_PT_format", "DATA_PT_lens", "DATA_PT_light", "RENDER_PT_color_management"} <= names
    assert not any("freestyle" in name.lower() or "opengl" in name for name in names)
    output = next(cls for cls in compatible.fitting_panels() if cls.__name__ == "RENDER_PT_output")
    assert compatible.ENGINE in output.COMPAT_ENGINES
    compatible.unregister()
    assert compatible.ENGINE not in output.COMPAT_ENGINES
    compatible.register()
    assert compatible.ENGINE in output.COMPAT_ENGINES


def test_preview_operator_makes_the_picture_and_the_report(cube_scene, blend, room):
    assert blend.ops.cad_shadow.preview() == {"FINISHED"}
    assert tuple(blend.data.images["CAD Shadow Preview"].size) == (96, 64)
    assert room("blender.session").last().report["geometry"]["triangles"] == 14


def test_operators_are_grey_with_nothing_to_draw(blend):
    assert not blend.ops.cad_shadow.preview.poll()
    assert not blend.ops.cad_shadow.analyse.poll()
    with pytest.raises(RuntimeError, match="no mesh to draw"):
        blend.ops.cad_shadow.preview()


def test_a_failing_operator_reports_one_line(cube_scene, blend):
    cube_scene.cad_shadow.light_source = "OBJECT"
    with pytest.raises(RuntimeError, match="No light object is chosen"):
        blend.ops.cad_shadow.preview()


def test_export_writes_the_last_report(cube_scene, blend, room, tmp_path):
    with pytest.raises(RuntimeError, match="no report yet"):
        blend.ops.cad_shadow.export_report(filepath=str(tmp_path / "r.json"))
    blend.ops.cad_shadow.analyse()
    assert blend.ops.cad_shadow.export_report(filepath=str(tmp_path / "r.json")) == {"FINISHED"}
    assert json.loads((tmp_path / "r.json").read_text()) == json.loads(json.dumps(room("blender.session").last().report))


def test_another_file_forgets_the_last_report(cube_scene, blend, room):
    blend.ops.cad_shadow.analyse()
    assert room("blender.session").last() is not None
    blend.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    assert room("blender.session").last() is None


CHANGES = {
    "a setting": lambda bpy, scene: setattr(scene.cad_shadow, "map_size", 64),
    "a preset": lambda bpy, scene: bpy.ops.script.execute_preset(filepath=_preset("fast"), menu_idname="CAD_SHADOW_PT_presets"),
    "another light": lambda bpy, scene: setattr(scene.cad_shadow, "light_source", "VIEW"),
    "a moved object": lambda bpy, scene: setattr(scene.objects["Cube"], "location", (1.0, 0.0, 1.0)),
    "a deleted object": lambda bpy, scene: bpy.data.objects.remove(scene.objects["Cube"]),
    "a new object": lambda bpy, scene: bpy.ops.mesh.primitive_cube_add(),
    "a brighter light": lambda bpy, scene: setattr(scene.objects["Sun"].data, "energy", 9.0),
    "a hidden object": lambda bpy, scene: setattr(scene.objects["Cube"], "hide_render", True),
}
MADE_BY = {
    "analyse": lambda bpy, api: bpy.ops.cad_shadow.analyse(),
    "F12": lambda bpy, api: bpy.ops.render.render(),
    "a script": lambda bpy, api: api.preview(),
}


def _preset(name):

    return str(importlib.import_module("bl_ext.user_default.cad_shadow_preview.addon.blender.presets").files()[name])


@pytest.mark.parametrize("change", CHANGES)
def test_the_quality_panel_says_when_its_numbers_are_from_before_a_change(cube_scene, blend, room, change):
    blend.context.view_layer.update()
    blend.ops.cad_shadow.analyse()
    session = room("blender.session")
    assert session.is_last_current(cube_scene)
    CHANGES[change](blend, cube_scene)
    blend.context.view_layer.update()
    assert not session.is_last_current(cube_scene)
    blend.ops.cad_shadow.analyse() if "deleted" not in change else blend.ops.cad_shadow.preview()
    assert session.is_last_current(cube_scene)


@pytest.mark.parametrize("made_by", MADE_BY)
def test_numbers_are_of_the_present_whoever_made_them_and_selecting_or_looking_changes_nothing(cube_scene, blend, api, room, made_by):
    blend.context.view_layer.update()
    MADE_BY[made_by](blend, api)
    session = room("blender.session")
    assert session.is_last_current(cube_scene)
    blend.ops.object.select_all(action="SELECT")
    blend.context.view_layer.update()
    assert session.is_last_current(cube_scene)
    other = blend.data.scenes.new("Another")
    assert not session.is_last_current(other)


def test_a_setting_put_back_makes_the_numbers_those_of_the_present_again(cube_scene, blend, room):
    blend.context.view_layer.update()
    blend.ops.cad_shadow.analyse()
    for samples, expected in (("16", False), ("4", True)):
        cube_scene.cad_shadow.samples = samples
        blend.context.view_layer.update()
        assert room("blender.session").is_last_current(cube_scene) is expected
