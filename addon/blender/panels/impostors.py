"""Impostors in the sidebar: the list of what is marked with its state, what can be done with it, and its settings."""

from __future__ import annotations

from math import inf

import bpy

from ...studies.impostors.states import STATES, MarkState, states
from .. import session
from ..impostors.marks import INDEX, ROWS, active_mark, all_marked, has_surface, holder_of
from ..snapshot import IMPOSTOR_PROPERTY
from .compatible import ENGINE
from .words import number, paragraph

MIB = 1 << 20
CAPTURE = (
    "impostor_projection",
    "impostor_back",
    "impostor_fill",
    "impostor_texels",
    "impostor_max_texels",
    "impostor_views",
    "impostor_directions",
    "impostor_casters",
    "impostor_memory",
    "impostor_captures",
)
LIFE = (
    "impostor_warp",
    "impostor_predictor",
    "impostor_limit",
    "impostor_tilt",
    "impostor_sprite",
    "impostor_ahead",
    "impostor_fade",
    "impostor_break_even",
    "impostor_fresh",
)
ICONS = {"sprite": "IMAGE_DATA", "warp": "MOD_WARP", "regenerated": "FILE_REFRESH", "geometry": "MESH_DATA", "hidden": "HIDE_ON"}
COLUMNS = (("Name", "NONE", 0.56), ("Error", "NONE", 0.42), ("", "TIME", 0.42), ("MiB", "NONE", 1.0))
"""The list's columns, heading and icon; each takes its share of what those before it leave. The error stands there in per cent of its
limit, the age, below a clock, in pictures."""


_known: list[tuple[tuple[object, ...], dict[tuple[str, int], MarkState]]] = []


def columns(layout: bpy.types.UILayout) -> list[bpy.types.UILayout]:
    """A row's cells."""
    cells, rest = [], layout
    for _, _, share in COLUMNS[:-1]:
        rest = rest.split(factor=share, align=True)
        cells.append(rest.row(align=True))
    return [*cells, rest.row(align=True)]


def share(state: MarkState) -> str:
    """The error in per cent of its limit; '–' where nothing is captured."""
    if state.error is None or state.error == inf:
        return number(None)
    return f"{state.error / state.limit:.0%}"


def shown_states() -> dict[tuple[str, int], MarkState]:
    """The state of every mark in the last picture; reckoned once for all that draws it."""
    reports = session.impostors()
    if not _known or _known[0][0] is not reports:
        _known[:] = [(reports, states(reports))]
    return _known[0][1]


class CAD_SHADOW_UL_impostors(bpy.types.UIList):
    """What is marked as an impostor, and what became of it in the last picture"""

    bl_idname = "CAD_SHADOW_UL_impostors"

    by_error: bpy.props.BoolProperty(
        name="Sort by Error", description="The largest predicted error first, instead of by name", default=True, options=set()
    )

    def draw_item(
        self,
        context: bpy.types.Context,
        layout: bpy.types.UILayout,
        _data: object,
        item: bpy.types.PropertyGroup,
        _icon: int,
        _active_data: object,
        _active_name: str,
    ) -> None:
        """A line: state as an icon, name, error, limit, age, size."""
        holder = holder_of(item)
        state = shown_states().get((item.kind, int(item.uid)))
        cells = columns(layout)
        icon = ICONS[state.stage] if state else "QUESTION"
        if holder is None:
            cells[0].label(text=item.name, icon="ERROR")
            return
        cells[0].prop(holder, "name", text="", emboss=False, icon=icon)
        if state is None:
            return
        cells[1].alert = state.error is not None and state.error > state.limit
        cells[1].label(text=share(state))
        cells[2].label(text=str(state.age))
        cells[3].label(text=f"{state.bytes / MIB:.1f}")

    def draw_filter(self, _context: bpy.types.Context, layout: bpy.types.UILayout) -> None:
        """Below the list, when opened."""
        row = layout.row(align=True)
        row.prop(self, "filter_name", text="")
        row.prop(self, "by_error", text="", icon="SORT_DESC")

    def filter_items(self, context: bpy.types.Context, data: object, name: str) -> tuple[list[int], list[int]]:
        """Which lines are shown, and in which order."""
        rows = getattr(data, name)
        helpers = bpy.types.UI_UL_list
        shown = helpers.filter_items_by_name(self.filter_name, self.bitflag_filter_item, rows, "name") if self.filter_name else []
        if not self.by_error:
            return shown, helpers.sort_items_by_name(rows, "name")
        known = shown_states()

        def rank(place: int) -> tuple[float, str]:
            state = known.get((rows[place].kind, int(rows[place].uid)))
            error = state.error / state.limit if state and state.error is not None else -1.0
            return -error, rows[place].name

        order = [0] * len(rows)
        for new, old in enumerate(sorted(range(len(rows)), key=rank)):
            order[old] = new
        return shown, order


