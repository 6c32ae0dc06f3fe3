"""The same small scene by this engine and by Cycles: no bounces, hard lights, one sample at the pixels' centres."""

import struct

import bpy
import numpy as np
from mathutils import Vector

SIZE = (64, 40)


def empty_scene(width=SIZE[0], height=SIZE[1]):
    """A black world, no object."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
    scene.view_settings.view_transform = "Standard"
    scene.render.dither_intensity = 0
    scene.world = bpy.data.worlds.new("World")
    background(scene, (0.0, 0.0, 0.0))
    return scene


def background(scene, color, strength=1.0):
    """A world of one colour."""
    node = emptied(scene.world).nodes.new("ShaderNodeBackground")
    node.inputs["Color"].default_value, node.inputs["Strength"].default_value = (*color, 1.0), strength
    return to_output(scene.world, node)


def emptied(owner):
    """The node tree of a material or a world, without nodes."""
    if owner.node_tree is None:
        owner.use_nodes = True
    owner.node_tree.nodes.clear()
    return owner.node_tree


def to_output(owner, node, socket="Surface"):
    """`node`'s first output as what the owner shows; gives the node."""
    kind = "ShaderNodeOutputWorld" if isinstance(owner, bpy.types.World) else "ShaderNodeOutputMaterial"
    tree = owner.node_tree
    out = next((n for n in tree.nodes if n.bl_idname == kind), None) or tree.nodes.new(kind)
    tree.links.new(node.outputs[0], out.inputs[socket])
    return node


def material(name="material"):
    """A material without nodes: for a tree to be made in."""
    made = bpy.data.materials.new(name)
    emptied(made)
    return made


def diffuse(color=(0.5, 0.3, 0.1), name="diffuse"):
    """A material of one diffuse shader."""
    made = material(name)
    node = made.node_tree.nodes.new("ShaderNodeBsdfDiffuse")
    node.inputs["Color"].default_value = (*color, 1.0)
    to_output(made, node)
    return made


