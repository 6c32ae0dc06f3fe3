"""How a picture is drawn beside its light and shadow: feature edges, ground, sections. Frozen and checked; defaults are written here."""

from __future__ import annotations

from dataclasses import dataclass

from ..maths.domains import one_of, require, require_fields, within

WIDEST_PX = 16.0
GROUNDS = ("off", "auto", "height")
CAPS = ("solid", "hatch", "none")
MOST_PLANES = 3
FARTHEST_M = 1e9


@dataclass(frozen=True, slots=True)
class EdgeLines:
    """Lines along creases, borders, silhouettes and where parts meet.

    `width` pixels, 0: none. `color` linear RGB, `strength` its opacity. `crease_deg`: faces that meet at more than this angle have a line
    between them.
    """

    width: float = within(0.0, "The width of edges (pixels)", 0.0, WIDEST_PX)
    color: tuple[float, float, float] = within((0.02, 0.02, 0.025), "Every number of edge_color", 0.0, 1.0)
    strength: float = within(0.85, "The strength of edges", 0.0, 1.0)
    crease_deg: float = within(30.0, "The angle of edges (degrees)", 0.0, 180.0)

    def __post_init__(self) -> None:
        require_fields(self)

    @property
    def is_on(self) -> bool:
        """Whether any line is drawn over the picture."""
        return self.width > 0.0 and self.strength > 0.0


@dataclass(frozen=True, slots=True)
class GroundChoice:
    """The ground that only catches shadows: nothing of it is seen but they, and they fade out round the model.

    `kind` 'auto': just under what is visible; 'height': at `height`, metres in the world. `strength`: how dark its shadows are, 1 as on a
    surface lit like the model.
    """

    kind: str = one_of("off", "Ground", GROUNDS)
    height: float = within(0.0, "The ground's height (metres)", -FARTHEST_M, FARTHEST_M)
    strength: float = within(1.0, "The strength of the ground's shadows", 0.0, 1.0)

    def __post_init__(self) -> None:
        require_fields(self)


@dataclass(frozen=True, slots=True)
class SectionChoice:
    """What section planes take away, and how the cut looks.

    `planes` six numbers each: a point, and the normal, which points to the side that is cut away; metres in the true world, up to three.
    `caps` of closed bodies: 'solid' in `cap_color` (linear RGB), 'hatch' with lines over it. `casts_whole`: what is cut away still casts
    its shadow.
    """

    planes: tuple[float, ...] = within((), "Every number of a section plane", -FARTHEST_M, FARTHEST_M)
    caps: str = one_of("solid", "Section caps", CAPS)
    cap_color: tuple[float, float, float] = within((0.55, 0.09, 0.06), "Every number of section_color", 0.0, 1.0)
    casts_whole: bool = False

    def __post_init__(self) -> None:
        require_fields(self)
        count, rest = divmod(len(self.planes), 6)
        require(rest == 0, "A section plane is six numbers: X,Y,Z of a point in it and X,Y,Z of its normal.")
        require(count <= MOST_PLANES, f"There are {count} section planes: {MOST_PLANES} at most.")
        normals = [self.planes[i + 3 : i + 6] for i in range(0, len(self.planes), 6)]
        require(all(any(abs(n) > 1e-12 for n in normal) for normal in normals), "A section plane's normal is zero: give its direction.")