def draw_impostors(self: bpy.types.Panel, context: bpy.types.Context) -> None:
    """The list, the chosen one's numbers, and the buttons."""
    layout, props = self.layout, context.scene.cad_shadow
    layout.row().prop(props, "impostor_use", expand=True)
    if all_marked():
        _draw_list(layout, context)
    else:
        paragraph(layout, context, "Objects with very many triangles: draw them from a texture with depth instead", icon="INFO")
    column = layout.column(align=True)
    column.operator("cad_shadow.impostor_create", text="Make of Selected Objects", icon="ADD").target = "OBJECTS"
    column.operator("cad_shadow.impostor_create", text="Make of Active Collection", icon="OUTLINER_COLLECTION").target = "COLLECTION"
    if not all_marked():
        return
    column = layout.column(align=True)
    column.label(text="Regenerate", icon="FILE_REFRESH")
    row = column.row(align=True)
    for target, label in (("ACTIVE", "Chosen"), ("SELECTED", "Selected"), ("STALE", "Stale"), ("ALL", "All")):
        row.operator("cad_shadow.impostor_regenerate", text=label).target = target
    layout.operator("cad_shadow.impostor_report", icon="GRAPH")
    layout.prop(context.window_manager, "cad_shadow_impostor_points")


def _draw_list(layout: bpy.types.UILayout, context: bpy.types.Context) -> None:
    manager, row = context.window_manager, layout.row()
    table, side = row.column(), row.column(align=True)
    for cell, (label, icon, _) in zip(columns(table), COLUMNS, strict=True):
        cell.label(text=label, icon=icon)
    table.template_list("CAD_SHADOW_UL_impostors", "", manager, ROWS, manager, INDEX, rows=3)
    side.separator(factor=3.0)
    side.operator("cad_shadow.impostor_create", text="", icon="ADD").target = "OBJECTS"
    side.operator("cad_shadow.impostor_remove", text="", icon="REMOVE").target = "ACTIVE"
    mark = active_mark()
    state = shown_states().get((mark.kind, mark.uid)) if mark else None
    if mark is None:
        layout.label(text="Click on one for its numbers", icon="INFO")
    elif state is None:
        is_left_out = bool(session.impostors()) or session.last() is not None
        left_out = "Not in the last picture: hidden, without a surface, or marked since"
        paragraph(layout, context, left_out if is_left_out else "Not in a picture yet: press Preview", icon="INFO")
    else:
        _draw_state(layout, context, state)


def _draw_state(layout: bpy.types.UILayout, context: bpy.types.Context, state: MarkState) -> None:
    box = layout.box().column(align=True)
    paragraph(box, context, STATES[state.stage] + (f": {state.reason}" if state.reason else ""), icon=ICONS[state.stage])
    if state.bytes:
        box.label(text=f"Error {number(state.error)} of {number(state.limit)}")
        box.label(text=f"Captured {state.age} picture{'s' * (state.age != 1)} ago")
        box.label(text=f"{state.size[0]} × {state.size[1]} texels, {state.bytes / MIB:.1f} MiB")
    copies = f", {state.copies} copies" if state.copies > 1 else ""
    box.label(text=f"{state.triangles:,} triangles{copies}")


def draw_impostor_export(self: bpy.types.Panel, _context: bpy.types.Context) -> None:
    """Keeping what was captured."""
    column = self.layout.column(align=True)
    ways = (("FILES", "Export Files…", "EXPORT"), ("PLANE", "Add Planes", "MESH_PLANE"), ("PACKED", "Pack Images", "PACKAGE"))
    for to, label, icon in ways:
        column.operator("cad_shadow.impostor_export", text=label, icon=icon).to = to
    column.operator("cad_shadow.impostor_remove", text="Remove All", icon="X").target = "ALL"


def draw_object_mark(self: bpy.types.Panel, context: bpy.types.Context) -> None:
    """The mark among an object's switches of visibility, while this engine is chosen."""
    if context.engine == ENGINE and has_surface(context.object):
        self.layout.prop(context.object, IMPOSTOR_PROPERTY)


def draw_collection_mark(self: bpy.types.Panel, context: bpy.types.Context) -> None:
    """The mark among a collection's restrictions, while this engine is chosen."""
    if context.engine == ENGINE and context.collection != context.scene.collection:
        self.layout.prop(context.collection, IMPOSTOR_PROPERTY)


_MARKS = (("OBJECT_PT_visibility", draw_object_mark), ("COLLECTION_PT_collection_flags", draw_collection_mark))


def register() -> None:
    """Make the list's lines known, before the panels that show them; show the marks in Blender's own panels."""
    bpy.utils.register_class(CAD_SHADOW_UL_impostors)
    for panel, draw in _MARKS:
        getattr(bpy.types, panel).append(draw)


def unregister() -> None:
    """Take it back."""
    for panel, draw in _MARKS:
        getattr(bpy.types, panel).remove(draw)
    bpy.utils.unregister_class(CAD_SHADOW_UL_impostors)
    _known.clear()
