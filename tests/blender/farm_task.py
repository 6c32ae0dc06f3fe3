"""What a farm's task does with the bpy module: `blender -b FILE --render-output OUTPUT --render-format PNG --render-frame A..B`.

Arguments: FILE OUTPUT A B. The extension lies in BLENDER_USER_RESOURCES.
"""

import sys

import bpy  # first: addon_utils exists once it is loaded  # isort: skip
import addon_utils

addon_utils.enable("bl_ext.user_default.cad_shadow_preview", default_set=True)
file, output, first, last = sys.argv[1:]
bpy.ops.wm.open_mainfile(filepath=file)
scene = bpy.context.scene
scene.frame_start, scene.frame_end = int(first), int(last)
scene.render.filepath = output
scene.render.image_settings.file_format = "PNG"
bpy.ops.render.render(animation=True)
