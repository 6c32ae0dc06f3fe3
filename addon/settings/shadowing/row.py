"""What the program knows of a shadow test. Data only; the comparison itself is GLSL."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Stored:
    """What a texel of the map keeps of the surface nearest to the light beside its depth: so many 32-bit numbers, called `words`."""

    numbers: int
    words: str


DEPTHS = Stored(0, "depths")
OBJECTS = Stored(1, "objects")  # the object's number, or that of its material slot
TRIANGLES = Stored(2, "triangles")  # slot + 1, number in the index pool


@dataclass(frozen=True, slots=True, eq=False)
class ShadowTest:
    """One shadow test.

    `name` in settings and on the command line; `place` in menus, `label` and `text` there. `options`: those of the group `test` that
    change something with it (the filter's always do); without `depths` it takes one depth per cell only. `glsl`: the file of `shaders`
    with what `common_filter.glsl` asks of a test, compiled with `defines`. `walks_surfaces`: from triangle to triangle, over `u_links`.
    """

    name: str
    place: int
    label: str
    text: str
    options: frozenset[str]
    glsl: str
    stored: Stored = DEPTHS
    defines: dict[str, int | float] = field(default_factory=dict)
    walks_surfaces: bool = False
