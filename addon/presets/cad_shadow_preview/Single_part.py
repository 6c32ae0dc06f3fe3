"""One part seen as a whole: near and far lie close together, where the fit to visible surfaces gains more than slices or warps do."""

import bpy

settings = bpy.context.scene.cad_shadow

settings.warp = "lispsm-general"
settings.partition = "none"
settings.map_size = 4096
settings.test = "triangle"
settings.samples = "9"
settings.fit = "samples"
