"""Long views through plants, thin pipes and railings: four large maps spread over a huge depth range and the triangle-exact test;
fewer camera samples than Sharp keep big scenes quick."""

import bpy

settings = bpy.context.scene.cad_shadow

settings.warp = "lispsm-general"
settings.partition = "z-adaptive"
settings.partitions = 4
settings.map_size = 2048
settings.test = "triangle"
settings.samples = "4"
settings.fit = "samples"
