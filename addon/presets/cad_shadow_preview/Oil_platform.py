"""Long views through plants, thin pipes and railings: texels spread evenly over a huge depth range, IDs of objects against acne
on thin parts, larger maps."""

import bpy

settings = bpy.context.scene.cad_shadow

settings.warp = "lispsm-general"
settings.partition = "z-adaptive"
settings.partitions = 4
settings.map_size = 2048
settings.test = "triangle"
settings.samples = "4"
settings.fit = "samples"
