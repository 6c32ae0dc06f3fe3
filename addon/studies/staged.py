"""A job with its sections cut and its ground laid: the scene as it is drawn. Used by every face; no bpy.

What was made of a scene last is kept with it, so that one view after another gets the same scene.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np

from ..errors import SceneError
from ..maths.depth_projection import view_depths
from ..maths.spaces import with_depth_range
from ..maths.view import Camera
from ..scene.ground import ground_height, with_ground
from ..scene.looks import GROUND, HIDDEN
from ..scene.records import Scene
from ..scene.section.cut import cut

if TYPE_CHECKING:
    from ..pipeline.job import Job
    from ..settings.groups import Settings

ALL_CUT = "The sections cut everything away: move a section plane, or turn it round."
BEFORE = 0.2  # of the distance of the model, from which on ground is seen before it
NO_IMPOSTORS = "With sections on, impostors are drawn as geometry."

_staged: WeakKeyDictionary[Scene, tuple[tuple, Scene]] = WeakKeyDictionary()


def key_of(scene: Scene, camera: Camera, settings: Settings) -> tuple | None:
    """What the staged scene depends on beside the scene; None where it is the scene itself."""
    section, height = settings.section, _height(scene, camera, settings)
    if not section.planes and height is None:
        return None
    return section.planes, section.caps != "none", section.casts_whole, height


def is_ready(scene: Scene, camera: Camera, settings: Settings) -> bool:
    """Whether `staged` will find everything made."""
    key = key_of(scene, camera, settings)
    return key is None or (scene in _staged and _staged[scene][0] == key)


def staged(job: Job) -> Job:
    """The job with its sections cut and its ground laid. Raises `SceneError` when nothing is left."""
    key = key_of(job.scene, job.camera, job.settings)
    if key is None:
        return job
    made = prepared(job.scene, key)
    if not ((made.instances.flags & (HIDDEN | GROUND)) == 0).any():
        raise SceneError(ALL_CUT)
    is_cut = bool(job.settings.section.planes)
    warnings = [*job.warnings, *made.warnings[len(job.scene.warnings) :]]
    if is_cut and job.impostors is not None:
        warnings.append(NO_IMPOSTORS)
    shown = np.append(job.shown, True) if job.shown is not None and not is_cut else None
    return replace(job, scene=made, shown=shown, impostors=None if is_cut else job.impostors, warnings=tuple(warnings))


def prepared(scene: Scene, key: tuple) -> Scene:
    """The staged scene of that key; kept. Callable from any thread."""
    kept = _staged.get(scene)
    if kept is None or kept[0] != key:
        kept = _staged[scene] = key, _made(scene, *key)
    return kept[1]


def _made(scene: Scene, planes: tuple[float, ...], has_caps: bool, casts_whole: bool, height: float | None) -> Scene:
    made = cut(scene, planes, has_caps=has_caps, casts_whole=casts_whole) if planes else scene
    return made if height is None or not len(made.instances) else with_ground(made, height, scene.bounds_ws())


def _height(scene: Scene, camera: Camera, settings: Settings) -> float | None:
    """Of the ground over the scene's origin; None where there is none, or the camera looks at it from below."""
    choice = settings.ground
    if choice.kind == "off":
        return None
    height = ground_height(scene) if choice.kind == "auto" else choice.height - float(scene.origin_ws[2])
    is_above = camera.direction_ws[2] < 0.0 if camera.is_orthographic else camera.eye_ws[2] > height
    return height if is_above else None


def seeing_ground(camera: Camera, scene: Scene) -> Camera:
    """A camera whose near and far were put round the model, so that it also sees the ground of a staged scene."""
    if scene.ground is None:
        return camera
    low, high = view_depths(camera, scene.instance_bounds_ws()[-1:])
    far = max(camera.far, 1.01 * float(high[0]))
    near = min(camera.near, float(low[0])) if camera.is_orthographic else BEFORE * camera.near
    return replace(camera, clip_from_view=with_depth_range(camera.clip_from_view, near, far, camera.is_orthographic), near=near, far=far)
