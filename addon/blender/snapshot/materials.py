"""The one colour of a material."""

from __future__ import annotations

import bpy

DEFAULT_COLOR = (0.8, 0.8, 0.8, 1.0)
Color = tuple[float, float, float, float]


def base_color(material: bpy.types.Material | None) -> Color:
    """Linear RGBA: the unlinked colour of the shader at the active output, else the viewport's `diffuse_color`; grey without one."""
    if material is None:
        return DEFAULT_COLOR
    shader = _shader(material)
    if shader is not None:
        for name in ("Base Color", "Color"):
            socket = shader.inputs.get(name)
            if socket is not None and not socket.is_linked:
                alpha = shader.inputs.get("Alpha")
                return (*socket.default_value[:3], alpha.default_value if alpha is not None and not alpha.is_linked else 1.0)
    return tuple(material.diffuse_color)


def _shader(material: bpy.types.Material) -> bpy.types.Node | None:
    if material.node_tree is None or (bpy.app.version < (5, 0, 0) and not material.use_nodes):
        return None
    output = material.node_tree.get_output_node("ALL")
    surface = output.inputs.get("Surface") if output is not None else None
    return surface.links[0].from_node if surface is not None and surface.is_linked else None
