"""An orbit: a camera goes round a scene once, and the sun passes through its view axis, behind it and ahead of it."""

import numpy as np

from addon.maths.shadow.fit import plan_shadows
from addon.maths.shadow.projection import ShadowPlan
from addon.maths.spaces import look_at, perspective
from addon.maths.view import Camera, Light
from addon.scene.records import Scene
from addon.settings.groups import Settings
from tests import scenes
from tests.maths.shadow.fit_rigs import texel_sizes

SIZE, MAP = (64, 36), 512
NEAR, FAR = 1.0, 100.0
STEP_DEG = 1.0


def camera_at(angle_deg: float) -> Camera:
    """The orbit: level round the scene's middle, so that the sun, level too, is on the view axis at 0° (behind) and 180° (ahead)."""
    a = np.radians(angle_deg)
    eye = 30.0 * np.array([np.cos(a), np.sin(a), 0.0]) + [0.0, 0.0, 1.0]
    return Camera(look_at(eye, (0.0, 0.0, 1.0)), perspective(np.radians(25.0), SIZE[0] / SIZE[1], NEAR, FAR), NEAR, FAR)


def sun_at(elevation_deg: float = 0.0) -> Light:
    """The sun, level or so many degrees above the view axis where it passes it."""
    e = np.radians(elevation_deg)
    return Light("sun", np.cos(e) * -camera_at(0.0).direction_ws + [0.0, 0.0, np.sin(e)])


SUN = sun_at()


def orbited_scene() -> Scene:
    """A floor with three boxes: about as deep as the view, f/n = 100."""
    boxes = (((-1, -1, 0), (1, 1, 2)), ((4, -9, 0), (6, -7, 5)), ((-12, 3, 0), (-11, 14, 3)))
    return scenes.scene_of(scenes.floor(20.0), *(scenes.box(*corners) for corners in boxes))


def plan_at(
    scene: Scene, angle_deg: float, warp: str, fit: str, sun: Light = SUN, receivers_ws: np.ndarray | None = None, **partition: object
) -> ShadowPlan:
    """The default partitioning, or another, at one place of the orbit."""
    s = Settings().replaced(warp={"kind": warp}, fit={"kind": fit, "size": MAP}, partition=partition)
    return plan_shadows(
        camera_at(angle_deg),
        sun,
        s.warp,
        s.partition,
        s.fit,
        receivers_ws=receivers_ws,
        scene_bounds_ws=scene.bounds_ws(),
        caster_bounds_ws=scene.instance_bounds_ws(),
        image_size=SIZE,
    )


def sizes_by_face(plan: ShadowPlan, sun: Light, slices: int = 1) -> dict[tuple[int, int], list[np.ndarray]]:
    """Texel sizes (3,) of the maps that are not empty, by face and slice; without faces every map has a place of its own."""
    found: dict[tuple[int, int], list[np.ndarray]] = {}
    for i, (p, size) in enumerate(zip(plan.projections, texel_sizes(plan, sun, MAP), strict=True)):
        if not np.isnan(size[0]):
            found.setdefault((p.face, i % slices if p.face >= 0 else i), []).append(size)
    return found


def jump(before: np.ndarray, after: np.ndarray) -> float:
    """The largest ratio of texel sizes."""
    assert np.isfinite(before).all() and np.isfinite(after).all()
    return float(np.exp(np.abs(np.log(after / before)).max()))


def largest_jump(last: dict[tuple[int, int], list[np.ndarray]], now: dict[tuple[int, int], list[np.ndarray]]) -> float:
    """The largest jump of any map. A wide face has two maps: then it is the least towards one of that face and slice before it."""
    return max((min(jump(before, after) for before in last[key]) for key in now.keys() & last.keys() for after in now[key]), default=1.0)
