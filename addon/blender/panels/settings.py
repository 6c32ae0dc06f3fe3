"""The settings' panels, each shown twice: in the sidebar of the 3D viewport and, with this engine active, in the render properties."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import bpy

from ...settings.combinations import applies, unsuited
from ...settings.options import BY_NAME
from ..light_kind import light_type
from ..properties import seam_count
from ..section_properties import NAMES
from ..session import is_last_current, last, warnings
from .chosen import is_live, look_label, preset_label
from .compatible import ENGINE
from .impostors import CAPTURE, LIFE, draw_impostor_export, draw_impostors
from .placing import draw_camera, draw_sun, draw_sun_hours, draw_sun_study
from .words import paragraph, sharpness

TAB = "CAD Shadow"
MOST_SAID = 4
"""Warnings of the last picture that the Preview panel has room for."""


def draw_option(layout: bpy.types.UILayout, props: bpy.types.PropertyGroup, name: str) -> None:
    """One setting: nothing when it does not apply, a switch beside it when it is optional."""
    if not applies(name, props):
        return
    option = BY_NAME[name]
    if option.kind == "numbers":
        layout.prop(props, "use_" + name)
        column = layout.column(align=True)
        column.active = getattr(props, "use_" + name)
        for i in range(seam_count(props)):
            column.prop(props, name, index=i, text=f"{option.label} {i + 1}")
    elif option.is_optional:
        row = layout.row(heading=option.label)
        row.prop(props, "use_" + name, text="")
        value = row.row()
        value.active = getattr(props, "use_" + name)
        value.prop(props, name, text="")
    else:
        layout.prop(props, name)


def draw_choice(*names: str) -> Callable[[bpy.types.Panel, bpy.types.Context], None]:
    """Like `draw_options`, but of the first only what means something under this light can be chosen; a reason where that is not so now."""

    def draw(self: bpy.types.Panel, context: bpy.types.Context) -> None:
        props, light = context.scene.cad_shadow, light_type(context)
        option = BY_NAME[names[0]]
        if not any(unsuited(option.name, item[0], light) for item in option.items):
            draw_options(*names)(self, context)
            return
        self.layout.menu(
            f"CAD_SHADOW_MT_{option.name}", text=next(label for key, label, _ in option.items if key == getattr(props, option.name))
        )
        draw_options(*names[1:])(self, context)
        reason = unsuited(option.name, getattr(props, option.name), light)
        if reason:
            paragraph(self.layout, context, reason, "INFO")

    return draw


def _draw_menu(name: str) -> Callable[[bpy.types.Menu, bpy.types.Context], None]:
    def draw(self: bpy.types.Menu, context: bpy.types.Context) -> None:
        light = light_type(context)
        for key, _, _ in BY_NAME[name].items:
            if unsuited(name, key, light) is None:
                self.layout.prop_enum(context.scene.cad_shadow, name, key)

    return draw


def _menu(name: str) -> type[bpy.types.Menu]:
    """The choices of an option that mean something under the present light."""
    option, idname = BY_NAME[name], f"CAD_SHADOW_MT_{name}"
    return type(
        idname, (bpy.types.Menu,), {"__doc__": option.text, "bl_idname": idname, "bl_label": option.label, "draw": _draw_menu(name)}
    )


def draw_options(*names: str) -> Callable[[bpy.types.Panel, bpy.types.Context], None]:
    """A panel's draw function that lists these settings."""

    def draw(self: bpy.types.Panel, context: bpy.types.Context) -> None:
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        for name in names:
            draw_option(self.layout, context.scene.cad_shadow, name)

    return draw


