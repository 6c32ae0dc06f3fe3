"""The section planes of a scene, `scene.cad_shadow.section_1` to `section_3`: an object's local XY plane, or a point and a normal."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, FloatVectorProperty, PointerProperty

from .redraw import on_change

NAMES = ("section_1", "section_2", "section_3")


class CadShadowSection(bpy.types.PropertyGroup):
    """One section plane. What lies on the side of its normal is cut away."""

    use: BoolProperty(name="Section", description="Cut the model open along this plane", options=set(), update=on_change)
    object: PointerProperty(
        name="Object",
        description="The plane lies in this object and its Z axis points to what is cut away: move and turn it, an empty for example, "
        "to move the section. Without one the numbers below count",
        type=bpy.types.Object,
        update=on_change,
    )
    point: FloatVectorProperty(name="Point", description="A point in the plane", subtype="TRANSLATION", size=3, update=on_change)
    normal: FloatVectorProperty(
        name="Normal", description="Points to the side that is cut away", subtype="XYZ", size=3, default=(0.0, 0.0, 1.0), update=on_change
    )
    flip: BoolProperty(name="Flip", description="Cut away the other side", options=set(), update=on_change)


def planes_of(props: bpy.types.PropertyGroup) -> tuple[float, ...]:
    """Six numbers for each plane in use: a point and a normal, in the world."""
    return tuple(number for name in NAMES for number in _plane(getattr(props, name)))


def _plane(section: CadShadowSection) -> tuple[float, ...]:
    if not section.use:
        return ()
    matrix = section.object.matrix_world if section.object is not None else None
    point = tuple(section.point) if matrix is None else tuple(matrix.translation)
    normal = tuple(section.normal) if matrix is None else tuple(matrix.col[2].xyz)
    sign = -1.0 if section.flip else 1.0
    return (*map(float, point), *(sign * float(n) for n in normal))


def register() -> None:
    """Before the settings, which hold such planes."""
    bpy.utils.register_class(CadShadowSection)


def unregister() -> None:
    """After the settings are gone."""
    bpy.utils.unregister_class(CadShadowSection)
