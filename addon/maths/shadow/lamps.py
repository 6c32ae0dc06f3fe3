"""The map of a finite light (spot, side of a point light): which way it is warped, how strongly, and how it is parted among maps.

After its own projection such a light is directional (`light_space.py`): x and z are directions, a receiver at the distance R has y = 1/R.
A pixel's half footprint r there is its metres over R, an affine function of (x, y, z), but not one that grows along the image of the view
axis as a sun's does: it depends on where the lamp hangs. So the warp is derived from the receivers themselves. A map turned by some angle
about the light's axis, with w = 1 + κ (z − z₀) and extents L_s × L_t in (S, T), has texels of L_s w / N by L_t w² √(1 + κ² S²) / N, which
run towards the apex, hence (T4 (11))

    m_x = L_s w / (2 r N),  m_z = L_t w² √(1 + κ² S²) / (2 r N).

The length of an edge's error is a texel's, so what is made small is the mean of (m_x + m_z) / 2 over the pixels that show the receivers:
over the angle (along the picture's sides, or the way in which r grows fastest), over ln(f'/n') and over the apex. κ = 0 is among the
choices, so the mean is never above the uniform map's. That is the balanced warp; others are as much stronger or weaker as they are for a
sun at right angles to the view.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import atan2, cos, log, log1p, pi, sin

import numpy as np

from ..choices import PartitionChoice, WarpChoice
from ..frusta import Body
from ..warping.formulas import warp_depth
from .crop import Receivers
from .light_space import LightSpace
from .warps import warp_parameter

MOST_SAMPLES = 512  # receivers that the mean is taken over
OUTWARDS = 24  # directions in which the farthest of them are looked for
STRONGEST = 9.0  # largest ln(f'/n'): float32 places texels up to 1e4
GRID, FINER = 9, 3  # strengths tried at once, and how often the step is made finer round the best
APEXES = np.linspace(-3.0, 3.0, 9)  # places of the apex, in half widths from the middle of the receivers
SECTIONS, RINGS = 8, (0.2, 0.4, 0.6, 0.8)
EASING = 0.9  # what an overdone warp is multiplied by until it is no worse than none


@dataclass(frozen=True, slots=True)
class Aim:
    """How a lamp's map looks: its space, turned about the light's axis, its receivers there, ln(f'/n') over their depth, and the means of
    m_x and m_z (times N)."""

    space: LightSpace
    receivers: Receivers | None
    strength: float
    error: tuple[float, float]


def aimed(space: LightSpace, receivers: Receivers | None, share: float, capped: bool = True) -> Aim:
    """The map of these receivers with the least mean error, its strength times `share`; `capped`: not so much that none would be better."""
    if receivers is None:
        return Aim(space, None, 0.0, (1.0, 1.0))
    some = _picked(receivers)
    found = []
    for angle in _angles(space, some):
        placed = some.turned(angle)
        apex, strength = placed.balanced() if share > 0.0 else (placed.middle[0], 0.0)
        found += [(angle, apex, strength if share == 1.0 else placed.scaled(apex, strength, share, capped)), (angle, apex, 0.0)]
    whole = _places(receivers, slice(None))
    errors = [whole.turned(angle).errors(apex, np.array([strength]))[:, 0] for angle, apex, strength in found]
    allowed = range(len(found)) if capped else range(0, len(found), 2)
    best = min(allowed, key=lambda k: float(errors[k].sum()))
    angle, apex, strength = found[best]
    x, z = whole.turned(angle).rows
    return Aim(
        turned(space, angle, apex),
        Receivers(np.stack([x, receivers.rows[1], z]), receivers.radius),
        strength,
        (float(errors[best][0]), float(errors[best][1])),
    )


@dataclass(frozen=True, slots=True)
class Places:
    """Receivers in the light's picture: `across`, `along` (P,), half a pixel `r` (P,) there; `edge`: only the first so many count in the
    extents of a map, not in the means."""

    across: np.ndarray
    along: np.ndarray
    r: np.ndarray
    edge: int = 0

    @property
    def rows(self) -> tuple[np.ndarray, np.ndarray]:
        """(across, along)."""
        return self.across, self.along

    @property
    def middle(self) -> tuple[float, float]:
        """The middle of the extent across, and half of that."""
        low, high = float(self.across.min()), float(self.across.max())
        return 0.5 * (low + high), 0.5 * (high - low)

    def turned(self, angle: float) -> Places:
        """The same for axes turned by `angle`."""
        c, s = self.across.dtype.type(cos(angle)), self.across.dtype.type(sin(angle))
        return Places(self.across * c - self.along * s, self.along * c + self.across * s, self.r, self.edge)

    def errors(self, apex: float, strengths: np.ndarray) -> np.ndarray:
        """(2, K): the means of N m_x and N m_z of K maps of strengths ln(f'/n') (K,) with that apex."""
        start, depth = self.along.min(), max(float(np.ptp(self.along)), 1e-12)
        kappa = (np.expm1(strengths)[:, None] / depth).astype(self.along.dtype)
        z = self.along - start
        w = 1.0 + kappa * z
        s = (self.across - self.across.dtype.type(apex)) / w
        length_s, length_t = np.ptp(s, axis=1), np.ptp(z / w, axis=1)
        w, slant = w[:, self.edge :], np.sqrt(1.0 + (kappa * s[:, self.edge :]) ** 2)
        weighted = w / (2.0 * self.r[self.edge :])
        return np.stack([length_s * weighted.mean(axis=1), length_t * (weighted * w * slant).mean(axis=1)]).astype(np.float64)

    def balanced(self) -> tuple[float, float]:
        """The apex and the strength of the least mean error, by turns."""
        middle, half = self.middle
        apex = middle
        strength = self._strength(apex, 1)
        errors = [float(self.errors(a, np.array([strength])).sum()) for a in middle + APEXES * half]
        apex = middle + float(APEXES[int(np.argmin(errors))]) * half
        return apex, self._strength(apex, FINER)

    def _strength(self, apex: float, finer: int) -> float:
        """The strength of the least mean error: on a grid, then on finer ones round its best place."""
        low, high = 0.0, STRONGEST
        for _ in range(1 + finer):
            grid = np.linspace(low, high, GRID)
            best = int(np.argmin(self.errors(apex, grid).sum(axis=0)))
            low, high = grid[max(best - 1, 0)], grid[min(best + 1, GRID - 1)]
        return float(grid[best])

    def scaled(self, apex: float, strength: float, share: float, capped: bool) -> float:
        """`share` times the strength; `capped`: eased until the mean error is not above the uniform map's."""
        scaled = min(share * strength, STRONGEST)
        if not capped or share <= 1.0:
            return scaled
        uniform = self.errors(apex, np.zeros(1)).sum()
        while scaled > strength and self.errors(apex, np.array([scaled])).sum() > uniform:
            scaled = max(EASING * scaled, strength)
        return scaled