def draw_preview(self: bpy.types.Panel, context: bpy.types.Context) -> None:
    """What a first picture needs: the buttons, the look, and how sharp shadows are to be."""
    layout = self.layout
    column = layout.column(align=True)
    column.scale_y = 1.6
    column.operator("cad_shadow.preview", text="Preview", icon="RENDER_STILL")
    column.operator("cad_shadow.live_view", icon="SHADING_RENDERED", depress=is_live(context))
    choice_row(layout, "Look").menu("CAD_SHADOW_MT_looks", text=look_label(context.scene.cad_shadow))
    choice_row(layout, "Quality").popover("CAD_SHADOW_PT_presets", text=preset_label(context.scene.cad_shadow))
    outcome = last()
    sharp = sharpness(outcome.report["measured"]) if outcome is not None and is_last_current(context.scene) else None
    if sharp:
        paragraph(layout, context, sharp, "INFO")
    said = warnings()
    for line in said[:MOST_SAID]:
        paragraph(layout, context, line, "ERROR")
    if len(said) > MOST_SAID:
        paragraph(layout, context, f"and {len(said) - MOST_SAID} more, listed under Quality after Preview or Analyse", "BLANK1")


def choice_row(layout: bpy.types.UILayout, label: str) -> bpy.types.UILayout:
    """A row with a label where properties have theirs."""
    split = layout.split(factor=0.4)
    left = split.row()
    left.alignment = "RIGHT"
    left.label(text=label)
    return split.row()


def draw_tools(self: bpy.types.Panel, context: bpy.types.Context) -> None:
    """What measures and explains pictures."""
    layout = self.layout
    draw_options("display")(self, context)
    layout.prop(context.window_manager, "cad_shadow_overlay")
    layout.operator("cad_shadow.analyse", icon="GRAPH")
    layout.operator("cad_shadow.compare", icon="IMAGE_ALPHA")
    layout.operator("cad_shadow.light_view", icon="LIGHT_SUN")


def draw_section(self: bpy.types.Panel, context: bpy.types.Context) -> None:
    """The section planes, and how cuts look."""
    layout, props = self.layout, context.scene.cad_shadow
    layout.use_property_split, layout.use_property_decorate = True, False
    layout.operator("cad_shadow.add_section", icon="EMPTY_SINGLE_ARROW")
    for i, name in enumerate(NAMES):
        section = getattr(props, name)
        layout.prop(section, "use", text=f"Plane {i + 1}")
        if section.use:
            column = layout.column()
            column.prop(section, "object")
            if section.object is None:
                column.prop(section, "point")
                column.prop(section, "normal")
            column.prop(section, "flip")
    draw_options("section_caps", "section_color", "section_whole")(self, context)


def draw_light(self: bpy.types.Panel, context: bpy.types.Context) -> None:
    """Which light casts the shadows."""
    layout, props = self.layout, context.scene.cad_shadow
    layout.use_property_split, layout.use_property_decorate = True, False
    layout.prop(props, "light_source")
    if props.light_source == "OBJECT":
        layout.prop(props, "light")
    elif props.light_source == "DIRECTION":
        column = layout.column(align=True)
        column.prop(props, "light_azimuth")
        column.prop(props, "light_elevation")
    elif props.light_source == "AUTOMATIC":
        draw_option(layout, props, "lights")
    for name in ("light_strength", "light_samples", "softness", "sun_angle"):
        draw_option(layout, props, name)


def draw_detail(self: bpy.types.Panel, context: bpy.types.Context) -> None:
    """How many samples and texels there are, and how large a pixel of the live view is."""
    draw_options("samples", "smoothing", "map_size")(self, context)
    self.layout.prop(context.scene.render, "preview_pixel_size", text="Live View Pixel")


def draw_nothing(_self: bpy.types.Panel, _context: bpy.types.Context) -> None:
    """A section that has only the buttons of its operators."""


@dataclass(frozen=True)
class Section:
    """One panel: `key` names its class, `parent` the key of the panel it sits in."""

    key: str
    label: str
    draw: Callable
    parent: str = ""
    closed: bool = False


