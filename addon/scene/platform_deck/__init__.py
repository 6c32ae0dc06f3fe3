"""A procedural oil-platform deck: the example of this program, from 10 thousand to 10 million triangles. numpy only, seeded.

Bays of 12 × 12 m on legs; a pipe rack runs through the middle row, the other bays hold tanks, separators, pumps, coolers, containers or
gratings; some carry an upper deck with its stair. Parts are instances of a catalogue (`parts`), laid out by `layout`.
"""

from .layout import build

__all__ = ["build"]
