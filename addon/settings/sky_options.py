"""The options of light from the sky. No bpy."""

from __future__ import annotations

from .option import Option, choice
from .words import SKY_WORDS

SKY_OPTIONS: tuple[Option, ...] = (
    choice("sky", "sky", "kind", "Sky Light", "How ambient light arrives, and whether things stand in its way", SKY_WORDS),
    Option(
        "sky_samples",
        (("sky", "samples"),),
        "count",
        "Sky Samples",
        "Directions that light from the sky comes from, a small shadow map each: more are smoother and take longer",
        soft=(16, 512),
    ),
)
