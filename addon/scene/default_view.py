"""The camera and the sun of a scene that has none: CAD files seldom do. numpy only.

A standard view looks from a fixed direction and stands just so far away that everything falls inside the picture: every vertex, or in
large scenes every corner of the instances' boxes. Two opposite sides of what is seen touch the picture's edge (less `BORDER`).
"""

from __future__ import annotations

from math import radians, tan

import numpy as np

from ..errors import SettingsError
from ..maths.frusta import box_corners, box_distances
from ..maths.nearest import distance_to_triangles
from ..maths.spaces import look_at, orthographic, perspective, transform
from ..maths.view import Camera, Light
from .records import Scene

Point = tuple[float, float, float]

# direction from the target to the eye, and the up vector, by view name
VIEWS: dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]] = {
    "iso": ((1.0, -1.0, 0.816496580927726), (0.0, 0.0, 1.0)),
    "front": ((0.0, -1.0, 0.0), (0.0, 0.0, 1.0)),
    "back": ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "left": ((-1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    "right": ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    "top": ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0)),
    "bottom": ((0.0, 0.0, -1.0), (0.0, 1.0, 0.0)),
}
DEFAULT_FOV_Y_RAD = radians(40.0)
BORDER = 0.06  # of half the picture, left free
SLACK = 0.02
AMONG = 1.0 / 2000.0  # of far: an eye nearer to what it sees than that may be among it
INSIDE = 0.1
LEAST_NEAR = 1e-7  # of far
MOST_VERTICES = 2_000_000  # placed vertices up to which a view is framed by vertices rather than by boxes


def _checked_perspective(fov_y_rad: float, aspect: float, near: float, far: float) -> np.ndarray:
    """(4, 4) OpenGL projection; `aspect` = width / height. Raises `SettingsError` where there is none."""
    if not 0.0 < fov_y_rad < np.pi:
        raise SettingsError("The vertical field of view must lie between 0° and 180°.")
    if not 0.0 < near < far < np.inf:
        raise SettingsError("The near distance must be positive and smaller than the far distance.")
    return perspective(0.5 * fov_y_rad, aspect, near, far)


def camera_for_view(
    scene: Scene, size: tuple[int, int], name: str = "iso", fov_y_rad: float = DEFAULT_FOV_Y_RAD, is_orthographic: bool = False
) -> Camera:
    """A camera of `VIEWS` that frames the scene in a picture of `size` (width, height), near and far tight around it.

    Claim: along the fixed direction the eye stands at the smallest distance from which, having been shifted sideways to centre them,
    all `outline_points` lie within 1 − `BORDER` of the picture's half width and height. An orthographic one has the smallest scale that
    shows them so.
    """
    if name not in VIEWS:
        raise SettingsError(f"There is no view '{name}': choose one of {', '.join(VIEWS)}.")
    direction, up = (np.array(v) for v in VIEWS[name])
    bounds_ws = scene.bounds_ws()
    centre = bounds_ws.mean(axis=0)
    rotation = look_at(centre + direction, centre, up)[:3, :3]
    points = outline_points(scene)
    p = (points - centre) @ rotation.T
    aspect = size[0] / size[1]
    if is_orthographic:
        return _parallel(scene, name, rotation, centre, p, aspect)
    slopes = (1.0 - BORDER) * tan(fov_y_rad / 2) * np.array([aspect, 1.0])
    eye_x, eye_y, distance = _closest_eye(p, slopes)
    diagonal = max(float(np.linalg.norm(bounds_ws[1] - bounds_ws[0])), 1e-6)
    distance = max(distance, float(p[:, 2].max()) + 0.01 * diagonal)
    eye = centre + rotation.T @ np.array([eye_x, eye_y, distance])
    view = np.eye(4)
    view[:3, :3], view[:3, 3] = rotation, -rotation @ eye
    near, far = depth_range(view, scene, points)
    return Camera(view, _checked_perspective(fov_y_rad, aspect, near, far), near, far, name)


def _parallel(scene: Scene, name: str, rotation: np.ndarray, centre: np.ndarray, points: np.ndarray, aspect: float) -> Camera:
    """The orthographic view of (P, 3) points that are given in the view's axes from `centre`."""
    low, high = points.min(axis=0), points.max(axis=0)
    half_width, half_height = np.maximum((high - low)[:2] / 2.0, 1e-9) / (1.0 - BORDER)
    slack = max(SLACK * float(np.ptp(points, axis=0).max()), 1e-6)
    view = np.eye(4)
    view[:3, :3] = rotation
    view[:3, 3] = -rotation @ centre - [*((low + high)[:2] / 2.0), high[2] + slack]
    near, far = 0.5 * slack, float(high[2] - low[2]) + 2.0 * slack
    return Camera(view, orthographic(max(half_height, half_width / aspect), aspect, near, far), near, far, name)


