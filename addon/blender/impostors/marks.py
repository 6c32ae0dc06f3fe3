"""The marks "is an impostor" on objects and collections, and the list of them that the sidebar shows.

The marks are Blender properties: saved, undone and copied with what they are on. The list belongs to the window manager: it only mirrors
the marks, is made anew when they change, and is never saved.
"""

from __future__ import annotations

from fnmatch import fnmatchcase

import bpy
from bpy.app.handlers import persistent
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, IntProperty, StringProperty

from ...errors import SceneError
from ...scene.records import Mark
from .. import sources
from ..snapshot import IMPOSTOR_PROPERTY, mark_of_id, marked
from ..snapshot.instances import listed

ROWS, INDEX = "cad_shadow_impostors", "cad_shadow_impostor_index"
KINDS = (("object", "Object", "An object"), ("collection", "Collection", "All objects of a collection"))


class CadShadowImpostorRow(bpy.types.PropertyGroup):
    """A line of the list: a marked object or collection by its name and its number."""

    kind: EnumProperty(name="Kind", description="What is marked", items=KINDS, options=set())
    uid: StringProperty(name="Number", description="The number that it keeps when it is renamed", options=set())


def holder_of(row: CadShadowImpostorRow) -> bpy.types.ID | None:
    """The object or collection of a line; None when it is gone or no longer marked."""
    holders = bpy.data.objects if row.kind == "object" else bpy.data.collections
    found = holders.get(row.name)
    if found is not None and str(found.session_uid) == row.uid:
        return found
    return next((holder for holder in marked(holders) if str(holder.session_uid) == row.uid), None)  # renamed, or from a library


def all_marked() -> list[bpy.types.ID]:
    """Every marked object and collection of the file, objects first."""
    return [*marked(bpy.data.objects), *marked(bpy.data.collections)]


def is_marked(holder: bpy.types.ID) -> bool:
    """Whether this object or collection itself is marked."""
    return bool(getattr(holder, IMPOSTOR_PROPERTY))


def set_mark(holder: bpy.types.ID, wanted: bool) -> None:
    """Mark it or take the mark away."""
    setattr(holder, IMPOSTOR_PROPERTY, wanted)


def named(name: str) -> list[bpy.types.ID]:
    """The object or collection of that name, else all whose names match it as a pattern (pump*); raises `SceneError` if none does."""
    holders = [*bpy.data.objects, *bpy.data.collections]
    found = [h for h in holders if h.name == name][:1] or [h for h in holders if fnmatchcase(h.name, name)]
    if not found:
        raise SceneError(f"There is no object or collection '{name}': there are {listed([h.name for h in holders], 8) or 'none'}.")
    return found


def active_mark() -> Mark | None:
    """The mark of the line chosen in the list."""
    manager = bpy.context.window_manager
    rows, index = getattr(manager, ROWS), getattr(manager, INDEX)
    holder = holder_of(rows[index]) if 0 <= index < len(rows) else None
    return None if holder is None else mark_of_id(holder)


def refresh() -> None:
    """Make the list anew if it does not show the marks as they are."""
    manager = bpy.context.window_manager if bpy.context else None
    if manager is None or not hasattr(manager, ROWS):
        return
    rows = getattr(manager, ROWS)
    wanted = [("collection" if isinstance(h, bpy.types.Collection) else "object", str(h.session_uid), h.name) for h in all_marked()]
    if [(row.kind, row.uid, row.name) for row in rows] == wanted:
        return
    rows.clear()
    for kind, uid, name in wanted:
        row = rows.add()
        row.kind, row.uid, row.name = kind, uid, name


def _changed(_holder: bpy.types.ID, _context: bpy.types.Context) -> None:
    refresh()


@persistent
def _after_loading(*_unused: object) -> None:
    refresh()


_counts: list[tuple[int, int]] = []


def _is_out_of_date(row: CadShadowImpostorRow) -> bool:
    holder = holder_of(row)
    return holder is None or holder.name != row.name


@persistent
def _after_update(*_unused: object) -> None:
    """Objects may have come, gone or been renamed: look when their number changed or a line has lost its holder."""
    now = [(len(bpy.data.objects), len(bpy.data.collections))]
    if now != _counts or any(_is_out_of_date(row) for row in getattr(bpy.context.window_manager, ROWS, ())):
        _counts[:] = now
        refresh()


_HANDLERS = {
    "load_post": _after_loading,
    "undo_post": _after_loading,
    "redo_post": _after_loading,
    "depsgraph_update_post": _after_update,
}


def register() -> None:
    """Give objects and collections their mark, the window manager its list."""
    bpy.utils.register_class(CadShadowImpostorRow)
    for holder, what in ((bpy.types.Object, "this object"), (bpy.types.Collection, "all objects of this collection, as one,")):
        mark = BoolProperty(
            name="Impostor",
            description=f"Draw {what} from a texture with depth instead of its triangles in CAD shadow previews",
            default=False,
            options=set(),
            override={"LIBRARY_OVERRIDABLE"},
            update=_changed,
        )
        setattr(holder, IMPOSTOR_PROPERTY, mark)
    manager = bpy.types.WindowManager
    setattr(manager, ROWS, CollectionProperty(type=CadShadowImpostorRow, name="Impostors", description="What is marked as an impostor"))
    setattr(manager, INDEX, IntProperty(name="Impostor", description="The impostor chosen in the list", options=set()))
    for name, handler in _HANDLERS.items():
        getattr(bpy.app.handlers, name).append(handler)


def unregister() -> None:
    """Take all of it back; the marks stay in the file."""
    for name, handler in _HANDLERS.items():
        getattr(bpy.app.handlers, name).remove(handler)
    delattr(bpy.types.WindowManager, INDEX)
    delattr(bpy.types.WindowManager, ROWS)
    delattr(bpy.types.Collection, IMPOSTOR_PROPERTY)
    delattr(bpy.types.Object, IMPOSTOR_PROPERTY)
    bpy.utils.unregister_class(CadShadowImpostorRow)


def has_surface(ob: bpy.types.Object) -> bool:
    """Whether an impostor could be made of it: something drawn, or an empty that something hangs on or is instanced by."""
    if ob.type == "EMPTY":
        return bool(ob.children) or ob.instance_type == "COLLECTION"
    if ob.type == "MESH":
        return len(ob.data.polygons) > 0 or len(ob.modifiers) > 0
    return ob.type in sources.DRAWN_TYPES
