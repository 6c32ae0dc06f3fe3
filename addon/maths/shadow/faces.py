"""Face partitioning for the sun: the side faces of the view frustum, each with a map and a warp of its own (T4 §4.3.1, LogPSM §5.1).

The light looks at the pyramid of the view from one side; its four edges are four rays from the image of the eye. Between the edges of a
face lies its sector. Every light ray leaves (or enters) the pyramid through one side face turned away from (or to) the light, so the
sectors of those faces cover the view once: up to four when the light shines along the view, never the others. Sectors start in the eye,
so they hold the near plane too (T4's elongation). They are told apart by planes through the eye that contain the light's direction.

Shear (LogPSM §5.1.5): the warp's axis is the bisector of the sector (coordinate-frame adjustment); the angle of P is limited
(τ-limiting, `face_parameter`); a sector wider than τ₀ is split along its bisector, eased in over [τ₀, τ₁]: what each half is fitted to
goes from the whole sector to that half, and its axis with it. Three sectors can be wider than τ₀; the two widest are split, from the
third's width on, so that six maps suffice and none of them changes when another sector becomes one of the two.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, pi, radians, sin, tan

import numpy as np

from ..frusta import frustum_corners
from ..spaces import smoothstep
from ..view import Camera, Light
from .light_space import LightSpace, sun_space

SPLIT_FROM = radians(100.0)  # τ₀ of LogPSM §5.1.5.3
SPLIT_UNTIL = radians(130.0)  # τ₁
WIDEST = radians(90.0)  # largest angle of P (τ of §5.1.5.2)
COUNT = 6  # four faces, two halves
ELONGATION = 0.5  # least distance of the apex before the elongation, as a share of the elongation
LEAST_SIZE = 0.1  # a vanishing sector's map keeps this share of the slab's size, so that its texels do not vanish
EDGE_ON = 1e-9  # a face seen this much edge on (as a sine) has no sector
NOTHING = np.array([[0.0, 0.0, 0.0, -1.0]])  # a plane that no point is inside of

_EDGES = ((2, 0), (1, 3), (0, 1), (3, 2))  # left, right, bottom, top: the corners (2 y + x) of each face


@dataclass(frozen=True, eq=False)
class Sector:
    """The part of the light's image that one map serves, as angles about the image of the eye.

    `face` 0 … 3 = left, right, bottom, top; `select` (P, 4) planes relative to the eye that choose its receivers, `fit` those it is fitted
    to; `axis_ws` (3,) the warp's axis across the light; `rise` metres along the axis per metre of view depth, on the face.
    """

    face: int
    select: np.ndarray
    fit: np.ndarray
    axis_ws: np.ndarray
    rise: float


def face_spaces(camera: Camera, light: Light) -> list[tuple[int, LightSpace]]:
    """Six (face, space), always in the same places: the four faces, then the second halves of split ones; what is not there serves nothing.

    Domain: a perspective camera, a sun.
    """
    base = sun_space(light, camera)
    towards = np.asarray(light.direction_ws, np.float64)
    slots = [(face if face < 4 else -1, replace(base, planes=NOTHING, select=NOTHING, rise=1.0)) for face in range(COUNT)]
    taken = set()
    for sector in _sectors(camera, towards):
        z = sector.axis_ws
        from_eye = np.eye(4)
        from_eye[:3, :3] = np.cross(towards, z), towards, z
        halves = (4, 5) if sector.face % 2 == 0 else (5, 4)  # mostly the same place while another face's halves come and go
        slot = next(k for k in (sector.face, *halves) if k not in taken)
        taken.add(slot)
        slots[slot] = sector.face, replace(base, from_eye=from_eye, planes=sector.fit, select=sector.select, rise=sector.rise)
    return slots


def face_parameter(parameter: float, hull: np.ndarray, view_range: tuple[float, float], rise: float, least: float) -> float:
    """n' of a face's map from the method's n' for light ⟂ view (LogPSM 5.15): the apex lies n' · rise before the face's near edge.

    Not less than these. `ELONGATION` of the way from the hull's start to that edge, which T4's elongation adds. What keeps P as narrow as
    `WIDEST` (τ-limiting). What keeps f'/n' at the method's, over that elongation, where the face is seen edge on (`least`: the map's side).
    """
    near, far = view_range
    start, depth = float(hull[:, 2].min()), float(np.ptp(hull[:, 2]))
    wanted = start - rise * (near - parameter)
    elongation = ELONGATION * max(0.0, rise * near - start)
    narrow = float(np.abs(hull[:, 0]).max()) / tan(0.5 * WIDEST) - depth
    edge_on = ELONGATION * max(depth, least) * parameter / (far - near)
    return max(wanted, elongation, narrow, edge_on)


def _sectors(camera: Camera, towards: np.ndarray) -> list[Sector]:
    """The faces turned away from the light (light ahead) or to it (light behind), wide ones in two halves."""
    corners = frustum_corners(camera, 1.0, 2.0)[:4]
    forward = towards if towards @ camera.direction_ws >= 0.0 else -towards
    middle = corners.mean(axis=0)
    facing = {}  # face → how far it is turned away from `forward`; the middle of the view lies on the negative side
    for face, (a, b) in enumerate(_EDGES):
        normal = np.cross(corners[a], corners[b])
        facing[face] = float((normal @ forward) * (normal @ middle)) / float(normal @ normal)
    taking_part = [face for face, value in facing.items() if value > EDGE_ON]
    image = _Image(towards)
    widths = {face: abs(image.between(corners[_EDGES[face][0]], corners[_EDGES[face][1]])) for face in taking_part}
    split_from = max([SPLIT_FROM, *sorted(widths.values(), reverse=True)[COUNT - 4 :]])
    out = []
    for face in taking_part:
        a, b = _EDGES[face]
        shared = [_neighbour(face, a) in taking_part, _neighbour(face, b) in taking_part]
        out += _of_face(image, face, corners[a], corners[b], shared, split_from)
    return out


def _neighbour(face: int, corner: int) -> int:
    """The other face at a corner."""
    return next(other for other, edges in enumerate(_EDGES) if other != face and corner in edges)


class _Image:
    """Angles and directions across the light."""

    def __init__(self, towards: np.ndarray) -> None:
        first = np.cross(towards, np.eye(3)[np.argmin(np.abs(towards))])
        self.u = first / np.linalg.norm(first)
        self.v = np.cross(towards, self.u)

    def angle(self, direction: np.ndarray) -> float:
        """Azimuth of a direction's image."""
        return float(np.arctan2(direction @ self.v, direction @ self.u))

    def between(self, a: np.ndarray, b: np.ndarray) -> float:
        """Signed angle from the image of `a` to that of `b`, in [−180°, 180°)."""
        return (self.angle(b) - self.angle(a) + pi) % (2.0 * pi) - pi

    def direction(self, angle: float) -> np.ndarray:
        """(3,) unit vector of an azimuth."""
        return cos(angle) * self.u + sin(angle) * self.v

    def side(self, angle: float, towards: float) -> np.ndarray:
        """(4,) plane through the eye and the azimuth's ray, containing the light; inside is where azimuths turn `towards` (±1)."""
        return np.append(towards * (cos(angle) * self.v - sin(angle) * self.u), 0.0)


