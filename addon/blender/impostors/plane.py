"""An impostor in Blender: its images as packed ones, and a plane at its place whose material shows it from where it was captured.

The plane stands still: it does not warp. It is for other engines and other files; this program's own pictures draw the impostor itself.
"""

from __future__ import annotations

from math import atan
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

from ...pipeline.impostors.baked import BakedImpostor
from ...studies.impostors.files import encoded
from ...studies.outputs import json_text, written
from .. import own_images

PREFIX = "Impostor"
COLOR, DATA = "sRGB", "Non-Color"
PACKED = {"color": ("png", COLOR), "depth": ("exr", DATA), "normal": ("exr", DATA), "object": ("exr", DATA)}


def pack_images(baked: BakedImpostor, entry: dict[str, object]) -> dict[str, bpy.types.Image]:
    """The impostor's images, packed into the open file; the colour image carries the JSON. Images of an earlier capture are replaced,
    images of the user's own that bear such a name are not."""
    images = {}
    files = encoded(baked, "png") | encoded(baked, "exr")
    for content, (ending, space) in PACKED.items():
        name = f"{PREFIX} {baked.name} {content}"
        image = own_images.make(name, 1, 1, alpha=content == "color")
        data = files[f"{content}.{ending}"]
        image.pack(data=data, data_len=len(data))
        image.source, image.filepath_raw = "FILE", f"//{name}.{ending}"
        image.colorspace_settings.name = space
        image.alpha_mode = "STRAIGHT" if content == "color" else "NONE"
        image.use_fake_user = True
        images[content] = image
    images["color"]["cad_shadow_impostor"] = json_text(entry)
    return images


def make_plane(baked: BakedImpostor, entry: dict[str, object]) -> bpy.types.Object:
    """A plane object, in no collection yet, that shows the packed colour image; its alpha is the mask."""
    image = pack_images(baked, entry)["color"]
    name, frame = f"{PREFIX} {baked.name}", baked.frame
    corners = np.array([[0, 0], [0, frame.height], [frame.width, frame.height], [frame.width, 0]], float)
    world = np.asarray(entry["world_from_plane"])
    points = (np.column_stack([corners, np.zeros(4), np.ones(4)]) @ world.T)[:, :3]
    middle = points.mean(axis=0)
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata((points - middle).tolist(), [], [(0, 1, 2, 3)])
    layer = mesh.uv_layers.new(name="UVMap")
    layer.data.foreach_set("uv", np.array([[0, 1], [0, 0], [1, 0], [1, 1]], np.float32).ravel())
    mesh.materials.append(_material(name, image))
    plane = bpy.data.objects.new(name, mesh)
    plane.location = middle
    plane["cad_shadow_impostor_of"] = baked.name
    return plane


def _material(name: str, image: bpy.types.Image) -> bpy.types.Material:
    """The image's own light where its alpha is, nothing elsewhere: the picture is lit already."""
    material = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    texture, light, glass, mix, out = (
        tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexImage", "Emission", "BsdfTransparent", "MixShader", "OutputMaterial")
    )
    texture.image, texture.interpolation, texture.extension = image, "Linear", "CLIP"
    for i, node in enumerate((texture, light, glass, mix, out)):
        node.location = (250 * i - 600, -120 * (i == 2))
    for start, end in (
        (texture.outputs["Color"], light.inputs["Color"]),
        (texture.outputs["Alpha"], mix.inputs[0]),
        (glass.outputs[0], mix.inputs[1]),
        (light.outputs[0], mix.inputs[2]),
        (mix.outputs[0], out.inputs["Surface"]),
    ):
        tree.links.new(start, end)
    if hasattr(material, "surface_render_method"):
        material.surface_render_method = "BLENDED"
    return material


def capture_camera(baked: BakedImpostor, entry: dict[str, object]) -> bpy.types.Object:
    """The camera whose render of width × height pixels is the texture."""
    frame, clip = baked.frame, np.asarray(entry["clip_from_view"])
    data = bpy.data.cameras.new(f"{PREFIX} {baked.name} camera")
    data.sensor_fit = "HORIZONTAL"
    data.shift_x, data.shift_y = clip[0, 2] / 2.0, clip[1, 2] / 2.0 * frame.height / frame.width
    camera = frame.camera()
    if frame.is_perspective:
        data.angle = 2.0 * atan(1.0 / clip[0, 0])
        data.clip_start, data.clip_end = camera.near, camera.far
    else:
        back = 1.0 + frame.depth_m
        data.type, data.ortho_scale = "ORTHO", 2.0 / clip[0, 0]
        data.shift_x = data.shift_y = 0.0
        data.clip_start, data.clip_end = 0.5 * back, 2.0 * back + frame.depth_m
    ob = bpy.data.objects.new(data.name, data)
    world = np.linalg.inv(np.asarray(entry["view_from_world"]))
    if not frame.is_perspective:
        world[:3, 3] += back * world[:3, 2]
    ob.matrix_world = Matrix(world.tolist())
    return ob


def write_plane(path: Path, baked: BakedImpostor, entry: dict[str, object]) -> Path:
    """A .blend of its own to append from: a collection with the plane and the camera that captured it. Nothing stays in the open file.

    Raises `OutputError`.
    """
    before = {kind: set(getattr(bpy.data, kind)) for kind in _KINDS}
    try:
        collection = bpy.data.collections.new(f"{PREFIX} {baked.name}")
        for ob in (make_plane(baked, entry), capture_camera(baked, entry)):
            collection.objects.link(ob)
        with written(path, _check_blend) as temporary:
            bpy.data.libraries.write(str(temporary), {collection}, compress=True)
    finally:
        bpy.data.batch_remove([one for kind in _KINDS for one in getattr(bpy.data, kind) if one not in before[kind]])
    return path


def _check_blend(path: Path) -> None:
    """Raise `ValueError` for a .blend that is not whole: Blender writes compressed ones without a word on a full disk."""
    try:
        with bpy.data.libraries.load(str(path)) as (there, _):
            is_whole = bool(there.collections)
    except OSError as error:
        raise ValueError("its end is missing") from error
    if not is_whole:
        raise ValueError("it holds no collection")


_KINDS = ("collections", "objects", "meshes", "materials", "images", "cameras")
