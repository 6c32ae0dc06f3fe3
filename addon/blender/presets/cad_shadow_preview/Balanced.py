"""The defaults: four slices serve views along a scene and views at an object, the exact test places every edge."""

import bpy

settings = bpy.context.scene.cad_shadow

settings.warp = "lispsm-general"
settings.partition = "z-adaptive"
settings.partitions = 4
settings.map_size = 1024
settings.samples = "4"
settings.fit = "samples"
settings.test = "triangle"
