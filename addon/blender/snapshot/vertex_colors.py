"""A mesh's colour attributes: their mean, and their value at each corner."""

from __future__ import annotations

import bpy
import numpy as np

NUMBERS = {
    "FLOAT_COLOR": ("color", 4),
    "BYTE_COLOR": ("color", 4),
    "FLOAT_VECTOR": ("vector", 3),
    "FLOAT": ("value", 1),
    "INT": ("value", 1),
    "BOOLEAN": ("value", 1),
}


def mean_attribute(ob: bpy.types.Object, name: str) -> np.ndarray:
    """(4,) the mean of an attribute of an evaluated object's mesh over all it is given for; black without it, as in Cycles.

    The empty name is the active colour attribute.
    """
    mesh = ob.data
    if not isinstance(mesh, bpy.types.Mesh):
        return np.zeros(4)
    attribute = mesh.attributes.get(name) if name else mesh.color_attributes.active_color
    if attribute is None or attribute.data_type not in NUMBERS or not len(attribute.data):
        return np.zeros(4)
    field, width = NUMBERS[attribute.data_type]
    flat = np.empty(len(attribute.data) * width, np.float32)
    attribute.data.foreach_get(field, flat)
    mean = np.nan_to_num(flat).reshape(-1, width).mean(axis=0, dtype=np.float64)
    return np.array([*(mean if width > 1 else np.repeat(mean, 3)), 1.0][:4])


def corner_attribute(mesh: bpy.types.Mesh, name: str, vertex: np.ndarray) -> np.ndarray | None:
    """(C, 3) the value of an attribute at each corner, `vertex` (C,) its vertex; None where there is none of points or corners."""
    attribute = mesh.attributes.get(name) if name else mesh.color_attributes.active_color
    if attribute is None or attribute.data_type not in NUMBERS or attribute.domain not in ("POINT", "CORNER"):
        return None
    field, width = NUMBERS[attribute.data_type]
    flat = np.empty(len(attribute.data) * width, np.float32)
    attribute.data.foreach_get(field, flat)
    values = np.nan_to_num(flat).reshape(-1, width)
    values = np.repeat(values, 3, axis=1) if width == 1 else values[:, :3]
    return values[vertex] if attribute.domain == "POINT" else values
