"""Pictures to show: the triangle-exact test on larger maps, about a tenth of Balanced's wrong pixels on the platform deck."""

import bpy

settings = bpy.context.scene.cad_shadow

settings.warp = "lispsm-general"
settings.partition = "z-adaptive"
settings.partitions = 4
settings.map_size = 2048
settings.test = "triangle"
settings.samples = "9"
settings.fit = "samples"
