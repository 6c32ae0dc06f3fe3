"""Quick looks and big scenes: one map where Balanced draws four, one camera sample per pixel."""

import bpy

settings = bpy.context.scene.cad_shadow

settings.warp = "lispsm-general"
settings.partition = "none"
settings.map_size = 1024
settings.samples = "1"
settings.fit = "samples"
settings.test = "triangle"
