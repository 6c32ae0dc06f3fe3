"""What the tests of impostors in Blender share: pictures with and without impostors, how they differ, and what is selected."""

import tempfile
from pathlib import Path

import numpy as np

SIZE = (96, 64)


def without(draw, **arguments):
    return draw(impostor_use="off", **arguments)[0]


def difference(a, b):
    """Share of pixels that differ visibly, of all."""
    return float((np.abs(a.combined - b.combined).max(axis=-1) > 0.05).mean())


def select(blend, *objects):
    for ob in blend.context.view_layer.objects:
        ob.select_set(ob in objects)
    blend.context.view_layer.objects.active = objects[0] if objects else None


def small(scene):
    scene.cad_shadow.samples, scene.cad_shadow.map_size = "1", 128


def rendered(blend, scene):
    """A render's combined image (h, w, 4), row 0 at the top."""
    with tempfile.TemporaryDirectory() as folder:
        image_settings = scene.render.image_settings
        if hasattr(image_settings, "media_type"):
            image_settings.media_type = "IMAGE"
        image_settings.file_format, image_settings.color_mode, image_settings.color_depth = "OPEN_EXR", "RGBA", "32"
        scene.render.filepath = str(Path(folder, "x.exr"))
        blend.ops.render.render(write_still=True)
        image = blend.data.images.load(scene.render.filepath)
        out = np.array(image.pixels[:], np.float32).reshape(image.size[1], image.size[0], 4)[::-1]
        blend.data.images.remove(image)
    return out
