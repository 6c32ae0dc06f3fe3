"""As near to ray-traced shadows as this method gets, at any cost."""

import bpy

settings = bpy.context.scene.cad_shadow

settings.warp = "lispsm-general"
settings.partition = "z-adaptive"
settings.partitions = 8
settings.map_size = 4096
settings.test = "triangle"
settings.samples = "16"
settings.fit = "samples"
settings.outlines = True
