"""Near and far of a 3D viewport for what was imported, and back again to what they were for what needs no other.

A near distance that was drawn in for a part of some millimetres costs a plant its depth: surfaces there begin to flicker.
"""

from __future__ import annotations

import bpy

KEPT = "cad_shadow_clip"  # on a screen: what a distance was before it was moved, by its name and the value it was moved to
NEAR_OF_SIZE, FAR_OF_SIZE = 5e-3, 20.0
NEAREST_M = 1e-6  # what Blender takes


def fit(screen: bpy.types.Screen, space: bpy.types.SpaceView3D, size_m: float) -> None:
    """Let the viewport see something of that size which it is about to be moved to.

    Distances are moved only as far as needed, from what they were before they were first moved; one that the user has set since counts
    as such.
    """
    start, end = (_before(screen, space, name) for name in ("clip_start", "clip_end"))
    _move(screen, space, "clip_start", start, min(start, max(NEAR_OF_SIZE * size_m, NEAREST_M)))
    _move(screen, space, "clip_end", end, max(end, FAR_OF_SIZE * size_m))


def _key(space: bpy.types.SpaceView3D, name: str) -> str:
    return f"{name} {getattr(space, name):.9g}"


def _before(screen: bpy.types.Screen, space: bpy.types.SpaceView3D, name: str) -> float:
    return screen.get(KEPT, {}).get(_key(space, name), getattr(space, name))


def _move(screen: bpy.types.Screen, space: bpy.types.SpaceView3D, name: str, before: float, wanted: float) -> None:
    setattr(space, name, wanted)
    if wanted != before:
        screen[KEPT] = {**dict(screen.get(KEPT, {})), _key(space, name): before}
