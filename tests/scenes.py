"""Small scenes, each built to provoke one failure of shadow maps; numpy only, no Blender. All in metres, Z up, floor at z = 0."""

from __future__ import annotations

import numpy as np

from addon.maths import spaces
from addon.maths.view import Camera, Light
from addon.scene.records import Instances, Mesh, Scene

Part = tuple[np.ndarray, np.ndarray]

BOX_CORNERS = np.array([[x, y, z] for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)])
BOX_QUADS = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))


def quads(corners: np.ndarray, faces: tuple[tuple[int, int, int, int], ...]) -> Part:
    """Flat-shaded quads: every face has vertices of its own. Positions (4F, 3), triangles (2F, 3)."""
    positions = np.concatenate([corners[list(face)] for face in faces]).astype(np.float64)
    first = 4 * np.arange(len(faces))[:, None]
    return positions, np.concatenate([first + [0, 1, 2], first + [0, 2, 3]])


def box(low: tuple[float, float, float], high: tuple[float, float, float]) -> Part:
    """A closed axis-aligned box, wound outwards."""
    low, high = np.array(low), np.array(high)
    return quads(low + BOX_CORNERS * (high - low), BOX_QUADS)


def sheet(a: tuple, b: tuple, c: tuple, d: tuple) -> Part:
    """One open quad a b c d, wound counterclockwise seen from its front."""
    return quads(np.array([a, b, c, d], dtype=np.float64), ((0, 1, 2, 3),))


def floor(half: float = 10.0, z: float = 0.0) -> Part:
    """A square floor that faces up."""
    return sheet((-half, -half, z), (half, -half, z), (half, half, z), (-half, half, z))


def rod(a: tuple[float, float, float], b: tuple[float, float, float], radius: float, sides: int = 8) -> Part:
    """A prism without caps between two points (open, like much of CAD)."""
    a, b = np.array(a, dtype=np.float64), np.array(b, dtype=np.float64)
    axis = (b - a) / np.linalg.norm(b - a)
    u = np.cross(axis, [1.0, 0.0, 0.0] if abs(axis[0]) < 0.9 else [0.0, 1.0, 0.0])
    u /= np.linalg.norm(u)
    angle = np.arange(sides) * 2.0 * np.pi / sides
    ring = radius * (np.cos(angle)[:, None] * u + np.sin(angle)[:, None] * np.cross(axis, u))
    corners = np.concatenate([a + ring, b + ring])
    return quads(corners, tuple((i, (i + 1) % sides, sides + (i + 1) % sides, sides + i) for i in range(sides)))


def ball(centre: tuple[float, float, float], radius: float, segments: int = 48, rings: int = 24) -> Part:
    """A closed sphere of flat quads (degenerate at the poles, so the poles are triangles)."""
    phi, theta = np.linspace(0.0, 2.0 * np.pi, segments + 1)[:-1], np.linspace(0.0, np.pi, rings + 1)
    unit = np.stack(
        [
            np.sin(theta)[:, None] * np.cos(phi),
            np.sin(theta)[:, None] * np.sin(phi),
            np.broadcast_to(np.cos(theta)[:, None], (rings + 1, segments)),
        ],
        axis=-1,
    )
    positions = (np.array(centre) + radius * unit).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(rings), np.arange(segments), indexing="ij")
    a, b = i * segments + j, i * segments + (j + 1) % segments
    upper, lower = np.stack([a, a + segments, b], axis=-1), np.stack([b, a + segments, b + segments], axis=-1)
    return positions, np.concatenate([upper[1:].reshape(-1, 3), lower[:-1].reshape(-1, 3)])


def joined(*parts: Part) -> Part:
    """Several parts as one."""
    offsets = np.cumsum([0, *(len(p) for p, _ in parts)])
    return np.concatenate([p for p, _ in parts]), np.concatenate([t + o for (_, t), o in zip(parts, offsets, strict=False)])


def scene_of(*parts: Part, matrices: list[np.ndarray] | None = None) -> Scene:
    """One object per part, flat normals, clay colours."""
    meshes = []
    for index, (positions, triangles) in enumerate(parts):
        corners = positions[triangles]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        meshes.append(
            Mesh(
                ("tests.scenes", index, hash(corners.tobytes())),
                corners.reshape(-1, 3),
                np.repeat(normal, 3, axis=0),
                np.arange(3 * len(corners)).reshape(-1, 3),
            )
        )
    count = len(meshes)
    placed = np.stack(matrices) if matrices else np.broadcast_to(np.eye(4), (count, 4, 4))
    instances = Instances(np.arange(count), placed, np.arange(count), np.zeros(count), np.tile([0.6, 0.6, 0.6, 1.0], (count, 1)))
    return Scene(tuple(meshes), instances, tuple(f"part {i}" for i in range(count)), np.zeros(3))


def closed_box() -> Scene:
    """A box that stands on a floor: contact shadow, detached shadow."""
    return scene_of(floor(), box((-1.0, -1.0, 0.0), (1.0, 1.0, 2.0)))


def railing(length: float = 8.0, spacing: float = 0.5, radius: float = 0.02) -> Scene:
    """Posts and two rails of 4 cm: very thin parts."""
    posts = [rod((x, 0.0, 0.0), (x, 0.0, 1.1), radius, 6) for x in np.arange(-length / 2, length / 2 + 1e-9, spacing)]
    rails = [rod((-length / 2, 0.0, z), (length / 2, 0.0, z), radius, 6) for z in (0.55, 1.1)]
    return scene_of(floor(), joined(*posts, *rails))


