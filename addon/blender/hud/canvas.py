"""Drawing in pixels over a viewport: rectangles, lines, words. Blender's `gpu` and `blf`, which exist only where there is a window."""

from __future__ import annotations

from collections.abc import Sequence

import bpy

Color = tuple[float, float, float, float]
Box = tuple[float, float, float, float]

MARGIN_PX = 14
FONT_SIZE = 11.5
INK, DIM, BACK = (0.93, 0.93, 0.93, 1.0), (0.93, 0.93, 0.93, 0.35), (0.12, 0.12, 0.13, 0.98)


def free_box(area: bpy.types.Area, region: bpy.types.Region) -> Box:
    """(x, y, width, height), in the region's pixels, of the part of a viewport that no sidebar, toolbar or header covers."""
    left, bottom, right, top = region.x, region.y, region.x + region.width, region.y + region.height
    for other in area.regions:
        if other == region or other.width <= 1 or other.height <= 1 or other.type == "HUD":
            continue
        if other.alignment == "LEFT":
            left = max(left, other.x + other.width)
        elif other.alignment == "RIGHT":
            right = min(right, other.x)
        elif other.alignment == "BOTTOM":
            bottom = max(bottom, other.y + other.height)
        elif other.alignment == "TOP":
            top = min(top, other.y)
    return left - region.x, bottom - region.y, max(right - left, 0), max(top - bottom, 0)


class Canvas:
    """Takes boxes from the lower left corner of the free part of a viewport, each above the one before, and draws in them."""

    def __init__(self, box: Box, scale: float) -> None:
        import blf  # not there without a window
        import gpu

        self._blf, self._gpu = blf, gpu
        self.box, self.scale = box, scale
        self._next_y = box[1] + MARGIN_PX * scale

    def place(self, width: float, height: float) -> tuple[float, float] | None:
        """The lower left corner of the next box; None where it does not fit."""
        x, y = self.box[0] + MARGIN_PX * self.scale, self._next_y
        if x + width > self.box[0] + self.box[2] or y + height > self.box[1] + self.box[3]:
            return None
        self._next_y += height + MARGIN_PX * self.scale
        return x, y

    def rectangle(self, x: float, y: float, width: float, height: float, color: Color = BACK) -> None:
        """A filled rectangle."""
        if width > 0 and height > 0:
            self.triangles([(x, y), (x + width, y), (x + width, y + height), (x, y), (x + width, y + height), (x, y + height)], color)

    def image(self, texture: object, box: Box) -> None:
        """A texture of linear colours, opaque."""
        from gpu_extras.presets import draw_texture_2d

        draw_texture_2d(texture, box[:2], *box[2:])

    def triangles(self, points: Sequence[tuple[float, float]], color: Color) -> None:
        """Filled triangles, three points each."""
        self._draw("UNIFORM_COLOR", "TRIS", points, color)

    def line(self, points: Sequence[tuple[float, float]], color: Color, width: float = 1.0) -> None:
        """A polyline."""
        self._draw("POLYLINE_UNIFORM_COLOR", "LINE_STRIP", points, color, width)

    def segments(self, points: Sequence[tuple[float, float]], color: Color, width: float = 1.0) -> None:
        """Separate lines, two points each."""
        self._draw("POLYLINE_UNIFORM_COLOR", "LINES", points, color, width)

    def _draw(self, shader_name: str, kind: str, points: Sequence[tuple[float, float]], color: Color, width: float = 0.0) -> None:
        from gpu_extras.batch import batch_for_shader

        if len(points) < 2:
            return
        gpu = self._gpu
        shader = gpu.shader.from_builtin(shader_name)
        batch = batch_for_shader(shader, kind, {"pos": [(float(x), float(y), 0.0) for x, y in points]})
        gpu.state.blend_set("ALPHA")
        shader.bind()
        shader.uniform_float("color", color)
        if width:
            shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
            shader.uniform_float("lineWidth", width * self.scale)
        batch.draw(shader)
        gpu.state.blend_set("NONE")

    def width_of(self, text: str) -> float:
        """How wide a text will be."""
        self._blf.size(0, FONT_SIZE * self.scale)
        return self._blf.dimensions(0, text)[0]

    def word(self, text: str, x: float, y: float, anchor: str = "left", color: Color = INK) -> None:
        """A text, its lower edge at y, its 'left', 'middle' or 'right' at x."""
        blf = self._blf
        share = {"left": 0.0, "middle": 0.5, "right": 1.0}[anchor]
        blf.position(0, round(x - share * self.width_of(text)), round(y), 0)
        blf.color(0, *color)
        blf.draw(0, text)
