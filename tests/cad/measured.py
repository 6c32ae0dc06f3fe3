"""What the tests ask of a model that was read: areas, colours, places."""

import numpy as np


def world_triangles(model, part):
    """(T, 3, 3) float64 the corners of a part's triangles in the world."""
    matrix = model.world_from_part()[part]
    mesh = model.meshes[model.parts[part].mesh]
    return (mesh.positions.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3])[mesh.triangles]


def area(model):
    """The area of all parts, m²."""
    total = 0.0
    for index, part in enumerate(model.parts):
        if part.mesh >= 0:
            p = world_triangles(model, index)
            total += float(np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1).sum()) / 2.0
    return total


def colors(model, part):
    """(T, 3, 4) what the corners of a part's triangles are coloured: the material's colour times the vertices'; grey without either."""
    mesh = model.meshes[model.parts[part].mesh]
    if not mesh.materials:
        return np.broadcast_to(np.array([0.8, 0.8, 0.8, 1.0]), (len(mesh.triangles), 3, 4))
    slots = np.zeros(len(mesh.triangles), int) if mesh.triangle_slots is None else mesh.triangle_slots
    materials = [model.materials[i] for i in mesh.materials]
    base = np.array([m.base_color for m in materials])[slots][:, None, :]
    varied = np.array([m.has_vertex_colors for m in materials])[slots][:, None, None]
    own = np.ones((len(mesh.triangles), 3, 4)) if mesh.corner_colors is None else mesh.corner_colors.astype(np.float64)
    return base * np.where(varied, own, 1.0)


def color_of(model, name):
    """(4,) the one colour of the first part of that name, all of whose corners have it."""
    part = [p.name for p in model.parts].index(name)
    own = colors(model, part)
    assert np.ptp(own.reshape(-1, 4), axis=0).max() < 1e-6
    return own[0, 0]


def names(model):
    """The names of the parts that show a mesh."""
    return [part.name for part in model.parts if part.mesh >= 0]
