"""Where the parts of the deck stand: bays chosen by a seeded generator, as many as the wanted number of triangles asks for."""

from __future__ import annotations

from functools import cache
from math import ceil, log10

import numpy as np

from ...errors import SettingsError
from ..cad_model import CadMaterial, CadMesh, CadModel, CadPart
from .parts import BAY, CATALOGUE, COLORS, PIPE_RADII, STOREY, Detail
from .shapes import Solid

FEWEST, MOST = 10_000, 10_000_000
RACK_Y = 3.5
SIDE_BAYS = ("tanks", "separators", "pumps", "coolers", "containers", "gratings")


def build(triangles: int = 150_000, seed: int = 1, length_m: float | None = None) -> CadModel:
    """A deck of about `triangles` triangles with all instances counted (within 15 % from 50 thousand up; a little deck has at least one
    bay of each row).

    More triangles mean finer parts and more bays. `length_m` fixes the deck's length (240 for a full-size one): then width and detail
    follow. The same arguments give the same deck. Raises `SettingsError` out of 10 thousand … 10 million.
    """
    if not FEWEST <= triangles <= MOST:
        raise SettingsError(f"The deck can have {FEWEST} to {MOST} triangles, not {triangles}.")
    if length_m is not None and not BAY <= length_m <= 1000.0:
        raise SettingsError(f"The deck's length must lie between {BAY:g} and 1000 m.")
    columns = None if length_m is None else max(1, round(length_m / BAY))
    detail = _detail(triangles)
    count = _bay_count(triangles, seed, detail, columns)
    return _Deck(detail, seed, count, columns).model(f"Deck {triangles}")


def _detail(triangles: int) -> Detail:
    """Finer parts with more triangles: 5 sides and a 25 cm grating at 10 thousand, 20 sides and 5 cm at 10 million."""
    t = log10(triangles / FEWEST) / 3.0
    return Detail(int(round(5 + 15 * t)), 0.25 * 0.2**t)


def _bay_count(wanted: int, seed: int, detail: Detail, columns: int | None) -> int:
    """The number of bays whose triangles come nearest to `wanted`: bisection, then its neighbours (the shape changes with the count, so the
    total does not rise quite steadily)."""

    def total(count: int) -> int:
        return _Deck(detail, seed, count, columns).triangle_count()

    low = columns or 2
    high = max(low + 1, int(low * wanted / max(total(low), 1)))
    while total(high) < wanted:
        low, high = high, 2 * high
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if total(middle) < wanted else (low, middle)
    near = range(max(columns or 2, low - 4), high + 4) if high < 100 else (low, high)
    return min(near, key=lambda n: abs(total(n) - wanted))


@cache
def _solid(name: str, detail: Detail) -> Solid:
    return CATALOGUE[name][0](detail)