def _of_face(image: _Image, face: int, a: np.ndarray, b: np.ndarray, shared: list[bool], split_from: float) -> list[Sector]:
    """One sector, or two halves if wider than `split_from`, between the images of the edges a and b. Only edges shared with another sector
    are planes."""
    start, tau = image.angle(a), image.between(a, b)
    turn = 1.0 if tau >= 0.0 else -1.0
    ends = [image.side(start, turn), image.side(start + tau, -turn)]
    outer = [plane for plane, is_shared in zip(ends, shared, strict=True) if is_shared]
    if abs(tau) <= split_from:
        planes = np.array(outer).reshape(-1, 4)
        return [Sector(face, planes, planes, image.direction(start + 0.5 * tau), _rise(image, a, b, start, tau))]
    ease = smoothstep((abs(tau) - split_from) / (SPLIT_UNTIL - SPLIT_FROM))
    bisector = start + 0.5 * tau
    halves = []
    for k, sign in ((0, -turn), (1, turn)):
        own = [ends[k]] if shared[k] else []
        other = [] if ease >= 1.0 or not shared[1 - k] else [ends[1 - k]]
        reach = 0.5 * tau * (1.0 - 0.5 * ease)  # half the angle that it is fitted to
        middle = start + reach if k == 0 else start + tau - reach
        cut = image.side(middle + (reach if k == 0 else -reach), sign)
        select = np.array([*own, image.side(bisector, sign)])
        rise = _rise(image, a, b, middle - reach, 2.0 * reach)
        halves.append(Sector(face, select, np.array([*own, *other, cut]), image.direction(middle), rise))
    return halves


def _rise(image: _Image, a: np.ndarray, b: np.ndarray, start: float, tau: float) -> float:
    """Mean advance along the bisector, per metre of view depth, of the face's points at the ends of [start, start + tau]."""
    axis = image.direction(start + 0.5 * tau)
    out = []
    for angle in (start, start + tau):
        across = np.append(-sin(angle), cos(angle))
        ha, hb = (float(across @ (p @ image.u, p @ image.v)) for p in (a, b))
        share = float(np.clip(ha / (ha - hb), 0.0, 1.0)) if abs(ha - hb) > 1e-12 else 0.5
        out.append(float((a + share * (b - a)) @ axis))
    return max(0.5 * sum(out), 1e-6)
