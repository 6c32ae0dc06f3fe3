"""Solids as (positions, triangles): boxes, sweeps, bodies of revolution, lattices. numpy only, wound outwards, no zero-area triangle."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

Solid = tuple[np.ndarray, np.ndarray]

CUBE = np.array([[x, y, z] for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)])
CUBE_QUADS = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])


def _from_quads(positions: np.ndarray, quads: np.ndarray) -> Solid:
    return positions, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def join(solids: Sequence[Solid]) -> Solid:
    """Several solids as one."""
    firsts = np.cumsum([0] + [len(p) for p, _ in solids])
    return np.concatenate([p for p, _ in solids]), np.concatenate([t + f for (_, t), f in zip(solids, firsts, strict=False)])


def boxes(lows: np.ndarray, highs: np.ndarray) -> Solid:
    """N axis-aligned boxes from (N, 3) corners, in one go."""
    lows, highs = np.atleast_2d(np.asarray(lows, dtype=np.float64)), np.atleast_2d(np.asarray(highs, dtype=np.float64))
    positions = (lows[:, None] + CUBE * (highs - lows)[:, None]).reshape(-1, 3)
    quads = (CUBE_QUADS + 8 * np.arange(len(lows))[:, None, None]).reshape(-1, 4)
    return _from_quads(positions, quads)


def box(low: Sequence[float], high: Sequence[float]) -> Solid:
    """One axis-aligned box."""
    return boxes(np.array([low]), np.array([high]))


def moved(solid: Solid, offset: Sequence[float]) -> Solid:
    """A copy moved by `offset`."""
    return solid[0] + np.asarray(offset, dtype=np.float64), solid[1]


def repeated(solid: Solid, offsets: np.ndarray) -> Solid:
    """Copies at every one of (N, 3) offsets."""
    positions, triangles = solid
    offsets = np.asarray(offsets, dtype=np.float64)
    return (
        (offsets[:, None] + positions).reshape(-1, 3),
        (triangles + len(positions) * np.arange(len(offsets))[:, None, None]).reshape(-1, 3),
    )


def revolved(profile: Sequence[tuple[float, float]], sides: int, axis: str = "z") -> Solid:
    """The body that the (radius, height) polyline makes about an axis; ends at radius 0 close it."""
    r, z = np.array(profile, dtype=np.float64).T
    angle = np.arange(sides) * 2 * np.pi / sides
    rings = np.stack([r[:, None] * np.cos(angle), r[:, None] * np.sin(angle), np.broadcast_to(z[:, None], (len(r), sides))], axis=2)
    solid = _grid(rings, is_closed=False)
    turn = {"z": [0, 1, 2], "x": [2, 0, 1], "y": [1, 2, 0]}[axis]
    return solid[0][:, turn], solid[1]


def _grid(rings: np.ndarray, is_closed: bool) -> Solid:
    """(R, S, 3) rings joined to a skin; collapsed triangles (where a ring is a point) are dropped."""
    count, sides = rings.shape[:2]
    ring = np.arange(count if is_closed else count - 1)
    a = (ring[:, None] * sides + np.arange(sides)).ravel()
    b = (ring[:, None] * sides + (np.arange(sides) + 1) % sides).ravel()
    up = sides * ((ring + 1) % count)[:, None] - sides * ring[:, None]
    step = np.broadcast_to(up, (len(ring), sides)).ravel()
    positions, triangles = _from_quads(rings.reshape(-1, 3), np.stack([a, b, b + step, a + step], axis=1))
    p = positions[triangles]
    area = np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1)
    return positions, triangles[area > 1e-12]


def cylinder(radius: float, height: float, sides: int, axis: str = "z") -> Solid:
    """A capped cylinder from 0 to `height` along the axis."""
    return revolved([(0.0, 0.0), (radius, 0.0), (radius, height), (0.0, height)], sides, axis)


def tube(path: ArrayLike, radius: float, sides: int, *, is_closed: bool = False) -> Solid:
    """A round bar along a polyline, mitred at its corners, with flat caps unless closed."""
    points = np.array(path, dtype=np.float64)
    ahead = np.roll(points, -1, axis=0) - points
    back = points - np.roll(points, 1, axis=0)
    if not is_closed:
        ahead[-1], back[0] = back[-1], ahead[0]
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    back /= np.linalg.norm(back, axis=1, keepdims=True)
    tangent = ahead + back
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    stretch = 1.0 / np.maximum(np.einsum("ij,ij->i", tangent, ahead), 0.3)
    u, v = _frames(tangent)
    bend = ahead - back
    angle = np.arange(sides) * 2 * np.pi / sides
    circle = np.cos(angle)[None, :, None] * u[:, None] + np.sin(angle)[None, :, None] * v[:, None]
    length = np.linalg.norm(bend, axis=1, keepdims=True)
    inward = np.divide(bend, length, out=np.zeros_like(bend), where=length > 1e-9)
    circle += ((stretch - 1.0)[:, None] * np.einsum("rsk,rk->rs", circle, inward))[:, :, None] * inward[:, None]
    rings = points[:, None] + radius * circle
    if not is_closed:
        rings = np.concatenate([np.broadcast_to(points[:1, None], (1, sides, 3)), rings, np.broadcast_to(points[-1:, None], (1, sides, 3))])
    return _grid(rings, is_closed)


def _frames(tangent: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors across each tangent, carried along the path so that the skin does not twist."""
    first = np.array([0.0, 0.0, 1.0]) if abs(tangent[0, 2]) < 0.9 else np.array([1.0, 0.0, 0.0])
    u = np.empty_like(tangent)
    for i, t in enumerate(tangent):
        first = first - t * (first @ t)
        first /= np.linalg.norm(first)
        u[i] = first
    return u, np.cross(tangent, u)


def arc(centre: Sequence[float], start: Sequence[float], end: Sequence[float], steps: int) -> list[np.ndarray]:
    """Points from centre + start to centre + end on a quarter circle, the ends included."""
    angle = np.linspace(0.0, np.pi / 2, steps + 1)
    return list(np.asarray(centre) + np.cos(angle)[:, None] * np.asarray(start) + np.sin(angle)[:, None] * np.asarray(end))


def beam(length: float, depth: float, width: float, thickness: float = 0.03) -> Solid:
    """An I-beam along +x from 0, its top at z = 0."""
    half, web = width / 2, thickness / 2
    return boxes(
        np.array([[0, -half, -thickness], [0, -web, -depth + thickness], [0, -half, -depth]]),
        np.array([[length, half, 0], [length, web, -thickness], [length, half, -depth + thickness]]),
    )


def lattice(length: float, width: float, taper: float, bays: int, chord: float, sides: int) -> Solid:
    """A square lattice boom along +x: four chords, diagonals and frames; `taper` is the width at its far end over that at its root."""
    x = np.linspace(0.0, length, bays + 1)
    half = width / 2 * (1.0 + (taper - 1.0) * x / length)
    corner = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    nodes = np.concatenate([np.broadcast_to(x[:, None, None], (bays + 1, 4, 1)), half[:, None, None] * corner], axis=2)
    bars = [tube(nodes[[0, bays], k], chord, sides) for k in range(4)]
    for i in range(bays):
        for k in range(4):
            m = (k + 1) % 4
            bars.append(tube([nodes[i, k], nodes[i + 1, m]] if i % 2 else [nodes[i, m], nodes[i + 1, k]], 0.55 * chord, max(4, sides - 2)))
            bars.append(tube([nodes[i, k], nodes[i, m]], 0.55 * chord, max(4, sides - 2)))
    return join(bars)
