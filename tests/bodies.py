"""Closed bodies whose edges, outlines and sections are known exactly."""

from __future__ import annotations

import numpy as np

from tests.scenes import Part


def tube(outer: float, inner: float, height: float, sides: int = 256) -> Part:
    """A closed tube along z: two walls, two rings."""
    ring = circle(1.0, 0.0, sides)
    corners = np.concatenate([r * ring + [0.0, 0.0, z] for z in (0.0, height) for r in (outer, inner)])
    k, n = np.arange(sides), np.roll(np.arange(sides), -1)
    low_out, low_in, high_out, high_in = (np.stack([s * sides + k, s * sides + n]) for s in range(4))
    return corners, split(
        (low_out[0], low_out[1], high_out[1], high_out[0]),
        (low_in[1], low_in[0], high_in[0], high_in[1]),
        (high_out[0], high_out[1], high_in[1], high_in[0]),
        (low_out[1], low_out[0], low_in[0], low_in[1]),
    )


def torus(major: float, minor: float, sides: int = 192, rings: int = 96) -> Part:
    """A closed torus round z."""
    u, v = np.meshgrid(np.arange(sides) * 2 * np.pi / sides, np.arange(rings) * 2 * np.pi / rings, indexing="ij")
    r = major + minor * np.cos(v)
    points = np.stack([r * np.cos(u), r * np.sin(u), minor * np.sin(v)], axis=-1).reshape(-1, 3)
    i, j = (index.ravel() for index in np.meshgrid(np.arange(sides), np.arange(rings), indexing="ij"))

    def at(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return (a % sides) * rings + b % rings

    return points, split((at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)))


def cylinder(radius: float, height: float, sides: int = 64) -> Part:
    """A closed cylinder along z; its ends are fans."""
    ring = circle(radius, 0.0, sides)
    corners = np.concatenate([ring, ring + [0.0, 0.0, height], [[0.0, 0.0, 0.0], [0.0, 0.0, height]]])
    k, n = np.arange(sides), np.roll(np.arange(sides), -1)
    ends = [np.stack([n, k, np.full(sides, 2 * sides)], 1), np.stack([sides + k, sides + n, np.full(sides, 2 * sides + 1)], 1)]
    return corners, np.concatenate([split((k, n, sides + n, sides + k)), *ends])


def holed_sheet(half: float, radius: float, sides: int = 64) -> Part:
    """A square sheet with a round hole, open."""
    ring = circle(radius, 0.0, sides)
    outer = ring * (half / np.abs(ring[:, :2]).max(axis=1, keepdims=True))
    k, n = np.arange(sides), np.roll(np.arange(sides), -1)
    return np.concatenate([ring, outer]), split((k, sides + k, sides + n, n))


def circle(radius: float, z: float, sides: int) -> np.ndarray:
    """(sides, 3) points; every eighth stands for a diagonal, so that a square round it keeps its corners."""
    angle = np.arange(sides) * 2.0 * np.pi / sides
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(sides, z)], axis=-1)


def split(*quads: tuple) -> np.ndarray:
    """(2Q, 3) triangles of quads given as four rows of corners each."""
    faces = np.concatenate([np.stack(quad, axis=-1) for quad in quads])
    return np.concatenate([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]])
