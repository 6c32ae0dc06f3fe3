"""One part seen as a whole: near and far lie close together, the fit to visible surfaces gains most; one large map draws the part once."""

import bpy

settings = bpy.context.scene.cad_shadow

settings.warp = "lispsm-general"
settings.partition = "none"
settings.map_size = 2048
settings.test = "triangle"
settings.samples = "16"
settings.fit = "samples"
