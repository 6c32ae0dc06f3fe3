"""What impostors and their triangles cost, for the break-even: measured where nobody says it. No GL.

A picture of several camera samples draws the triangles twice (at the pixels' centres, and for all samples at once), an impostor's pixels
for each sample; an impostor must be captured before, and a capture serves only so many pictures: a final render's that remembers nothing
serves one.
"""

from __future__ import annotations

from collections.abc import Hashable

import numpy as np

from .records import ImpostorView, Part

START_PIXEL_NS = 150.0
"""What an impostor's pixel is taken to cost until one was measured."""
FOLLOWED = 12.0
"""Shading an impostor's pixel takes so many times its drawing longer than shading geometry: the triangle that its ray meets is looked for
(`common_triangle_met.glsl`; a dense ball, software rasteriser)."""
START_TEXEL_NS = 600.0
CAPTURE_PASSES = 3.3
"""What a capture is taken to cost until one was measured: that for each texel, and so many times the object's triangles."""
START_LIFE = 8.0
"""The pictures that a capture is taken to serve until one has worn out."""
REMEMBERED = 15
LIVES = 3
FRESH_MARGIN = 1.25
"""A fresh picture's costs are not measured: an impostor must be that much cheaper by them."""


class Costs:
    """What was measured: an object's triangles once, when first seen, an impostor's pixels and its capture whenever one is made."""

    def __init__(self) -> None:
        self._geometry_ns: dict[Hashable, tuple[int, float]] = {}
        self._capture_ns: dict[Hashable, float] = {}
        self._lives: dict[Hashable, list[int]] = {}
        self._pixel_ns: list[float] = []

    @property
    def pixel_ns(self) -> float:
        """What an impostor's pixel costs, the median of what was measured."""
        return float(np.median(self._pixel_ns)) if self._pixel_ns else START_PIXEL_NS

    def knows_geometry(self, part: Part) -> bool:
        """Whether this number of an object's triangles was measured."""
        known = self._geometry_ns.get(part.group.key)
        return known is not None and known[0] == part.triangles

    def geometry(self, part: Part, nanoseconds: float) -> None:
        """What an object's triangles took to draw."""
        self._geometry_ns[part.group.key] = part.triangles, nanoseconds

    def impostor(self, covered_px: float, nanoseconds: float) -> None:
        """What an impostor of so many pixels took to draw."""
        if covered_px > 0.0:
            self._pixel_ns = [*self._pixel_ns[-REMEMBERED:], nanoseconds / covered_px]

    def captured(self, key: Hashable, nanoseconds: float, age: int) -> None:
        """What a capture took, and how many pictures the one before has served (0: there was none)."""
        self._capture_ns[key] = nanoseconds
        if age:
            self._lives[key] = [*self._lives.get(key, ())[-LIVES + 1 :], age]

    def drop(self, key: Hashable) -> None:
        """The object is not an impostor any more, or has changed."""
        for kept in (self._geometry_ns, self._capture_ns, self._lives):
            kept.pop(key, None)

    def of(self, part: Part, view: ImpostorView, covered_px: float, texels: float, age: int) -> tuple[float, float]:
        """(geometry, impostor): nanoseconds a picture; infinite geometry where impostors are drawn however cheap it is.

        `covered_px` pixels and `texels` of a capture from here; `age` of the one there is, in pictures.
        """
        if not view.choice.settings.break_even:
            return np.inf, 0.0
        triangles = part.triangles * view.choice.triangle_ns if view.choice.triangle_ns else self._geometry_ns[part.group.key][1]
        passes = 1 if view.samples == 1 else 2
        pixels = covered_px * (view.choice.pixel_ns or self.pixel_ns) * (passes - 1 + view.samples * (1.0 + FOLLOWED))
        capture = CAPTURE_PASSES * triangles + texels * START_TEXEL_NS
        if view.choice.alone:
            return passes * triangles, FRESH_MARGIN * (pixels + capture)
        capture = self._capture_ns.get(part.group.key, capture)
        lives = self._lives.get(part.group.key)
        life = max(float(np.mean(lives)) if lives else START_LIFE, age, 1.0)
        return passes * triangles, pixels + capture / life
