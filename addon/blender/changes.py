"""How often what a scene shows has changed, so that what was made of it earlier is known to be old. Not whether it looks different now."""

from __future__ import annotations

import bpy
from bpy.app.handlers import persistent

_counts: dict[int, int] = {}


def stamp_of(scene: bpy.types.Scene) -> tuple:
    """Equal as long as nothing in the scene moves, changes its shape or shading, comes or goes, and the same light is chosen."""
    props, uid = scene.cad_shadow, scene.session_uid
    light = props.light.name if props.light_source == "OBJECT" and props.light else None
    return uid, _counts.get(uid, 0), props.light_source, light, tuple(props.light_direction)


@persistent
def _note(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    """Blender calls this after each evaluation."""
    if any(_is_seen(update) for update in depsgraph.updates):
        _counts[scene.session_uid] = _counts.get(scene.session_uid, 0) + 1


def _is_seen(update: bpy.types.DepsgraphUpdate) -> bool:
    """Whether an update may change what is drawn. One of the scene itself says only that one of its settings changed; objects are said to
    change their shading whenever others come or go."""
    changed = update.id
    if isinstance(changed, bpy.types.Scene | bpy.types.Camera) or (isinstance(changed, bpy.types.Object) and changed.type == "CAMERA"):
        return False
    return update.is_updated_geometry or update.is_updated_transform or (update.is_updated_shading and isinstance(changed, bpy.types.Light))


def register() -> None:
    """Listen."""
    bpy.app.handlers.depsgraph_update_post.append(_note)


def unregister() -> None:
    """Stop listening."""
    if _note in bpy.app.handlers.depsgraph_update_post:  # else somebody has cleared the list
        bpy.app.handlers.depsgraph_update_post.remove(_note)
    _counts.clear()
