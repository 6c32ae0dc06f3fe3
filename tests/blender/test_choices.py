"""What means nothing under the light that is there cannot be chosen in the panels, and a choice made before is explained."""

import numpy as np
import pytest


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
    settings = room("blender.panels.settings")
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
    assert keys == [item[0] for item in room("settings.options").BY_NAME[name].items]
    assert drawn.properties[0] == name
    assert not drawn.menus


@pytest.mark.parametrize(("kind", "left"), [("SPOT", {"log", "logpsm"}), ("POINT", {"log", "logpsm"})])
def test_logarithms_are_left_out_without_a_sun(blend, room, kind, left):
    add_light(blend, kind)
    keys, drawn = offered(blend, room, "warp")
    assert {item[0] for item in room("settings.options").BY_NAME["warp"].items} - set(keys) == left
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
    light_type = room("blender.panels.settings").light_type
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


def far_box(blend, half):
    """A box of that half size around the origin."""
    blend.ops.mesh.primitive_cube_add(size=2 * half)


@pytest.mark.parametrize("kind", ["POINT", "SPOT"])
def test_panels_speak_of_the_light_that_is_used_and_not_of_one_that_hardly_reaches_the_model(blend, room, kind):
    """Blender's start-up lamp, after a plant was imported: a sun takes its place."""
    add_light(blend, kind)
    blend.context.object.data.energy, light_type = 1000.0, room("blender.panels.settings").light_type
    far_box(blend, 1.0)
    assert light_type(blend.context) == kind and offered(blend, room, "partition")[1].menus
    far_box(blend, 100.0)
    assert light_type(blend.context) is None
    keys, drawn = offered(blend, room, "partition")
    assert keys == [item[0] for item in room("settings.options").BY_NAME["partition"].items] and not drawn.texts
    blend.context.object.scale = (0.01, 0.01, 0.01)
    blend.context.view_layer.update()
    assert light_type(blend.context) == kind


def test_panels_and_pictures_choose_the_same_kind_of_light(cube_scene, blend, room):
    """Over lamps, models and choices."""
    props, rng, seen = cube_scene.cad_shadow, np.random.default_rng(3), set()
    blend.data.objects.remove(blend.data.objects["Sun"])
    lamps = {}
    for kind in ("POINT", "SPOT", "AREA", "SUN"):
        blend.ops.object.light_add(type=kind)
        lamps[kind] = blend.context.object
    for source in ("AUTOMATIC", "AUTOMATIC", "AUTOMATIC", "AUTOMATIC", "VIEW", "DIRECTION", "OBJECT"):
        for _ in range(6):
            props.light_source, props.light = source, lamps["POINT"]
            cube_scene.objects["Cube"].location.x = 10.0 ** rng.uniform(0, 3)
            for kind, lamp in lamps.items():
                lamp.hide_viewport = bool(rng.random() < (0.8 if kind == "SUN" else 0.4)) and source != "OBJECT"
                lamp.hide_render = bool(rng.random() < 0.5)  # the window shows it all the same
                lamp.location = rng.uniform(-3, 3, 3)
                lamp.data.energy = 10.0 ** rng.uniform(1, 5)
            blend.context.view_layer.update()
            used = room("blender.sources").ViewReading().job(blend.context).light
            shown = room("blender.panels.settings").light_type(blend.context)
            assert used.kind.upper() == (shown or "SUN")
            assert (shown is None) == (used.name == "default sun" and source == "AUTOMATIC")
            seen.add((source, used.kind, shown))
    assert len(seen) >= 6


def test_a_large_scene_is_judged_by_a_sample(blend, room):
    kinds = room("blender.light_kind")
    mesh = blend.data.meshes.new("point")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    for i in range(4 * kinds.SAMPLED):
        ob = blend.data.objects.new("part", mesh)
        ob.location.x = 0.1 * i
        blend.context.collection.objects.link(ob)
    blend.context.view_layer.update()
    bounds = kinds._bounds(list(blend.context.view_layer.objects))
    assert np.allclose(bounds, [[0, 0, 0], [0.4 * kinds.SAMPLED, 1, 0]], atol=1.5)
    assert len(kinds._spread(list(blend.data.objects))) == kinds.SAMPLED