SECTIONS = (
    Section("preview", "Preview", draw_preview),
    Section("light", "Light", draw_light),
    Section("sun", "Sun by Place and Time", draw_sun, "light", True),
    Section("sun_study", "Sun over a Day", draw_sun_study, "sun", True),
    Section("sun_hours", "Sun Hours", draw_sun_hours, "sun", True),
    Section(
        "ambient",
        "Colors and Ambient Light",
        draw_options(
            "use_object_colors", "clay", "background", "exposure", "own_sun", "ambient_sky", "ambient_ground", "sky", "sky_samples"
        ),
        closed=True,
    ),
    Section("edges", "Edges", draw_options("edges", "edge_color", "edge_strength", "edge_angle"), closed=True),
    Section("ground", "Ground", draw_options("ground", "ground_height", "ground_strength"), closed=True),
    Section("section", "Section", draw_section, closed=True),
    Section("camera", "Camera", draw_camera, closed=True),
    Section("detail", "Sharpness of Shadows", draw_detail, closed=True),
    Section("warp", "Detail Near and Far", draw_choice("warp"), "detail", True),
    Section("warp_expert", "By Hand", draw_options("eta", "warp_parameter", "pseudo_near", "convergence", "log_bend"), "warp", True),
    Section("partition", "Parts of the View", draw_choice("partition", "partitions", "cut", "split_weight", "alpha"), "detail", True),
    Section("map", "Test and Softness", draw_options("fit", "test", "pcf", "filter_unit", "filter_width", "depths"), "detail", True),
    Section(
        "map_expert",
        "Stray Shadows",
        draw_options("bias_strategy", "bias", "epsilon", "epsilon_far", "id_per_material", "outlines", "casters", "caster_error", "margin"),
        "detail",
        True,
    ),
    Section("impostors", "Impostors", draw_impostors, closed=True),
    Section("impostors_capture", "Capture", draw_options(*CAPTURE), "impostors", True),
    Section("impostors_life", "Life Cycle", draw_options(*LIFE), "impostors", True),
    Section("impostors_keep", "Keep", draw_impostor_export, "impostors", True),
    Section("tools", "Measure and Explain", draw_tools, closed=True),
    Section("export", "Export", draw_nothing, closed=True),
)
ORDER_OF_QUALITY = 2 * [section.key for section in SECTIONS].index("impostors") - 1  # the panels of quality.py, advice.py


def _panel(section: Section, place: str, **members: object) -> type[bpy.types.Panel]:
    name = f"CAD_SHADOW_PT_{place}_{section.key}"
    if section.parent:
        members["bl_parent_id"] = f"CAD_SHADOW_PT_{place}_{section.parent}"
    options = {"DEFAULT_CLOSED"} if section.closed else set()
    order = 2 * SECTIONS.index(section)
    return type(
        name,
        (bpy.types.Panel,),
        {
            "__doc__": f"{section.label} of the CAD shadow preview.",
            "bl_idname": name,
            "bl_label": section.label,
            "bl_options": options,
            "bl_order": order,
            "draw": section.draw,
            **members,
        },
    )


def _is_our_engine(cls: type, context: bpy.types.Context) -> bool:
    return context.engine == ENGINE


def sidebar_panel(section: Section) -> type[bpy.types.Panel]:
    """The section as a panel of the 3D viewport's sidebar."""
    return _panel(section, "sidebar", bl_space_type="VIEW_3D", bl_region_type="UI", bl_category=TAB)


def render_panel(section: Section) -> type[bpy.types.Panel]:
    """The section as a panel of the render properties."""
    return _panel(
        section,
        "render",
        bl_space_type="PROPERTIES",
        bl_region_type="WINDOW",
        bl_context="render",
        COMPAT_ENGINES={ENGINE},
        poll=classmethod(_is_our_engine),
    )


MENUS = tuple(_menu(name) for name in ("warp", "partition"))
PANELS = {(make, section): make(section) for make in (sidebar_panel, render_panel) for section in SECTIONS}
CLASSES = MENUS + tuple(PANELS.values())


def panels_of(section: Section) -> list[type[bpy.types.Panel]]:
    """The panels that show a section."""
    return [panel for (_, shown), panel in PANELS.items() if shown is section]


def register() -> None:
    """Show the panels."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    """Remove the panels."""
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
