"""What a scene sets and this engine leaves out, one line each: the questions of `support.SUPPORT`."""

from __future__ import annotations

from collections.abc import Callable

import bpy

from ..support import SUPPORT, WARNED, row_of

Question = Callable[[bpy.types.Depsgraph, list[bpy.types.Object]], "bool | str"]


def complaints(depsgraph: bpy.types.Depsgraph, lights: list[bpy.types.Object]) -> list[str]:
    """A line for each warned row of the table that the scene sets. `lights`: the light objects that it shows."""
    lines = []
    for row in SUPPORT:
        if row.status == WARNED:
            found = QUESTIONS[row.question](depsgraph, lights)
            if found:
                lines.append(row.text.format(found))
    return lines


def _any_light(test: Callable[[bpy.types.Light], bool]) -> Question:
    return lambda depsgraph, lights: any(test(ob.data) for ob in lights)


def _passes(depsgraph: bpy.types.Depsgraph, _lights: list[bpy.types.Object]) -> str:
    layer = depsgraph.view_layer
    names = [p for p in layer.bl_rna.properties if p.identifier.startswith("use_pass_") and getattr(layer, p.identifier)]
    missing = [p.name for p in names if (row_of("ViewLayer", p.identifier) or SUPPORT[0]).status == WARNED]
    return ", ".join([*missing, *(f"AOV {aov.name}" for aov in layer.aovs)])


def _geometry(depsgraph: bpy.types.Depsgraph, _lights: list[bpy.types.Object]) -> str:
    kinds = {"CURVES": "hair curves", "POINTCLOUD": "point clouds", "VOLUME": "volumes"}
    found: dict[str, list[str]] = {}
    for ob in depsgraph.objects:
        if ob.type in kinds:
            found.setdefault(kinds[ob.type], []).append(ob.name)
        elif any(s.settings.type == "HAIR" and s.settings.render_type == "PATH" for s in ob.particle_systems):
            found.setdefault("particle hair", []).append(ob.name)
    return "; ".join(f"{kind} ({', '.join(names[:3])}{', …' * (len(names) > 3)})" for kind, names in found.items())


def _depth_of_field(depsgraph: bpy.types.Depsgraph, _lights: list[bpy.types.Object]) -> bool:
    camera = depsgraph.scene.camera
    return camera is not None and camera.type == "CAMERA" and camera.data.dof.use_dof


QUESTIONS: dict[str, Question] = {
    "not_normalized": _any_light(lambda data: not getattr(data, "normalize", True)),
    "depth_of_field": _depth_of_field,
    "passes": _passes,
    "freestyle": lambda depsgraph, lights: depsgraph.scene.render.use_freestyle and depsgraph.view_layer.use_freestyle,
    "motion_blur": lambda depsgraph, lights: depsgraph.scene.render.use_motion_blur,
    "geometry": _geometry,
}
