"""The valve of the documentation's pictures: closed bodies turned on a lathe, with colours, as an OBJ file.

python -m tools.docs_model FOLDER
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

SIDES = 96
COLORS = {"steel": (0.55, 0.57, 0.60), "red": (0.70, 0.10, 0.08), "brass": (0.75, 0.55, 0.20), "blue": (0.12, 0.28, 0.50)}
Body = tuple[str, str, np.ndarray, np.ndarray]
"""Name, colour, corners (V, 3) in millimetres, quads (Q, 4)."""
ALONG_X = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""Turns what is turned on the lathe round z to lie along x."""


def lathe(profile: list[tuple[float, float]], sides: int = SIDES) -> tuple[np.ndarray, np.ndarray]:
    """A closed profile (radius, height), radius > 0, counter-clockwise, turned round z: a closed body with a bore."""
    angle = np.arange(sides) * 2.0 * np.pi / sides
    radius, height = np.array(profile).T
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    corners = np.concatenate([ring[:, None] * radius[:, None], np.broadcast_to(height[:, None], (sides, len(profile), 1))], axis=-1)
    i, j = (index.ravel() for index in np.meshgrid(np.arange(sides), np.arange(len(profile)), indexing="ij"))
    n = len(profile)

    def at(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return (a % sides) * n + b % n

    return corners.reshape(-1, 3), np.stack([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)], axis=-1)


def tube(inner: float, outer: float, low: float, high: float, sides: int = SIDES) -> tuple[np.ndarray, np.ndarray]:
    """A tube along z."""
    return lathe([(inner, low), (outer, low), (outer, high), (inner, high)], sides)


def torus(radius: float, thickness: float) -> tuple[np.ndarray, np.ndarray]:
    """A ring round z."""
    angle = np.arange(32) * 2.0 * np.pi / 32
    return lathe([(radius + thickness * float(np.cos(a)), thickness * float(np.sin(a))) for a in angle])


def valve() -> list[Body]:
    """A gate valve between two flanges, with its bolts, stem and wheel."""
    half = [(75, 40), (52, 80), (52, 130), (80, 130), (80, 150), (40, 150)]
    body = [*((radius, -height) for radius, height in reversed(half)), *half]
    parts: list[Body] = []

    def add(name: str, color: str, mesh: tuple, turn: np.ndarray | None = None, at: tuple = (0.0, 0.0, 0.0)) -> None:
        corners = mesh[0] if turn is None else mesh[0] @ turn.T
        parts.append((name, color, corners + np.array(at), mesh[1]))

    add("Body", "blue", lathe([(float(r), float(z)) for r, z in body]), ALONG_X)
    add("Gate", "brass", tube(0.5, 39.5, -8.0, 8.0), ALONG_X)
    add("Bonnet", "blue", lathe([(10.5, 60), (45, 60), (45, 95), (70, 95), (70, 110), (30, 110), (22, 150), (10.5, 150)]))
    add("Packing gland", "brass", tube(10.2, 20.0, 150.0, 165.0))
    add("Stem", "steel", tube(0.5, 10.0, 30.0, 235.0))
    add("Wheel", "red", torus(85.0, 8.0), at=(0.0, 0.0, 220.0))
    add("Hub", "red", tube(10.0, 20.0, 208.0, 232.0))
    for quarter in range(4):
        a = quarter * np.pi / 2.0
        turn = np.array([[np.cos(a), -np.sin(a), 0.0], [np.sin(a), np.cos(a), 0.0], [0.0, 0.0, 1.0]]) @ ALONG_X
        add(f"Spoke {quarter + 1}", "red", tube(0.5, 5.0, 15.0, 82.0, 24), turn, (0.0, 0.0, 220.0))
    for number in range(8):
        a = (number + 0.5) * np.pi / 4.0
        y, z = 66.0 * float(np.cos(a)), 66.0 * float(np.sin(a))
        for side in (-1.0, 1.0):
            add(f"Bolt {number + 1}", "steel", tube(0.5, 6.0, side * 140.0 - 20.0, side * 140.0 + 20.0, 6), ALONG_X, (0.0, y, z))
        x, y = 58.0 * float(np.cos(a)), 58.0 * float(np.sin(a))
        add(f"Bonnet bolt {number + 1}", "steel", tube(0.5, 4.0, 85.0, 120.0, 6), at=(x, y, 0.0))
    return parts


def write(folder: Path) -> Path:
    """Write valve.obj and valve.mtl (metres, z up); the path of the first."""
    lines, first = ["mtllib valve.mtl"], 1
    for name, color, corners, quads in valve():
        lines += [f"o {name}", f"usemtl {color}"]
        lines += [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in corners / 1000.0]
        lines += ["f " + " ".join(str(first + int(corner)) for corner in quad) for quad in quads]
        first += len(corners)
    (folder / "valve.mtl").write_text("".join(f"newmtl {n}\nKd {r} {g} {b}\n" for n, (r, g, b) in COLORS.items()), encoding="utf-8")
    path = folder / "valve.obj"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


if __name__ == "__main__":
    print(write(Path(sys.argv[1])))
