"""What objects and collections say of who sees them: `flags` of `scene/looks.py` for each instance.

Most scenes say nothing special; then no instance is asked. Animated switches are asked for wherever something animates any.
"""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np

from ...scene.looks import CATCHER, HIDDEN, HOLDOUT, NO_SHADOW
from ..animation import curves_of

SWITCHES = {"visible_camera": True, "visible_shadow": True, "is_holdout": False, "is_shadow_catcher": False}
FlagsOf = Callable[[bpy.types.DepsgraphObjectInstance], int]


def flags_reader(depsgraph: bpy.types.Depsgraph) -> FlagsOf | None:
    """What gives the flags of an instance; None where no object and no collection says anything special."""
    layer = depsgraph.view_layer
    if not (_any_switch() or _any_animated() or _any_in(layer.layer_collection)):
        return None
    layer = layer.original if getattr(layer, "original", None) else layer
    known: dict[tuple[int, int], int] = {}

    def flags(instance: bpy.types.DepsgraphObjectInstance) -> int:
        ob = instance.object
        parent = instance.parent if instance.is_instance else None
        key = ob.as_pointer(), parent.as_pointer() if parent else 0
        if key not in known:
            known[key] = _flags(ob, layer) | (_flags(parent, layer) if parent else 0)
        return known[key]

    return flags


def _flags(ob: bpy.types.Object, layer: bpy.types.ViewLayer) -> int:
    original = ob.original
    found = 0 if ob.visible_camera and not original.indirect_only_get(view_layer=layer) else HIDDEN
    found |= 0 if ob.visible_shadow else NO_SHADOW
    found |= HOLDOUT if ob.is_holdout or original.holdout_get(view_layer=layer) else 0
    return found | (CATCHER if ob.is_shadow_catcher else 0)


def _any_switch() -> bool:
    """Whether an object's own switches are anything but what new objects have; read in one call for each."""
    objects = bpy.data.objects
    values = np.empty(len(objects), dtype=bool)
    for name, usual in SWITCHES.items():
        objects.foreach_get(name, values)
        if (values != usual).any():
            return True
    return False


def any_index() -> bool:
    """Whether any object has a Pass Index."""
    values = np.empty(len(bpy.data.objects), dtype=np.int32)
    bpy.data.objects.foreach_get("pass_index", values)
    return bool(values.any())


def _any_animated() -> bool:
    """Whether an action or a driver moves such a switch."""
    paths = {curve.data_path for action in bpy.data.actions for curve in curves_of(action)}
    drivers = (curve.data_path for ob in bpy.data.objects if ob.animation_data for curve in ob.animation_data.drivers)
    return not paths.isdisjoint(SWITCHES) or any(path in SWITCHES for path in drivers)


def _any_in(collection: bpy.types.LayerCollection) -> bool:
    return collection.holdout or collection.indirect_only or any(map(_any_in, collection.children))