def open_sheet() -> Scene:
    """A tilted sheet without thickness above a floor; its front faces down, so the camera and an overhead light see its back."""
    return scene_of(floor(), sheet((-1.5, 1.0, 1.2), (1.5, 1.0, 1.2), (1.5, -1.0, 0.6), (-1.5, -1.0, 0.6)))


def doubled_sheet() -> Scene:
    """Two coincident sheets back to back: a two-sided surface as CAD writes it."""
    a, b, c, d = (-1.5, 1.0, 1.2), (1.5, 1.0, 1.2), (1.5, -1.0, 0.6), (-1.5, -1.0, 0.6)
    return scene_of(floor(), joined(sheet(a, b, c, d), sheet(d, c, b, a)))


def coincident_boxes() -> Scene:
    """Two boxes that share a face and lie partly in the same planes, and a plate that lies exactly in the floor: assemblies touch."""
    plate = sheet((-3.0, -3.0, 0.0), (-1.5, -3.0, 0.0), (-1.5, 3.0, 0.0), (-3.0, 3.0, 0.0))
    return scene_of(floor(), box((-1.0, -1.0, 0.0), (0.0, 1.0, 1.5)), box((0.0, -1.0, 0.0), (1.0, 0.5, 1.5)), plate)


def chair() -> Scene:
    """Rods and a seat (IDD's object): shadows of the seat on the legs, of the back on the seat, and of all on the floor."""
    legs = [rod((x, y, 0.0), (x, y, 0.45), 0.02) for x in (-0.2, 0.2) for y in (-0.2, 0.2)]
    back = [rod((x, 0.2, 0.49), (x, 0.26, 0.95), 0.015) for x in np.linspace(-0.2, 0.2, 5)]
    top = rod((-0.22, 0.26, 0.95), (0.22, 0.26, 0.95), 0.02)
    return scene_of(floor(4.0), joined(box((-0.23, -0.23, 0.45), (0.23, 0.23, 0.49)), *legs, *back, top))


def border_floor(length: float = 200.0, count: int = 40) -> Scene:
    """A long floor with a row of posts along the view (y): every partition border crosses lit and shaded floor."""
    ground = sheet((-20.0, -5.0, 0.0), (20.0, -5.0, 0.0), (20.0, length, 0.0), (-20.0, length, 0.0))
    posts = [box((x - 0.3, y - 0.3, 0.0), (x + 0.3, y + 0.3, 4.0)) for y in np.linspace(2.0, length - 2.0, count) for x in (-4.0, 4.0)]
    return scene_of(ground, joined(*posts))


def staircase(steps: int = 12) -> Scene:
    """Steps of 18 × 28 cm: many concave corners where light leaks and contact shadows detach."""
    return scene_of(floor(), joined(*(box((-1.0, 0.28 * i, 0.0), (1.0, 0.28 * (i + 1), 0.18 * (i + 1))) for i in range(steps))))


def sphere(segments: int = 24) -> Scene:
    """A ball on a floor: every slope to the light at once."""
    return scene_of(floor(), ball((0.0, 0.0, 1.0), 1.0, segments, segments // 2))


def calibration_cards(
    camera: Camera, light_direction_ws: np.ndarray, distances: np.ndarray, size_px: float = 0.02, spread: float = 1.0
) -> Scene:
    """Cards near the view axis that face the mid direction of eye and light (no projection aliasing), side by side so that all are seen.

    `distances` view depths; `size_px` half the edge of a card and `spread` the room they all take side by side, as shares of the picture's
    height at their depth.
    """
    cards = []
    for index, distance in enumerate(distances):
        height = 2.0 * distance / camera.clip_from_view[1, 1]
        aside = spread * (index - (len(distances) - 1) / 2.0) / max(len(distances), 1)
        centre = camera.eye_ws + camera.direction_ws * distance + camera.world_from_view[:3, 0] * (aside * height)
        to_eye = camera.eye_ws - centre
        middle = to_eye / np.linalg.norm(to_eye) + light_direction_ws
        middle /= np.linalg.norm(middle)
        u = np.cross(middle, camera.world_from_view[:3, 1])
        u /= np.linalg.norm(u)
        v = np.cross(middle, u)
        half = size_px * height
        cards.append(sheet(*(tuple(centre + half * (a * u + b * v)) for a, b in ((-1, 1), (1, 1), (1, -1), (-1, -1)))))
    return scene_of(*cards)


def look_at(eye: tuple, target: tuple, fov_y_deg: float = 50.0, near: float = 0.1, far: float = 100.0) -> Camera:
    """A perspective camera at `eye` looking at `target`, Z up, 16:9."""
    return Camera(spaces.look_at(eye, target), spaces.perspective(np.radians(fov_y_deg) / 2.0, 16.0 / 9.0, near, far), near, far)


def sun(elevation_deg: float, azimuth_deg: float = 30.0) -> Light:
    """A sun at that elevation above the horizon, azimuth from +x towards +y."""
    e, a = np.radians([elevation_deg, azimuth_deg])
    return Light("sun", np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)]))
