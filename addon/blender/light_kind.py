"""Which kind of light will cast the shadows, for panels, which are drawn often and before any picture: as `sources` chooses it."""

from __future__ import annotations

import bpy
import numpy as np

from ..maths.view import Light
from .changes import stamp_of
from .snapshot.lights import choose_light, light_from_object, reaches

SAMPLED = 500  # objects that the size of a scene is judged by; a walk through all would hold up every drawing of a large one
_known: dict[tuple, str | None] = {}


def light_type(context: bpy.types.Context) -> str | None:
    """Blender's type of the light: 'SUN', 'SPOT', 'POINT' (or 'AREA' of one chosen by hand); None where a sun has to be made up."""
    props = context.scene.cad_shadow
    if props.light_source in ("DIRECTION", "VIEW"):
        return "SUN"
    if props.light_source == "OBJECT":
        return props.light.data.type if props.light else None
    stamp = _stamp(context.scene)
    if stamp not in _known:
        _known.clear()
        _known[stamp] = _automatic(context)
    return _known[stamp]


def _stamp(scene: bpy.types.Scene) -> tuple:
    lamps = tuple((data.name, data.type, data.energy) for data in bpy.data.lights)
    return (*stamp_of(scene.original or scene), len(scene.objects), lamps)


def remember(scene: bpy.types.Scene, light: Light | None) -> None:
    """What a picture has chosen by what it shows: the panels speak of that as long as the scene stays as it is."""
    _known.clear()
    _known[_stamp(scene)] = None if light is None else light.kind.upper()


def _automatic(context: bpy.types.Context) -> str | None:
    shown = [ob for ob in context.view_layer.objects if ob.visible_get()]
    found = [light_from_object(ob, np.array(ob.matrix_world), np.zeros(3))[0] for ob in shown if ob.type == "LIGHT"]
    lights = [light for light in found if light is not None]
    if lights and not any(light.kind == "sun" for light in lights):
        bounds = _bounds(shown)
        lights = lights if bounds is None else [light for light in lights if reaches(light, bounds)]
    light = choose_light(lights)
    return None if light is None else light.kind.upper()


def _bounds(shown: list[bpy.types.Object]) -> np.ndarray | None:
    """(2, 3) about the bounds of what is shown, by a sample spread over it; None when there is nothing."""
    solid = [(ob.matrix_world, ob.bound_box) for ob in _spread(shown) if ob.type != "EMPTY" and ob.data is not None and _is_solid(ob)]
    for empty in _spread([ob for ob in shown if ob.type == "EMPTY" and ob.instance_collection]):
        inner = _spread([ob for ob in empty.instance_collection.all_objects if _is_solid(ob)])
        solid += [(empty.matrix_world @ ob.matrix_world, ob.bound_box) for ob in inner]
    if not solid:
        return None
    corners = np.concatenate([_placed(np.array(matrix), np.array(box)) for matrix, box in solid])
    return np.stack([corners.min(axis=0), corners.max(axis=0)])


def _is_solid(ob: bpy.types.Object) -> bool:
    return ob.type in ("MESH", "CURVE", "SURFACE", "FONT", "META", "CURVES")


def _spread(objects: list[bpy.types.Object]) -> list[bpy.types.Object]:
    return objects[:: -(-len(objects) // SAMPLED) or 1]


def _placed(matrix: np.ndarray, box: np.ndarray) -> np.ndarray:
    return box @ matrix[:3, :3].T + matrix[:3, 3]
