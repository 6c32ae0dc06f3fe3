"""Pictures to show: the triangle-exact test leaves a third to a tenth of a depth test's wrong pixels at the same map size."""

import bpy

settings = bpy.context.scene.cad_shadow

settings.warp = "lispsm-general"
settings.partition = "z-adaptive"
settings.partitions = 4
settings.map_size = 2048
settings.test = "triangle"
settings.samples = "9"
settings.fit = "samples"