def outline_points(scene: Scene) -> np.ndarray:
    """(P, 3) points whose hull holds the scene: all placed vertices, or beyond `MOST_VERTICES` the corners of the instances' boxes."""
    index, matrices = scene.instances.mesh_index, scene.instances.world_from_object
    if sum(len(scene.meshes[i].positions) for i in index) > MOST_VERTICES:
        return box_corners(scene.instance_bounds_ws()).reshape(-1, 3)
    return np.concatenate([scene.meshes[i].positions @ m[:3, :3].T + m[:3, 3] for i, m in zip(index, matrices, strict=True)])


def _closest_eye(points_vs: np.ndarray, slopes: np.ndarray) -> tuple[float, float, float]:
    """Eye (x, y, z) with the smallest z such that |p_x − x| ≤ s_x (z − p_z), and the same in y, for every point.

    Each axis is a wedge: x + s z ≥ max(p_x + s p_z) and −x + s z ≥ max(−p_x + s p_z); the larger of the two heights serves both.
    """
    right = (points_vs[:, :2] + slopes * points_vs[:, 2:]).max(axis=0)
    left = (-points_vs[:, :2] + slopes * points_vs[:, 2:]).max(axis=0)
    distance = float(((right + left) / (2 * slopes)).max())
    x, y = (right - left) / 2
    return float(x), float(y), distance


def depth_range(view_from_world: np.ndarray, scene: Scene, points_ws: np.ndarray | None = None) -> tuple[float, float]:
    """Near and far view depth just around the scene's boxes, or around (N, 3) points that stand for it (`SLACK` more on either side).

    With the eye among them, near is `INSIDE` of the distance to the nearest surface: no lens of less than 168° loses anything by it.
    """
    points = box_corners(scene.instance_bounds_ws()).reshape(-1, 3) if points_ws is None else points_ws
    depth = -(points @ view_from_world[2, :3] + view_from_world[2, 3])
    low, high = float(depth.min()), float(depth.max())
    slack = SLACK * max(high - low, 1e-6)
    near, far = low - slack, max(high + slack, 1e-6)
    if near < far * AMONG:
        eye = -view_from_world[:3, :3].T @ view_from_world[:3, 3]
        near = min(max(INSIDE * nearest_surface_m(scene, eye), far * LEAST_NEAR), 0.5 * far)
    return near, far


def nearest_surface_m(scene: Scene, point_ws: np.ndarray) -> float:
    """Metres from a point (3,) to the nearest triangle; the instances are looked at in the order of their boxes' distances."""
    bounds, best = scene.instance_bounds_ws(), np.inf
    gap = box_distances(bounds, point_ws)
    for row in np.argsort(gap):
        if gap[row] >= best:
            break
        mesh, world = scene.meshes[scene.instances.mesh_index[row]], scene.instances.world_from_object[row]
        best = min(best, distance_to_triangles(point_ws, transform(world, mesh.positions)[mesh.triangles, :3]))
    return best


def camera_from_eye(
    scene: Scene,
    size: tuple[int, int],
    eye: Point,
    target: Point,
    up: Point = (0.0, 0.0, 1.0),
    fov_y_rad: float = DEFAULT_FOV_Y_RAD,
    is_orthographic: bool = False,
) -> Camera:
    """A camera at `eye` that looks at `target`, both in world coordinates as the user knows them (absolute); near and far as for views.

    An orthographic one shows of the plane through the target what the other would.
    """
    view = look_at(np.array(eye) - scene.origin_ws, np.array(target) - scene.origin_ws, np.array(up))
    near, far = depth_range(view, scene)
    if is_orthographic:
        half_height = float(np.linalg.norm(np.subtract(target, eye))) * tan(fov_y_rad / 2)
        return Camera(view, orthographic(half_height, size[0] / size[1], near, far), near, far, "eye")
    return Camera(view, _checked_perspective(fov_y_rad, size[0] / size[1], near, far), near, far, "eye")


def world_sun() -> Light:
    """The sun of a scene without one. It stands in the world, wherever the camera goes: at the upper left of the isometric view."""
    direction, up = (np.array(v) for v in VIEWS["iso"])
    return _upper_left(look_at(direction, np.zeros(3), up)[:3, :3].T)


def default_sun(camera: Camera) -> Light:
    """A sun from the upper left of the view and somewhat behind the eye, never below 25° above the horizon, so that shadows fall to the
    lower right as on a drawing and onto the ground. It turns with the camera."""
    return _upper_left(camera.world_from_view[:3, :3])


def _upper_left(world_from_view: np.ndarray) -> Light:
    towards = world_from_view @ np.array([-0.62, 0.62, 0.48])
    towards /= np.linalg.norm(towards)
    lowest = np.sin(radians(25.0))
    if towards[2] < lowest:
        flat = np.array([towards[0], towards[1], 0.0])
        length = float(np.linalg.norm(flat))
        flat = flat / length if length > 1e-6 else np.array([-1.0, 0.0, 0.0])
        towards = flat * np.cos(radians(25.0)) + np.array([0.0, 0.0, lowest])
    return Light("sun", towards / np.linalg.norm(towards), name="default sun")
