"""The materials of a `CadModel` as Blender's: colours, and nodes where a picture or vertex colours multiply them."""

from __future__ import annotations

import bpy
import numpy as np

from ..images.srgb import linear_from_srgb
from ..scene.cad_model import CadImage, CadMaterial, CadModel

COLORS, UVS = "Color", "UVMap"  # the attributes of a mesh that its materials look up
MEAN_SIDE = 16


class Made:
    """The datablocks made so far, to be taken back on failure."""

    def __init__(self) -> None:
        self.blocks: list[bpy.types.ID] = []

    def add(self, kind: bpy.types.bpy_prop_collection, name: str, *args: object) -> bpy.types.ID:
        """`kind.new(name, *args)`, remembered."""
        block = kind.new(name, *args)
        self.blocks.append(block)
        return block

    def remove_all(self) -> None:
        """Remove everything made, users first."""
        bpy.data.batch_remove(reversed(self.blocks))


def mean_tints(model: CadModel) -> list[np.ndarray]:
    """(4,) for each material the mean vertex colour of the triangles that have it; white where it has no vertex colours."""
    sums = np.zeros((len(model.materials), 5))
    for mesh in model.meshes:
        if mesh.corner_colors is None:
            continue
        slots = np.zeros(len(mesh.triangles), np.int64) if mesh.triangle_slots is None else mesh.triangle_slots
        of_triangle = np.asarray(mesh.materials)[slots]
        with np.errstate(under="ignore"):
            means = mesh.corner_colors.mean(axis=1, dtype=np.float64)
        for channel in range(4):
            sums[:, channel] += np.bincount(of_triangle, means[:, channel], len(sums))
        sums[:, 4] += np.bincount(of_triangle, minlength=len(sums))
    has = [material.has_vertex_colors and sums[i, 4] > 0 for i, material in enumerate(model.materials)]
    return [sums[i, :4] / sums[i, 4] if own else np.ones(4) for i, own in enumerate(has)]


def material_of(made: Made, material: CadMaterial, tint: np.ndarray) -> bpy.types.Material:
    """The material of that name and colour, made if there is none. `tint` (4,) is the mean of what multiplies its colour on the meshes."""
    picture = None if material.image is None else _image(made, material.image)
    shown = np.array(material.base_color) * tint * (1.0 if picture is None else _mean_color(picture))
    existing = bpy.data.materials.get(material.name)
    is_plain = picture is None and not material.has_vertex_colors
    if existing is not None and is_plain and np.allclose(existing.diffuse_color, shown, atol=1e-5):
        return existing
    new = made.add(bpy.data.materials, material.name)
    new.diffuse_color = shown
    new.metallic, new.roughness = material.metallic, material.roughness
    if bpy.app.version < (5, 0, 0):
        new.use_nodes = True
    node = next((n for n in new.node_tree.nodes if n.type == "BSDF_PRINCIPLED"), None)
    if node is not None:
        _fill(new, node, material, picture, has_alpha=shown[3] < 1.0)
    return new


def _fill(new: bpy.types.Material, node: bpy.types.Node, material: CadMaterial, picture: bpy.types.Image | None, has_alpha: bool) -> None:
    """The shader's inputs; pictures and vertex colours by nodes that multiply the colour."""
    node.inputs["Base Color"].default_value = material.base_color
    node.inputs["Alpha"].default_value = material.base_color[3]
    node.inputs["Metallic"].default_value = material.metallic
    node.inputs["Roughness"].default_value = material.roughness
    if material.transmission:
        node.inputs["Transmission Weight"].default_value = material.transmission
    if any(material.emission):
        node.inputs["Emission Color"].default_value = (*material.emission, 1.0)
        node.inputs["Emission Strength"].default_value = 1.0
    tree, factors = new.node_tree, []
    if picture is not None:
        factors.append(tree.nodes.new("ShaderNodeTexImage"))
        factors[-1].image = picture
    if material.has_vertex_colors:
        factors.append(tree.nodes.new("ShaderNodeVertexColor"))
        factors[-1].layer_name = COLORS
    for place, factor in enumerate(factors):
        factor.location = (node.location.x - 500.0, node.location.y - 300.0 * place)
    colors = [factor.outputs["Color"] for factor in factors]
    if colors:
        _multiplied(tree, node.inputs["Base Color"], colors, material.base_color)
    if colors and has_alpha:
        _multiplied_alpha(tree, node.inputs["Alpha"], [factor.outputs["Alpha"] for factor in factors], material.base_color[3])


def _multiplied(tree: bpy.types.NodeTree, target: bpy.types.NodeSocket, colors: list[bpy.types.NodeSocket], factor: tuple) -> None:
    """Link the product of the colours and of a fixed one, left out where it is white."""
    product = colors[0]
    for other in (*colors[1:], *([factor] if min(factor[:3]) < 1.0 else [])):
        mix = tree.nodes.new("ShaderNodeMix")
        mix.data_type, mix.blend_type = "RGBA", "MULTIPLY"
        mix.location = (target.node.location.x - 200.0, target.node.location.y)
        mix.inputs["Factor"].default_value = 1.0
        first, second = [socket for socket in mix.inputs if socket.type == "RGBA"][:2]
        tree.links.new(product, first)
        if isinstance(other, tuple):
            second.default_value = other
        else:
            tree.links.new(other, second)
        product = next(socket for socket in mix.outputs if socket.type == "RGBA")
    tree.links.new(product, target)


def _multiplied_alpha(tree: bpy.types.NodeTree, target: bpy.types.NodeSocket, alphas: list[bpy.types.NodeSocket], factor: float) -> None:
    """The same for opacities."""
    product = alphas[0]
    for other in (*alphas[1:], *([factor] if factor < 1.0 else [])):
        multiply = tree.nodes.new("ShaderNodeMath")
        multiply.operation = "MULTIPLY"
        multiply.location = (target.node.location.x - 200.0, target.node.location.y - 200.0)
        tree.links.new(product, multiply.inputs[0])
        if isinstance(other, float):
            multiply.inputs[1].default_value = other
        else:
            tree.links.new(other, multiply.inputs[1])
        product = multiply.outputs[0]
    tree.links.new(product, target)


def _image(made: Made, image: CadImage) -> bpy.types.Image | None:
    """The picture, loaded from its file or packed into the .blend; None where Blender cannot read it."""
    if image.path is not None:
        known = {one.as_pointer() for one in bpy.data.images}
        try:
            loaded = bpy.data.images.load(image.path, check_existing=True)
        except RuntimeError:
            return None
        if loaded.as_pointer() not in known:
            made.blocks.append(loaded)
    else:
        loaded = made.add(bpy.data.images, image.name, 1, 1)
        loaded.pack(data=image.data, data_len=len(image.data))
        loaded.source = "FILE"
    return loaded if min(loaded.size) > 0 else None


def _mean_color(image: bpy.types.Image) -> np.ndarray:
    """(4,) the picture's mean, linear, of a copy that Blender makes smaller."""
    small = image.copy()
    try:
        small.scale(min(image.size[0], MEAN_SIDE), min(image.size[1], MEAN_SIDE))
        pixels = np.empty(len(small.pixels), np.float32)
        small.pixels.foreach_get(pixels)
    finally:
        bpy.data.images.remove(small)
    mean = pixels.reshape(-1, image.channels)
    rgba = np.ones((len(mean), 4))
    rgba[:, : mean.shape[1]] = mean
    if not image.is_float:
        rgba[:, :3] = linear_from_srgb(rgba[:, :3])
    return rgba.mean(axis=0)
