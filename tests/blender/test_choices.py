"""What means nothing under the light that is there cannot be chosen in the panels, and a choice made before is explained."""

import importlib

import pytest


@pytest.fixture
def room(extension):
    return lambda name: importlib.import_module(f"{extension.__name__}.{name}")


class Layout:
    """Notes what a panel or menu offers."""

    def __init__(self):
        self.offered, self.menus, self.properties, self.texts = [], [], [], []
        self.use_property_split = self.use_property_decorate = False

    def prop_enum(self, _data, name, key):
        self.offered.append((name, key))

    def menu(self, name, text):
        self.menus.append((name, text))

    def prop(self, _data, name, **_):
        self.properties.append(name)

    def column(self, **_):
        return self

    def label(self, text="", icon="NONE"):
        self.texts.append(text)


class Holder:
    """Stands in for a panel or menu."""

    def __init__(self):
        self.layout = Layout()


def add_light(bpy, kind):
    bpy.ops.object.light_add(type=kind)


def offered(bpy, room, name):
    """The choices of an option in its menu, and what its section draws."""
    settings = room("panels.settings")
    menu, panel = Holder(), Holder()
    menu_class = next(m for m in settings.MENUS if m.__name__.endswith(name))
    menu_class.draw(menu, bpy.context)
    next(s for s in settings.SECTIONS if s.key == name).draw(panel, bpy.context)
    return [key for _, key in menu.layout.offered], panel.layout


@pytest.mark.parametrize("name", ["warp", "partition"])
@pytest.mark.parametrize("kind", [None, "SUN"])
def test_everything_can_be_chosen_under_a_sun(blend, room, name, kind):
    if kind:
        add_light(blend, kind)
    keys, drawn = offered(blend, room, name)
    assert keys == [item[0] for item in room("options").BY_NAME[name].items]
    assert drawn.properties[0] == name
    assert not drawn.menus


@pytest.mark.parametrize(("kind", "left"), [("SPOT", {"log", "logpsm"}), ("POINT", {"log", "logpsm"})])
def test_logarithms_are_left_out_without_a_sun(blend, room, kind, left):
    add_light(blend, kind)
    keys, drawn = offered(blend, room, "warp")
    assert {item[0] for item in room("options").BY_NAME["warp"].items} - set(keys) == left
    assert drawn.menus == [("CAD_SHADOW_MT_warp", "LiSPSM (generalised)")]
    assert not drawn.texts


def test_a_spot_is_not_divided_into_faces_and_a_point_not_at_all(blend, room):
    add_light(blend, "SPOT")
    assert not any(key.startswith("faces") for key in offered(blend, room, "partition")[0])
    blend.context.object.data.type = "POINT"
    assert offered(blend, room, "partition")[0] == ["none"]


def test_a_choice_made_before_is_explained_and_the_plan_says_the_same(blend, room):
    add_light(blend, "SPOT")
    blend.context.scene.cad_shadow.warp = "logpsm"
    assert any("sun" in text for text in offered(blend, room, "warp")[1].texts)


def test_the_light_asked_about_is_the_one_that_casts(blend, room):
    light_type = room("panels.settings").light_type
    props = blend.context.scene.cad_shadow
    assert light_type(blend.context) is None
    add_light(blend, "POINT")
    assert light_type(blend.context) == "POINT"
    add_light(blend, "SUN")
    assert light_type(blend.context) == "SUN"
    props.light_source, props.light = "OBJECT", blend.data.objects["Point"]
    assert light_type(blend.context) == "POINT"
    props.light_source = "DIRECTION"
    assert light_type(blend.context) == "SUN"
