"""Impostors as shadow casters: captured once from the light, then drawn into its maps instead of their triangles. Worker thread only.

The light's rays are the capture's own, whatever the map's warp: a texel covers the same rays for ever, so the texture neither warps nor
tears while the camera moves; it is renewed when the object or the light moves. What it costs is precision: a caster's edge is known to half
a texel of the capture, its depth as a plane per texel. Not for logarithmic maps and tests that store ids or several depths, nor for what
is far larger than a map: these get the triangles.
"""

from __future__ import annotations

import logging
from collections.abc import Hashable
from dataclasses import dataclass, replace

import moderngl
import numpy as np

from ...errors import DriverError, GpuError, SceneError
from ...maths import spaces
from ...maths.relief.frame import capture_frame
from ...maths.shadow.cut import are_large
from ...maths.shadow.projection import ShadowPlan
from ...maths.view import Camera, Light
from ...scene.records import Scene
from ..device import Device
from ..geometry.draw_list import DrawList
from ..gl.gl_raw import GL_DEPTH_CLAMP
from ..passes.shadow import ShadowMaps
from .capture import ImpostorTextures, capture, fingerprint
from .draw import draw_caster
from .life import ImpostorFrame
from .records import ImpostorChoice, Part, parts_of

log = logging.getLogger(__name__)
HULL_MARGIN = 1.02
"""The light's view is so much wider than the object."""


@dataclass(frozen=True, eq=False)
class ImpostorCasters:
    """Who casts how in a frame: `rows` (I,) bool are drawn as triangles, `textures` stand for the others."""

    rows: np.ndarray
    textures: tuple[ImpostorTextures, ...]

    def draw(self, device: Device, maps: ShadowMaps, plan: ShadowPlan) -> None:
        """Draw the textures over what the maps hold."""
        if not self.textures:
            return
        device.context.enable_only(moderngl.DEPTH_TEST)
        device.context.enable_direct(GL_DEPTH_CLAMP)
        for projection, framebuffer in zip(plan.projections, maps.framebuffers, strict=True):
            if not projection.is_empty:
                framebuffer.use()
                for textures in self.textures:
                    draw_caster(device, textures, projection.clip_from_world, (maps.size, maps.size))
        device.context.disable_direct(GL_DEPTH_CLAMP)


class CasterLibrary:
    """The captures from the light of one device's impostors. `update` once per frame; `release` with the device."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._kept: dict[Hashable, tuple[tuple, ImpostorTextures]] = {}

    def update(
        self,
        scene: Scene,
        draw_list: DrawList,
        light: Light,
        maps: ShadowMaps,
        plan: ShadowPlan,
        choice: ImpostorChoice,
        frame: ImpostorFrame,
    ) -> ImpostorCasters:
        """Capture what is missing, within the life's limit of captures per picture. Groups drawn as geometry cast as geometry."""
        wanted = [group for group, report in zip(choice.groups, frame.reports, strict=True) if report.stage != "geometry"]
        if maps.ids_kind or maps.cells is not None or any(p.log is not None for p in plan.projections):
            wanted = []
        for key in [key for key in self._kept if key not in {group.key for group in wanted}]:
            self._kept.pop(key)[1].release()
        rows, textures, room = np.ones(len(scene.instances), bool), [], choice.settings.regenerations
        for part in parts_of(scene, wanted):
            if _is_too_large(part.hull_ws, plan):
                continue
            mark = _mark(light, maps.size), fingerprint(draw_list, part.rows)
            if self._kept.get(part.group.key, (None,))[0] != mark:
                room -= 1
                if room < 0 or not part.triangles or not self._capture(draw_list, part, light, maps.size, choice, mark):
                    continue
            textures.append(self._kept[part.group.key][1])
            rows &= ~part.rows
        return ImpostorCasters(rows, tuple(textures))

    def _capture(self, draw_list: DrawList, part: Part, light: Light, map_size: int, choice: ImpostorChoice, mark: tuple) -> bool:
        """Capture a group from the light; False where that is not possible."""
        key, former = part.group.key, self._kept.pop(part.group.key, None)
        if former is not None:
            former[1].release()
        try:
            camera = light_camera(light, part.hull_ws)
            projection = "orthographic" if light.kind == "sun" else "perspective"
            laid = replace(choice.settings, projection=projection, texels_per_pixel=0.5)
            textures = capture(
                self._device, draw_list, part.rows, capture_frame(part.hull_ws, camera, (map_size, map_size), laid), with_back=False
            )
        except DriverError:
            raise
        except (SceneError, GpuError) as error:
            log.info("%s casts by its triangles: %s", part.group.name or "an impostor", error)
            return False
        self._kept[key] = mark, textures
        return True

    def release(self) -> None:
        """Free everything."""
        for _, textures in self._kept.values():
            textures.release()
        self._kept.clear()


def casters_of(device: Device) -> CasterLibrary:
    """The device's casters, made on first use and released with it."""
    return device.attached("impostor casters", lambda: CasterLibrary(device))


def light_camera(light: Light, hull_ws: np.ndarray) -> Camera:
    """The light's view of an object: its rays, a square picture that the object just fills.

    Raises `SceneError` when a light with a position stands within the object's bounds.
    """
    middle = (hull_ws.max(axis=0) + hull_ws.min(axis=0)) / 2.0
    radius = float(np.linalg.norm(hull_ws - middle, axis=1).max())
    if light.kind == "sun":
        distance = 2.0 * max(radius, 1e-9)
        eye = middle + distance * np.asarray(light.direction_ws)
        near, far = distance - 1.5 * radius, distance + 1.5 * radius
        lens = spaces.orthographic(HULL_MARGIN * radius, 1.0, near, far)
    else:
        eye = np.asarray(light.position_ws, float)
        distance = float(np.linalg.norm(middle - eye))
        if not distance > 1.05 * radius:
            raise SceneError("The light stands within the impostor's bounds: its geometry casts the shadow.")
        near, far = distance - radius, distance + radius
        lens = spaces.perspective(HULL_MARGIN * float(np.arcsin(radius / distance)), 1.0, near, far)
    return Camera(spaces.look_at(eye, middle), lens, near, far, name="light")


def _is_too_large(hull_ws: np.ndarray, plan: ShadowPlan) -> bool:
    """Whether a texture laid over the hull (8, 3) would reach farther beyond a map than float32 can draw: it casts as geometry."""
    bounds = np.stack([hull_ws.min(axis=0), hull_ws.max(axis=0)])[None]
    extent = np.linalg.norm(bounds[:, 1] - bounds[:, 0], axis=1)
    return any(bool(are_large(p, bounds, extent).any()) for p in plan.projections if not p.is_empty)


def _mark(light: Light, map_size: int) -> tuple:
    """What must stay equal for a capture from the light to stay valid, beside the object."""
    vector = light.direction_ws if light.kind == "sun" else light.position_ws
    return light.kind, np.asarray(vector, float).tobytes(), map_size