def placed(data, location=(0.0, 0.0, 0.0), towards=None, name=None):
    """An object of that data in the scene; `towards`: its local Z points there."""
    ob = bpy.data.objects.new(name or data.name, data)
    ob.location = location
    if towards is not None:
        ob.rotation_euler = Vector(towards).to_track_quat("Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(ob)
    return ob


def plate(size=20.0, height=0.0, paint=None, name="plate"):
    """A square that lies flat."""
    s = size / 2.0
    data = bpy.data.meshes.new(name)
    data.from_pydata([(-s, -s, 0), (s, -s, 0), (s, s, 0), (-s, s, 0)], [], [(0, 1, 2, 3)])
    if paint is not None:
        data.materials.append(paint)
    return placed(data, (0.0, 0.0, height))


def box(size=2.0, location=(0.0, 0.0, 1.0), paint=None, name="box"):
    """A cube, every face with corners of its own."""
    s = size / 2.0
    corners = [(x, y, z) for x in (-s, s) for y in (-s, s) for z in (-s, s)]
    data = bpy.data.meshes.new(name)
    data.from_pydata(corners, [], [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
    if paint is not None:
        data.materials.append(paint)
    return placed(data, location)


def sun(towards=(1.0, -1.0, 2.0), energy=3.0):
    """A sun without an angle."""
    data = bpy.data.lights.new("Sun", "SUN")
    data.energy, data.angle = energy, 0.0
    return placed(data, towards=towards)


def lamp(kind, location, energy=1000.0, target=(0.0, 0.0, 0.0), **more):
    """A lamp that points at `target`; without a size unless `more` says so."""
    data = bpy.data.lights.new(kind, kind)
    data.energy = energy
    for key, value in (({} if kind == "AREA" else {"shadow_soft_size": 0.0}) | more).items():
        setattr(data, key, value)
    return placed(data, location, Vector(location) - Vector(target))


def camera(location=(7.0, -7.0, 5.0), target=(0.0, 0.0, 0.0), **more):
    """The scene's camera."""
    data = bpy.data.cameras.new("Camera")
    for key, value in more.items():
        setattr(data, key, value)
    ob = placed(data, location, Vector(location) - Vector(target))
    bpy.context.scene.camera = ob
    return ob


def standard_scene(paint=None):
    """A box on a plate under a sun."""
    scene = empty_scene()
    worn = paint() if paint else None
    plate(paint=worn)
    box(paint=worn)
    sun()
    camera()
    return scene


def ours(scene, **options):
    """(picture (h, w, 4), warnings) of this engine, through its API."""
    import importlib

    api = importlib.import_module("bl_ext.user_default.cad_shadow_preview.addon.api")
    result = api.preview(scene, **({"samples": 1} | options))
    return result.combined, result.report["warnings"]


def as_judge(scene, samples=1):
    """Cycles: no bounces, one sample at pixel centres; more where it throws dice, which it does for what is see-through."""
    scene.render.engine = "CYCLES"
    asked = scene.cycles
    asked.device, asked.samples, asked.use_adaptive_sampling, asked.use_denoising = "CPU", samples, False, False
    asked.pixel_filter_type, asked.filter_width, asked.max_bounces, asked.transparent_max_bounces = "BOX", 0.01, 0, 16


def cycles(scene, path, samples=1):
    """(h, w, 4) of Cycles, by way of a file in the folder `path`."""
    render, image = scene.render, scene.render.image_settings
    as_judge(scene, samples)
    if hasattr(image, "media_type"):
        image.media_type = "IMAGE"
    image.file_format, image.color_depth, image.color_mode, image.exr_codec = "OPEN_EXR", "32", "RGBA", "NONE"
    render.filepath = str(path / "cycles.exr")
    bpy.ops.render.render(write_still=True)
    picture = bpy.data.images.load(render.filepath)
    picture.colorspace_settings.name = "Non-Color"
    width, height = picture.size
    values = np.empty(width * height * 4, np.float32)
    picture.pixels.foreach_get(values)
    bpy.data.images.remove(picture)
    return values.reshape(height, width, 4)[::-1]


def layer_passes(scene, engine, path):
    """({pass: (h, w, channels)}, header's text) of an F12 with that engine, the passes by the names in its multilayer file."""
    image = scene.render.image_settings
    scene.render.engine = engine
    if hasattr(image, "media_type"):
        image.media_type = "MULTI_LAYER_IMAGE"
    image.file_format, image.color_depth, image.exr_codec = "OPEN_EXR_MULTILAYER", "32", "NONE"
    scene.render.filepath = str(path / f"{engine}.exr")
    bpy.ops.render.render(write_still=True)
    data = (path / f"{engine}.exr").read_bytes()
    found = {}
    for name, plane in exr_planes(data).items():
        whole, _, channel = name.rpartition(".")
        found.setdefault(whole.split(".")[-1], {})[channel] = plane
    order = "RGBAXYZVW"
    return {
        name: np.stack([planes[c] for c in sorted(planes, key=lambda c: order.index(c.upper()))], axis=-1) for name, planes in found.items()
    }, data


def exr_planes(data):
    """{channel: (h, w) float32} of an uncompressed scan-line EXR, of all its parts."""
    is_multipart, at = bool(data[5] & 0x10), 8

    def text(at):
        end = data.index(0, at)
        return data[at:end].decode(), end + 1

    parts = []
    while data[at]:
        attributes = {}
        while data[at]:
            name, at = text(at)
            _, at = text(at)
            size = struct.unpack_from("<i", data, at)[0]
            attributes[name] = data[at + 4 : at + 4 + size]
            at += 4 + size
        at += 1
        parts.append(attributes)
        if not is_multipart:
            break
    at += is_multipart
    out = {}
    for attributes in parts:
        x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
        channels, i, table = [], 0, attributes["channels"]
        while table[i]:
            end = table.index(0, i)
            channels.append((table[i:end].decode(), "<u4" if struct.unpack_from("<i", table, end + 1)[0] == 0 else "<f4"))
            i = end + 17
        prefix = attributes["name"].split(b"\0")[0].decode() + "." if is_multipart else ""
        height, width = y1 - y0 + 1, x1 - x0 + 1
        offsets = struct.unpack_from(f"<{height}Q", data, at)
        at += 8 * height
        planes = {name: np.empty((height, width), np.float32) for name, _ in channels}
        for offset in offsets:
            row = offset + 4 * is_multipart
            y, row = struct.unpack_from("<i", data, row)[0] - y0, row + 8
            for name, kind in channels:
                planes[name][y] = np.frombuffer(data, kind, width, row)
                row += 4 * width
        out |= {(name if "." in name else prefix + name): plane for name, plane in planes.items()}
    return out


def apart(scene, path, **options):
    """(95th percentile, median) of the difference of our picture from Cycles', over the brightest tenth's brightness."""
    mine, _ = ours(scene, **options)
    theirs = cycles(scene, path)
    scale = max(float(np.percentile(theirs[..., :3], 90)), 1e-3)
    off = np.abs(mine - theirs)[..., :3].max(axis=-1) / scale
    return float(np.percentile(off, 95)), float(np.median(off))
