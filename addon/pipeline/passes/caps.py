"""The cut faces of sections, filled or hatched over the picture. Worker thread only."""

from __future__ import annotations

import moderngl

from ...scene.looks import CAP
from ...settings.stage import SectionChoice
from ..geometry.draw_list import DrawList
from ..gl.programs import Programs, set_uniforms
from .fill import bind, fill_over
from .gbuffer import GBuffer

HATCH = 8.0, 1.2, 0.6
"""Pixels between lines, their width, and how much darker they are."""


def draw_caps(
    context: moderngl.Context,
    programs: Programs,
    gbuffer: GBuffer,
    draw_list: DrawList,
    picture: moderngl.Texture,
    section: SectionChoice,
    side: int = 1,
) -> None:
    """Fill the caps that `gbuffer` shows; `side`: its pixels along one of the picture. Does nothing without caps."""
    if not (draw_list.scene.instances.flags & CAP).any():
        return
    program = programs.get("fullscreen.vert", "cap_fill.frag", INSTANCED=0, CAP=CAP)
    spacing, width, darker = HATCH
    hatch = spacing * side, width * side, darker if section.caps == "hatch" else 0.0
    set_uniforms(program, u_cap_color=section.cap_color, u_hatch=hatch)
    bind({"u_ids": gbuffer.ids})
    draw_list.bind_table()
    fill_over(context, picture, program)
