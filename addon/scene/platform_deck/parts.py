"""The catalogue: every kind of part of the deck as one mesh, at a level of detail. Parts stand on z = 0 unless said otherwise."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .shapes import Solid, arc, beam, box, boxes, cylinder, join, lattice, moved, repeated, revolved, tube

BAY = 12.0
STOREY = 6.0
PIPE_RADII = (0.05, 0.084, 0.11, 0.162, 0.228)


@dataclass(frozen=True, slots=True)
class Detail:
    """`sides` of a round bar of middling size, `pitch` between the bars of a grating, metres."""

    sides: int
    pitch: float

    def round(self, factor: float = 1.0) -> int:
        """Sides of a body `factor` times as prominent."""
        return max(5, int(round(self.sides * factor)))


def plate(_: Detail) -> Solid:
    """Deck plate of a bay, top at z = 0, with stiffeners below."""
    y = np.arange(1.0, BAY, 1.0)
    low = np.stack([np.zeros_like(y), y - 0.01, np.full_like(y, -0.25)], axis=1)
    high = np.stack([np.full_like(y, BAY), y + 0.01, np.full_like(y, -0.02)], axis=1)
    return join([box((0, 0, -0.02), (BAY, BAY, 0)), boxes(low, high)])


def grating(detail: Detail) -> Solid:
    """A panel of 3 × 1 m, bars along x, top at z = 0."""
    y = np.arange(0.0, 1.0 - 1e-9, detail.pitch)
    x = np.arange(0.0, 3.0 + 1e-9, max(0.1, 2.5 * detail.pitch))
    bars = boxes(np.stack([0 * y, y, 0 * y - 0.035], axis=1), np.stack([0 * y + 3.0, y + 0.006, 0 * y], axis=1))
    rods = boxes(np.stack([x - 0.003, 0 * x, 0 * x - 0.012], axis=1), np.stack([x + 0.003, 0 * x + 1.0, 0 * x - 0.004], axis=1))
    frame = boxes(np.array([[0, 0, -0.04], [0, 0.99, -0.04]]), np.array([[3, 0.01, 0], [3, 1, 0]]))
    return join([bars, rods, frame])


def railing(detail: Detail) -> Solid:
    """3 m of railing along x: two posts, top rail, knee rail, toe plate."""
    s = detail.round(0.6)
    rails = [tube([(0, 0, z), (3, 0, z)], r, s) for z, r in ((1.1, 0.024), (0.6, 0.019))]
    posts = [tube([(x, 0, 0), (x, 0, 1.1)], 0.022, s) for x in (0.0, 1.5)]
    return join([*rails, *posts, box((0, -0.003, 0.01), (3, 0.003, 0.11))])


def column(detail: Detail) -> Solid:
    """A deck leg of one storey."""
    return cylinder(0.35, STOREY, detail.round(1.2))


def leg(detail: Detail) -> Solid:
    """A jacket leg from 14 m below up to the deck's beams."""
    return moved(cylinder(0.55, 13.4, detail.round(1.4)), (0, 0, -14.0))


def brace(detail: Detail) -> Solid:
    """Crossed braces below a bay's edge along x."""
    return join(
        [
            tube([(0, 0, -13), (BAY, 0, -2)], 0.2, detail.round()),
            tube([(0, 0, -2), (BAY, 0, -13)], 0.2, detail.round()),
            tube([(0, 0, -7.5), (BAY, 0, -7.5)], 0.16, detail.round()),
        ]
    )


def girder(_: Detail) -> Solid:
    """Main girder under a bay's edge along x."""
    return moved(beam(BAY, 0.9, 0.35), (0, 0, -0.25))


def rack_frame(_: Detail) -> Solid:
    """Portal of the pipe rack across y: two posts and three tiers of cross-beams."""
    posts = boxes(np.array([[-0.12, 0, 0], [-0.12, 4.6, 0]]), np.array([[0.12, 0.24, 5.4], [0.12, 4.84, 5.4]]))
    tiers = boxes(np.array([[-0.1, 0.24, z - 0.2] for z in (3.0, 4.1, 5.2)]), np.array([[0.1, 4.6, z] for z in (3.0, 4.1, 5.2)]))
    return join([posts, tiers])


