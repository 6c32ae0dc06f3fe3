"""Pictures to show: Balanced's maps, thin parts found by their outlines, and four times its samples, which is what smooths edges."""

import bpy

settings = bpy.context.scene.cad_shadow

settings.warp = "lispsm-general"
settings.partition = "z-adaptive"
settings.partitions = 4
settings.map_size = 1024
settings.test = "triangle"
settings.samples = "16"
settings.fit = "samples"
settings.outlines = True