class _Deck:
    """One layout: rows of bays (the pipe rack in the middle row), filled column by column."""

    def __init__(self, detail: Detail, seed: int, count: int, columns: int | None) -> None:
        self.detail, self.count = detail, count
        self.columns = columns or max(2, ceil((count * 1.8) ** 0.5))
        self.rows = max(1, ceil(count / self.columns))
        self.placed: list[tuple[str, str, np.ndarray]] = []  # group, part, matrix
        self.rng = np.random.default_rng(seed)
        order = sorted(range(self.rows), key=lambda j: (abs(j - (self.rows - 1) // 2), j))
        self.bays = {(i, j) for n, (j, i) in enumerate((j, i) for j in order for i in range(self.columns)) if n < count}
        self.rack_row = order[0]
        self.upper = self._upper_bays()
        self.kinds: list[str] = []
        for bay in sorted(self.bays):
            self._bay(*bay)
        for i, j in sorted({(i + di, j + dj) for i, j in self.bays for di in (0, 1) for dj in (0, 1)}):
            self.put("Jacket", "Jacket leg", i * BAY, j * BAY)
        self._landmarks()

    def put(self, group: str, name: str, x: float, y: float, z: float = 0.0, turn: float = 0.0, tilt: float = 0.0) -> None:
        """Place a part, turned about z and tilted about y (degrees; the tilt raises its +x end)."""
        c, s, ct, st = (f(np.radians(a)) for a in (turn, tilt) for f in (np.cos, np.sin))
        matrix = np.eye(4)
        matrix[:3, :3] = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ np.array([[ct, 0, -st], [0, 1, 0], [st, 0, ct]])
        matrix[:3, 3] = x, y, z
        self.placed.append((group, name, matrix))

    def _upper_bays(self) -> set[tuple[int, int]]:
        """Bays beside the rack that carry an upper deck."""
        return {bay for bay in sorted(self.bays) if bay[1] != self.rack_row and self.rng.random() < 0.35}

    def _bay(self, i: int, j: int) -> None:
        group, x, y = f"Bay {i + 1}-{j + 1}", i * BAY, j * BAY
        self.put(group, "Deck plate", x, y)
        self.put(group, "Girder", x, y)
        self.put(group, "Girder", x, y, turn=90)
        self._edges(group, i, j, self.bays, 0.0)
        if j == self.rack_row:
            self._rack(group, x, y)
        else:
            self._equipment(group, x, y, (i, j) in self.upper)
        if (i, j) in self.upper:
            self._upper_deck(group, i, j)
        if (i + j) % 2 == 0:
            self.put(group, "Lamp", x + 0.4, y + 0.4, turn=45)

    def _edges(self, group: str, i: int, j: int, bays: set[tuple[int, int]], z: float) -> None:
        """Railings, and below the main deck braces, where there is no neighbour."""
        x, y = i * BAY, j * BAY
        sides = (
            ((i, j - 1), x, y, 0.0),
            ((i, j + 1), x + BAY, y + BAY, 180.0),
            ((i - 1, j), x, y + BAY, -90.0),
            ((i + 1, j), x + BAY, y, 90.0),
        )
        for neighbour, ex, ey, turn in sides:
            if neighbour in bays:
                continue
            c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
            for k in range(4):
                self.put(group, "Railing", ex + 3 * k * c, ey + 3 * k * s, z, turn)
            if z == 0.0:
                self.put(group, "Brace", ex, ey, 0.0, turn)
                if turn in (90.0, 180.0):
                    self.put(group, "Girder", ex, ey, 0.0, turn)

    def _rack(self, group: str, x: float, y: float) -> None:
        """The pipe rack of one bay: frames, two tiers of pipes, cable trays on the top, drops to the deck."""
        for dx in (0.0, 6.0):
            self.put(group, "Rack frame", x + dx, y + RACK_Y)
        has_loop = self.rng.random() < 0.3
        for tier, z in ((0, 3.0), (1, 4.1)):
            offset = 0.55
            lane = np.random.default_rng(17 + tier)  # the same pipes in every bay
            while offset < 4.2:
                radius = float(lane.choice(PIPE_RADII))
                kind = "Pipe loop" if has_loop and tier == 1 else "Pipe"
                self.put(group, f"{kind} {round(2000 * radius)}", x, y + RACK_Y + offset, z)
                if tier == 0 and self.rng.random() < 0.3:
                    self.put(
                        group, f"Pipe drop {round(2000 * radius)}", x + float(self.rng.uniform(1, 11)), y + RACK_Y + 0.4 - 0.2 * tier, z
                    )
                offset += 2 * radius + 0.22
        self.put(group, "Cable tray", x, y + RACK_Y + 0.6, 5.2)
        self.put(group, "Cable tray", x, y + RACK_Y + 3.4, 5.2)
        for dy in (0.6, 9.6):
            for k in range(4):
                self.put(group, "Grating", x + 3 * k, y + dy, 0.06)

    def _equipment(self, group: str, x: float, y: float, is_below_deck: bool) -> None:
        kind = self._next_kind(is_below_deck)
        if kind == "tanks":
            for dx, dy in ((3.2, 3.4), (8.2, 3.4), (3.2, 8.4), (8.2, 8.4)):
                self.put(group, "Tank", x + dx, y + dy, turn=float(self.rng.integers(4) * 90))
            self.put(group, "Ladder", x + 1.35, y + 3.4)
            self.put(group, "Ladder", x + 1.35, y + 8.4)
        elif kind == "separators":
            for dy in (2.8, 6.4, 9.6):
                self.put(group, "Separator", x + 6, y + dy)
        elif kind == "pumps":
            for dx in (2.5, 6.0, 9.5):
                for dy in (2.2, 4.6, 7.0, 9.6):
                    self.put(group, "Pump", x + dx, y + dy, turn=float(self.rng.integers(2) * 180))
        elif kind == "coolers":
            for dx, dy in ((0.8, 1.2), (6.4, 1.2), (0.8, 6.6), (6.4, 6.6)):
                self.put(group, "Air cooler", x + dx, y + dy)
        elif kind == "containers":
            self._containers(group, x, y, 1 if is_below_deck else 2)
        else:
            self._gratings(group, x, y, 0.1)

    def _next_kind(self, is_below_deck: bool) -> str:
        """Every kind comes up once in each round, in random order; tanks are too high to stand below a deck."""
        if not self.kinds:
            self.kinds = [str(kind) for kind in self.rng.permutation(SIDE_BAYS)]
        fitting = [kind for kind in self.kinds if not (is_below_deck and kind == "tanks")]
        if not fitting:
            return "gratings"
        self.kinds.remove(fitting[0])
        return fitting[0]

    def _containers(self, group: str, x: float, y: float, layers: int) -> None:
        for k in range(3):
            height = int(self.rng.integers(1, layers + 1))
            for layer in range(height):
                self.put(group, "Container", x + 1.5 + float(self.rng.uniform(0, 2)), y + 1.2 + 3.3 * k, 2.6 * layer)

    def _gratings(self, group: str, x: float, y: float, z: float) -> None:
        for k in range(4):
            for m in range(10):
                self.put(group, "Grating", x + 3 * k, y + 1 + m, z)
        for dy in (3.0, 8.0):
            self.put(group, "Pump", x + 6.0, y + dy, z)

    def _upper_deck(self, group: str, i: int, j: int) -> None:
        """A grating deck one storey up, on columns, with girders, railings and a stair."""
        x, y = i * BAY, j * BAY
        for dx in (0.4, BAY - 0.4):
            for dy in (0.4, BAY - 0.4):
                self.put(group, "Column", x + dx, y + dy)
        for dy in (0.4, 4.0, 8.0, BAY - 0.4):
            self.put(group, "Girder", x, y + dy, STOREY + 0.2)
        for k in range(4):
            for m in range(12):
                self.put(group, "Grating", x + 3 * k, y + m, STOREY)
        self._edges(group, i, j, self.upper, STOREY)
        self.put(group, "Stair", x + 1.5, y + (BAY if j > self.rack_row else -1.0) - (1.1 if j > self.rack_row else -1.1))

    def _landmarks(self) -> None:
        """One crane and, on all but the least decks, one flare boom: what makes a platform's outline."""
        last = max(i for i, j in self.bays if j == self.rack_row)
        x, y = (last + 1) * BAY, self.rack_row * BAY
        if self.count > 3:
            self.put("Flare", "Flare boom", x, y + BAY / 2, 1.0, 0.0, 50.0)
        crane_x = BAY * max(1, round(last / 3))
        self.put("Crane", "Crane base", crane_x, y + 1.6)
        self.put("Crane", "Crane boom", crane_x + 1.0, y + 1.6, 7.6, 35.0, 32.0)

    def triangle_count(self) -> int:
        """All instances counted."""
        return sum(len(_solid(name, self.detail)[1]) for _, name, _ in self.placed)

    def model(self, title: str) -> CadModel:
        """The deck as a model: a group for each bay, its parts below."""
        names = list(dict.fromkeys(name for _, name, _ in self.placed))
        colors = list(COLORS)
        meshes = tuple(CadMesh(name, *_solid(name, self.detail), materials=(colors.index(CATALOGUE[name][1]),)) for name in names)
        materials = tuple(CadMaterial(name, (*rgb, 1.0)) for name, rgb in COLORS.items())
        parts: list[CadPart] = []
        group_of: dict[str, int] = {}
        for group, name, matrix in self.placed:
            if group not in group_of:
                group_of[group] = len(parts)
                parts.append(CadPart(group, -1, -1, np.eye(4)))
            parts.append(CadPart(name, group_of[group], names.index(name), matrix))
        return CadModel(title, meshes, tuple(parts), materials)