def pipe(radius: float) -> Callable[[Detail], Solid]:
    """A bay of pipe along x, its underside at z = 0, with a flange pair half way."""

    def make(detail: Detail) -> Solid:
        z, s = radius, detail.round(0.8 + 2 * radius)
        flanges = [moved(cylinder(1.6 * radius, 0.04, s, "x"), (x, 0, z)) for x in (5.95, 6.01)]
        return join([moved(cylinder(radius, BAY, s, "x"), (0, 0, z)), *flanges])

    return make


def pipe_loop(radius: float) -> Callable[[Detail], Solid]:
    """A bay of pipe with an expansion loop that rises and comes back."""

    def make(detail: Detail) -> Solid:
        r, steps = 3 * radius, max(3, detail.sides // 3)
        top = 1.2 + 3 * radius
        path = [
            (0, 0, radius),
            *arc((4 - r, 0, radius + r), (0, 0, -r), (r, 0, 0), steps),
            *arc((4 + r, 0, top - r), (-r, 0, 0), (0, 0, r), steps),
            *arc((8 - r, 0, top - r), (0, 0, r), (r, 0, 0), steps),
            *arc((8 + r, 0, radius + r), (-r, 0, 0), (0, 0, -r), steps),
            (BAY, 0, radius),
        ]
        return tube(np.array(path, float), radius, detail.round(0.8 + 2 * radius))

    return make


def pipe_drop(radius: float) -> Callable[[Detail], Solid]:
    """From a pipe at z = 0 sideways along −y, down 3 m through a bend, with a gate valve and its hand wheel."""

    def make(detail: Detail) -> Solid:
        r, steps, s = 3 * radius, max(3, detail.sides // 3), detail.round(0.8 + 2 * radius)
        path = [(0, 0, radius), *arc((0, -1.2 + r, radius - r), (0, 0, r), (0, -r, 0), steps), (0, -1.2, -2.9)]
        body = revolved(
            [
                (0, -0.25),
                (1.6 * radius, -0.25),
                (1.6 * radius, -0.2),
                (1.1 * radius, -0.2),
                (1.5 * radius, 0),
                (1.1 * radius, 0.2),
                (1.6 * radius, 0.2),
                (1.6 * radius, 0.25),
                (0, 0.25),
            ],
            s,
        )
        valve = moved(body, (0, -1.2, -1.9))
        stem = tube([(0, -1.2, -1.9), (0, -1.2 - 4 * radius - 0.15, -1.9)], 0.3 * radius, s)
        return join(
            [
                tube(np.array(path, float), radius, s),
                valve,
                stem,
                moved(hand_wheel(2.2 * radius, detail), (0, -1.2 - 4 * radius - 0.15, -1.9)),
            ]
        )

    return make


def hand_wheel(radius: float, detail: Detail) -> Solid:
    """A hand wheel in the xz plane with four spokes."""
    angle = np.arange(detail.round(1.2)) * 2 * np.pi / detail.round(1.2)
    ring = np.stack([radius * np.cos(angle), 0 * angle, radius * np.sin(angle)], axis=1)
    spokes = [tube([(-radius, 0, 0), (radius, 0, 0)], 0.1 * radius, 5), tube([(0, 0, -radius), (0, 0, radius)], 0.1 * radius, 5)]
    return join([tube(ring, 0.13 * radius, max(5, detail.sides // 2), is_closed=True), *spokes])


def _domed(radius: float, low: float, high: float, steps: int) -> list[tuple[float, float]]:
    """Profile of a vessel between two ellipsoidal heads (2 : 1)."""
    angle = np.linspace(0.0, np.pi / 2, steps + 1)
    head = np.stack([radius * np.sin(angle), radius / 2 * np.cos(angle)], axis=1)
    return [(float(r), low - float(z)) for r, z in head] + [(float(r), high + float(z)) for r, z in head[::-1]]


def tank(detail: Detail) -> Solid:
    """A standing tank of 3 m diameter and 5 m height on a skirt, with nozzles, a manhole and stiffening rings."""
    s = detail.round(2.4)
    rings = [moved(cylinder(1.56, 0.08, s), (0, 0, z)) for z in (1.4, 3.1, 4.8)]
    nozzles = [moved(cylinder(0.16, 0.5, detail.round(), "x"), (1.4, y, z)) for y, z in ((0.3, 1.8), (-0.4, 4.2))]
    flanges = [moved(cylinder(0.27, 0.05, detail.round(), "x"), (1.9, y, z)) for y, z in ((0.3, 1.8), (-0.4, 4.2))]
    manhole = moved(cylinder(0.35, 0.3, detail.round(1.3), "y"), (0, 1.45, 2.2))
    return join(
        [revolved(_domed(1.5, 1.0, 5.0, max(3, detail.sides // 2)), s), cylinder(1.35, 1.0, s), *rings, *nozzles, *flanges, manhole]
    )


def vessel(detail: Detail) -> Solid:
    """A lying separator of 2.4 m diameter and 8 m length along x on two saddles, its axis at z = 1.9."""
    s = detail.round(2.2)
    body = moved(revolved(_domed(1.2, -3.6, 3.6, max(3, detail.sides // 2)), s, "x"), (0, 0, 1.9))
    saddles = boxes(np.array([[-2.6, -0.95, 0], [2.3, -0.95, 0]]), np.array([[-2.3, 0.95, 1.0], [2.6, 0.95, 1.0]]))
    nozzles = [moved(cylinder(0.15, 0.55, detail.round()), (x, 0, 3.0)) for x in (-2.5, -0.8, 1.1, 2.7)]
    flanges = [moved(cylinder(0.26, 0.05, detail.round()), (x, 0, 3.5)) for x in (-2.5, -0.8, 1.1, 2.7)]
    bands = [moved(cylinder(1.23, 0.1, s, "x"), (x, 0, 1.9)) for x in (-1.5, 0.0, 1.5)]
    return join([body, saddles, *nozzles, *flanges, *bands])


def pump(detail: Detail) -> Solid:
    """A pump skid of 2.4 × 1 m: base frame, finned motor, coupling, volute with its nozzle."""
    s = detail.round(1.2)
    base = boxes(
        np.array([[-1.2, -0.5, 0], [-1.2, 0.38, 0], [-1.2, -0.5, 0.1]]), np.array([[1.2, -0.38, 0.1], [1.2, 0.5, 0.1], [1.2, 0.5, 0.16]])
    )
    fins = [moved(cylinder(0.36, 0.02, s, "x"), (x, 0, 0.6)) for x in np.linspace(-0.95, -0.15, 9)]
    motor = moved(cylinder(0.31, 1.0, s, "x"), (-1.05, 0, 0.6))
    shaft = moved(cylinder(0.07, 0.6, detail.round(0.7), "x"), (-0.05, 0, 0.6))
    volute = moved(cylinder(0.38, 0.26, s, "x"), (0.5, 0, 0.6))
    nozzle = moved(cylinder(0.12, 0.55, detail.round()), (0.63, 0.22, 0.6))
    suction = moved(cylinder(0.15, 0.35, detail.round(), "x"), (0.76, 0, 0.6))
    feet = boxes(np.array([[-0.9, -0.3, 0.16], [0.5, -0.25, 0.16]]), np.array([[-0.2, 0.3, 0.35], [0.76, 0.25, 0.35]]))
    return join([base, motor, *fins, shaft, volute, nozzle, suction, feet])


def container(_: Detail) -> Solid:
    """A 20-foot container along x with corrugated sides."""
    x = np.arange(0.15, 5.9, 0.28)
    ribs = [
        boxes(np.stack([x, 0 * x + y0, 0 * x + 0.2], axis=1), np.stack([x + 0.14, 0 * x + y1, 0 * x + 2.4], axis=1))
        for y0, y1 in ((-0.03, 0.0), (2.38, 2.41))
    ]
    posts = boxes(
        np.array([[a, b, 0] for a in (0, 5.9) for b in (-0.04, 2.3)]),
        np.array([[a + 0.16, b + 0.16, 2.6] for a in (0, 5.9) for b in (-0.04, 2.3)]),
    )
    return join([box((0, 0, 0.12), (6.06, 2.38, 2.56)), *ribs, posts])


def stair(detail: Detail) -> Solid:
    """A flight that rises one storey along +x in 8 m: stringers, treads, railings on both sides."""
    count = 26
    x, z = np.linspace(0.25, 7.75, count), np.linspace(STOREY / (count + 1), STOREY * count / (count + 1), count)
    treads = boxes(np.stack([x - 0.14, 0 * x, z - 0.03], axis=1), np.stack([x + 0.14, 0 * x + 1.0, z], axis=1))
    s = detail.round(0.6)
    bars = []
    for y in (0.0, 1.0):
        bars += [
            tube([(0, y, 0.05), (8, y, STOREY - 0.02)], 0.09, 6),
            tube([(0, y, 1.0), (8, y, STOREY + 1.0)], 0.024, s),
            tube([(0, y, 0.55), (8, y, STOREY + 0.55)], 0.019, s),
        ]
        bars += [tube([(a, y, 0.75 * a), (a, y, 0.75 * a + 1.0)], 0.02, s) for a in np.arange(0.5, 8.0, 1.5)]
    return join([treads, *bars])


def ladder(detail: Detail) -> Solid:
    """A 5 m ladder on the yz plane with a safety cage towards −x."""
    s = detail.round(0.5)
    rungs = [tube([(0, -0.2, z), (0, 0.2, z)], 0.012, s) for z in np.arange(0.3, 5.0, 0.3)]
    angle = np.linspace(0.0, np.pi, max(6, detail.sides) + 1)
    hoop = np.stack([-0.7 * np.sin(angle), 0.35 * np.cos(angle), 0 * angle], axis=1)
    hoops = [tube(hoop + np.array([0, 0, z]), 0.012, max(4, s - 1)) for z in np.arange(2.2, 5.3, 0.75)]
    uprights = [
        tube([(-0.7 * np.sin(a), 0.35 * np.cos(a), 2.2), (-0.7 * np.sin(a), 0.35 * np.cos(a), 5.2)], 0.01, 4) for a in (0.9, 1.57, 2.24)
    ]
    sides = [tube([(0, y, 0), (0, y, 5.9)], 0.025, s) for y in (-0.22, 0.22)]
    return join([*rungs, *hoops, *uprights, *sides])


def cable_tray(_: Detail) -> Solid:
    """A bay of cable ladder along x, 0.6 m wide."""
    x = np.arange(0.15, BAY, 0.3)
    rungs = boxes(np.stack([x - 0.015, 0 * x, 0 * x], axis=1), np.stack([x + 0.015, 0 * x + 0.6, 0 * x + 0.02], axis=1))
    return join([rungs, boxes(np.array([[0, -0.01, 0], [0, 0.6, 0]]), np.array([[BAY, 0, 0.1], [BAY, 0.61, 0.1]]))])


def cooler(detail: Detail) -> Solid:
    """An air cooler of 5 × 4 m on legs: tube bundle, two fan rings, hubs."""
    legs = [moved(box((0, 0, 0), (0.15, 0.15, 2.4)), (x, y, 0)) for x in (0, 4.85) for y in (0, 3.85)]
    tubes = repeated(
        cylinder(0.025, 5.0, max(5, detail.sides // 2), "x"),
        np.stack([np.zeros(30), np.linspace(0.15, 3.85, 30), np.full(30, 2.6)], axis=1),
    )
    s = detail.round(1.8)
    ring = [(1.0, 0), (1.0, 0.5), (0.96, 0.5), (0.96, 0)]
    fans = [moved(revolved([*ring, ring[0]], s), (x, 2, 2.8)) for x in (1.3, 3.7)]
    blades = [box((x - 0.9, 1.92, 2.98), (x + 0.9, 2.08, 3.02)) for x in (1.3, 3.7)] + [
        box((x - 0.08, 1.1, 2.98), (x + 0.08, 2.9, 3.02)) for x in (1.3, 3.7)
    ]
    frame = boxes(np.array([[0, 0, 2.4], [0, 3.9, 2.4]]), np.array([[5, 0.1, 2.9], [5, 4, 2.9]]))
    return join([*legs, tubes, *fans, *blades, frame])


def lamp(detail: Detail) -> Solid:
    """A lamp post of 4 m with its arm and light."""
    s = detail.round(0.6)
    return join([tube([(0, 0, 0), (0, 0, 3.6), (0.25, 0, 3.9), (0.9, 0, 4.0)], 0.04, s), box((0.75, -0.1, 3.9), (1.25, 0.1, 3.99))])


def crane_base(detail: Detail) -> Solid:
    """Pedestal, slewing ring and machinery house, 9 m high."""
    s = detail.round(1.8)
    pedestal = revolved([(0, 0), (1.3, 0), (1.1, 5.5), (1.5, 6.0), (1.5, 6.5), (0, 6.5)], s)
    house = box((-3.6, -1.3, 6.6), (0.8, 1.3, 8.8))
    cab = box((0.8, 0.3, 6.7), (2.4, 1.6, 8.9))
    mast = [tube([(-2.6, y, 8.8), (-1.0, 0.3 * y, 13.0), (0.6, y, 8.8)], 0.12, detail.round(0.7)) for y in (-1.0, 1.0)]
    return join([pedestal, house, cab, *mast])


def _lattice_bays(detail: Detail) -> int:
    return 6 + detail.sides


def crane_boom(detail: Detail) -> Solid:
    """A lattice boom of 26 m along +x with its pendants, hook and line."""
    s = detail.round(0.6)
    pendants = [tube([(-1.2, 0.3 * y, 4.4), (25.2, 0.4 * y, 0.4)], 0.025, 5) for y in (-1.0, 1.0)]
    hook = join([tube([(25.8, 0, -0.3), (25.8, 0, -9.0)], 0.02, 5), moved(box((-0.25, -0.15, -0.8), (0.25, 0.15, 0)), (25.8, 0, -9.0))])
    return join([lattice(26.0, 1.6, 0.5, _lattice_bays(detail), 0.08, s), *pendants, hook])


def flare(detail: Detail) -> Solid:
    """A flare boom of 28 m along +x with its two gas lines."""
    lines = [tube([(0, y, -0.4), (28, 0.4 * y, -0.2)], r, detail.round(0.8)) for y, r in ((0.5, 0.22), (-0.4, 0.12))]
    return join(
        [
            lattice(28.0, 2.6, 0.4, _lattice_bays(detail), 0.12, detail.round(0.7)),
            *lines,
            moved(cylinder(0.35, 1.8, detail.round()), (28, 0, 0)),
        ]
    )


CATALOGUE: dict[str, tuple[Callable[[Detail], Solid], str]] = {
    "Deck plate": (plate, "deck paint"),
    "Grating": (grating, "galvanised"),
    "Railing": (railing, "safety yellow"),
    "Column": (column, "structure grey"),
    "Jacket leg": (leg, "structure grey"),
    "Brace": (brace, "structure grey"),
    "Girder": (girder, "structure grey"),
    "Rack frame": (rack_frame, "structure grey"),
    "Tank": (tank, "vessel white"),
    "Separator": (vessel, "vessel white"),
    "Pump": (pump, "machine blue"),
    "Container": (container, "container red"),
    "Stair": (stair, "safety yellow"),
    "Ladder": (ladder, "safety yellow"),
    "Cable tray": (cable_tray, "galvanised"),
    "Air cooler": (cooler, "galvanised"),
    "Lamp": (lamp, "structure grey"),
    "Crane base": (crane_base, "crane orange"),
    "Crane boom": (crane_boom, "crane orange"),
    "Flare boom": (flare, "flare red"),
    **{
        f"{title} {round(2000 * r)}": (make(r), color)
        for r, color in zip(PIPE_RADII, ("pipe green", "pipe blue", "pipe steel", "pipe steel", "pipe sand"), strict=True)
        for title, make in (("Pipe", pipe), ("Pipe loop", pipe_loop), ("Pipe drop", pipe_drop))
    },
}

COLORS: dict[str, tuple[float, float, float]] = {
    "deck paint": (0.16, 0.24, 0.20),
    "galvanised": (0.46, 0.48, 0.50),
    "safety yellow": (0.80, 0.52, 0.03),
    "structure grey": (0.30, 0.33, 0.36),
    "vessel white": (0.76, 0.77, 0.75),
    "machine blue": (0.06, 0.18, 0.42),
    "container red": (0.45, 0.09, 0.06),
    "crane orange": (0.78, 0.24, 0.03),
    "flare red": (0.55, 0.08, 0.05),
    "pipe green": (0.10, 0.34, 0.17),
    "pipe blue": (0.10, 0.25, 0.50),
    "pipe steel": (0.55, 0.57, 0.60),
    "pipe sand": (0.58, 0.49, 0.33),
}
