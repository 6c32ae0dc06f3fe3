"""Pictures to show: larger maps than Balanced's, thin parts found by their outlines, smoother edges of objects."""

import bpy

settings = bpy.context.scene.cad_shadow

settings.warp = "lispsm-general"
settings.partition = "z-adaptive"
settings.partitions = 4
settings.map_size = 2048
settings.test = "triangle"
settings.samples = "9"
settings.fit = "samples"
settings.outlines = True
