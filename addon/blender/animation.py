"""Blender's animation data, whichever version keeps it."""

from __future__ import annotations

import bpy


def curves_of(action: bpy.types.Action) -> list[bpy.types.FCurve]:
    """An action's curves, also where Blender keeps them in layers."""
    if hasattr(action, "fcurves"):
        return list(action.fcurves)
    bags = (bag for layer in action.layers for strip in layer.strips for bag in getattr(strip, "channelbags", ()))
    return [curve for bag in bags for curve in bag.fcurves]
