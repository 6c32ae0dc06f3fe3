"""The table of operators: each is registered because its module is there, stands in a menu, and some in a panel."""

import importlib

import pytest

LISTED = [
    ["preview", "analyse", "compare", "light_view", "sun_study", "sun_hours", "advise", "export_report", "apply_advice"],
    ["fit_clip", "frame_camera"],
    ["place_sun", "animate_sun"],
    ["impostor_create", "impostor_remove", "impostor_regenerate", "impostor_report", "impostor_export"],
]


class Layout:
    """Notes what is drawn into a menu or panel."""

    def __init__(self):
        self.groups, self.buttons = [[]], []

    def separator(self):
        self.groups.append([])

    def operator(self, idname, icon="NONE"):
        self.groups[-1].append(idname.removeprefix("cad_shadow."))
        self.buttons.append((idname, icon))


@pytest.fixture
def operators(extension):
    return importlib.import_module(f"{extension.__name__}.operators")


def drawn(draw, blend):
    panel = type("Panel", (), {"layout": Layout()})()
    draw(panel, blend.context)
    return panel.layout


def test_the_menu_lists_the_operators_in_groups(operators, blend):
    groups = drawn(operators.CAD_SHADOW_MT_render.draw, blend).groups
    known = {name for group in LISTED for name in group}
    assert [kept for group in groups if (kept := [name for name in group if name in known])] == LISTED
    assert sum(map(len, groups)) == sum(len(row.operators) for row in operators.OPERATORS.values() if row.group)


def test_every_operator_of_every_row_is_registered_and_there_are_no_others(operators, blend):
    named = {operator.bl_idname for row in operators.OPERATORS.values() for operator in row.operators}
    assert named == {f"cad_shadow.{name}" for name in dir(blend.ops.cad_shadow) if name != "preset_add"}
    assert named >= {f"cad_shadow.{name}" for group in LISTED for name in group} | {"cad_shadow.import_cad"}


@pytest.mark.parametrize("place", ["sidebar", "render"])
@pytest.mark.parametrize(
    ("section", "button"), [("sun", ("cad_shadow.place_sun", "LIGHT_SUN")), ("export", ("cad_shadow.export_report", "EXPORT"))]
)
def test_a_section_ends_with_the_buttons_of_its_operators_while_they_are_there(operators, blend, place, section, button):
    panel = getattr(blend.types, f"CAD_SHADOW_PT_{place}_{section}")
    added = [draw for draw in panel.draw._draw_funcs if draw.__module__ == operators.__name__]
    assert [button] in [drawn(draw, blend).buttons for draw in added]


def test_an_operator_that_blender_refuses_leaves_none_of_the_others(operators, blend, monkeypatch):
    operators.unregister()
    before = set(dir(blend.ops.cad_shadow))
    row = operators.OPERATORS["sun_study"]
    nameless = type("CAD_SHADOW_OT_nameless", (blend.types.Operator,), {"bl_idname": "nameless", "bl_label": "Without a Dot"})
    monkeypatch.setitem(operators.OPERATORS, "sun_study", type(row)("sun_study", row.place, (nameless,)))
    try:
        with pytest.raises(RuntimeError, match="nameless"):
            operators.register()
        assert set(dir(blend.ops.cad_shadow)) == before
    finally:
        monkeypatch.undo()
        operators.register()
    assert "sun_study" in dir(blend.ops.cad_shadow)