def _picked(receivers: Receivers) -> Places:
    """Some of the receivers for the means, and those farthest out in `OUTWARDS` directions for the extents."""
    x, _, z = receivers.rows
    pick = np.arange(0, len(x), -(-len(x) // MOST_SAMPLES))
    angles = np.linspace(0.0, 2.0 * pi, OUTWARDS, endpoint=False)
    out = np.unique((np.stack([np.cos(angles), np.sin(angles)], axis=1).astype(x.dtype) @ receivers.rows[[0, 2]]).argmax(axis=1))
    return _places(receivers, np.concatenate([out, pick]), len(out))


def _places(receivers: Receivers, chosen: np.ndarray | slice, edge: int = 0) -> Places:
    """The chosen receivers; half a pixel there is larger where the light falls aslant on the picture plane: by 1/√cos φ_l in the mean."""
    x, _, z = receivers.rows[:, chosen]
    assert receivers.radius is not None, "what a lamp lights has the size of its pixels"
    return Places(x, z, receivers.radius[chosen] * np.sqrt(np.sqrt(1.0 + x * x + z * z)), edge)


def _angles(space: LightSpace, places: Places) -> tuple[float, ...]:
    """Turns worth trying: the way in which a pixel grows fastest, and the side of the picture nearest to it."""
    plane = np.stack([np.ones_like(places.across), places.across, places.along], axis=1)
    _, by_x, by_z = np.linalg.lstsq(plane, places.r, rcond=None)[0]
    growing = atan2(by_x, by_z)
    quarter = round((growing + space.upright) / (0.5 * pi)) * 0.5 * pi
    return quarter - space.upright, growing


def share_of(warp: WarpChoice, near: float, far: float, half_fov_rad: float) -> float:
    """How strong a warp is beside the balanced one, as it is for a sun at right angles to the view: ln(f'/n') over LiSPSM's."""
    if not 0.0 < near < far or half_fov_rad <= 0.0:
        return 0.0
    depth = warp_depth(near, far, half_fov_rad, 0.5 * pi)
    own, balanced = (log1p(depth / warp_parameter(choice, near, far, half_fov_rad, 0.5 * pi)) for choice in (warp, WarpChoice()))
    return own / balanced


def turned(space: LightSpace, angle: float, apex: float) -> LightSpace:
    """The space turned about the light's axis, with the warp's apex at x = `apex` of the new axes."""
    x, z = space.from_eye[0], space.from_eye[2]
    from_eye = space.from_eye.copy()
    from_eye[0], from_eye[2] = cos(angle) * x - sin(angle) * z, cos(angle) * z + sin(angle) * x
    return replace(space, from_eye=from_eye, apex_x=apex, upright=space.upright + angle)


def parts_the_picture(partition: PartitionChoice) -> bool:
    """Whether a spot's maps part its own picture (the default): slabs of the view overlap there, and every map pays for the common ground.

    Schemes with a meaning of their own, and T4 (55) with α by hand, keep their slabs."""
    return partition.scheme.parts_spots and partition.alpha is None and partition.cut != "view" and partition.z_count > 1


def border(clip_from_eye: np.ndarray, error: tuple[float, float], share: float) -> np.ndarray:
    """(1, 4) the plane through the light that parts a map along its worse axis, leaving `share` of it below; its unit normal points up."""
    plane = clip_from_eye[1 if error[1] >= error[0] else 0] - (2.0 * share - 1.0) * clip_from_eye[3]
    return (plane / np.linalg.norm(plane[:3]))[None]


def sections(body: Body, view: np.ndarray) -> np.ndarray:
    """(V, 3) points that stand for the receivers where only the body is known: its corners, and points spread over its cross-sections at
    `SECTIONS` view depths, whose logarithms are evenly spread."""
    corners = body.vertices
    if not len(corners):
        return corners
    depths = corners @ view
    near, far = float(depths.min()), float(depths.max())
    if not 0.0 < near < far:
        return corners
    found = [corners]
    for cut in np.exp(np.linspace(log(near), log(far), SECTIONS + 2))[1:-1]:
        beyond = body.clipped(np.append(view, -cut)).vertices
        rim = beyond[np.abs(beyond @ view - cut) <= 1e-9 * far]
        if len(rim):
            middle = rim.mean(axis=0)
            found += [middle + share * (rim - middle) for share in RINGS]
    return np.concatenate(found)


def pyramid_corners(space: LightSpace, near: float, far: float) -> np.ndarray:
    """(8, 3) corners, relative to the eye, of the pyramid a finite light serves between two distances: for maps that nothing asks."""
    assert space.planes is not None, "a finite light serves a pyramid"
    side = space.planes[:4, :3]
    across = side[0] - side[1], side[2] - side[3]
    u, v = (space.slope * e / np.linalg.norm(e) for e in across)
    return np.array([space.position + d * (space.travel_ws + a * u + b * v) for d in (near, far) for a in (-1.0, 1.0) for b in (-1.0, 1.0)])
