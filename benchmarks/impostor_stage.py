"""What the impostor benchmark looks at: a model alone, seen from an orbit, captured, drawn, and asked what a capture has never seen."""

from __future__ import annotations

from functools import cache
from math import asin, radians
from pathlib import Path

import numpy as np

from addon.maths import spaces
from addon.maths.relief.frame import capture_frame, tilt_rad
from addon.maths.relief.settings import ImpostorSettings
from addon.maths.relief.warp import shift_unit
from addon.maths.shadow.fit import plan_shadows
from addon.maths.shadow.projection import ShadowPlan
from addon.maths.view import Camera, Light
from addon.pipeline.device import Device
from addon.pipeline.gl.readback import read_texture
from addon.pipeline.impostors.capture import ImpostorTextures, capture
from addon.pipeline.impostors.draw import draw_impostor
from addon.pipeline.impostors.views import DrawnImpostor
from addon.pipeline.passes.gbuffer import GBuffer, draw_gbuffer, pixel_rays
from addon.pipeline.passes.shadow import ShadowMaps, draw_shadow_maps
from addon.scene.cad import read
from addon.scene.records import Instances, Mesh, Scene
from addon.settings.groups import Settings
from tests.from_cad import scene_from_model

CAD_DEV = Path(__file__).resolve().parents[2] / "shared" / "cad" / "dev"
MODELS = (
    "featuretype.step",
    "hand_wheel_valve.ply",
    "robile_housing.obj",
    "cycloidal_drive_mm.glb",
    "amazing_hand.glb",
    "tower_crane.glb",
    "duplex_house.obj",
    "industrial_ladder.obj",
    "tray_bottom_mm.stl",
    "huldra_utilities.glb",
    "iea15_floating_turbine.stl",
)
SAMPLES = 4
HELD_TEXELS = 2.0
LIT = Settings().replaced(fit={"kind": "scene", "size": 1024}, partition={"kind": "none"}, test={"kind": "triangle"})
"""With shadows, of the exact test: what is wrong is the impostor's."""


@cache
def load(name: str) -> Scene:
    """A dev model as a scene."""
    return scene_from_model(read(CAD_DEV / name))


def ball_scene(rings: int) -> Scene:
    """A ball of about 2·rings² triangles."""
    theta, phi = np.linspace(0.01, np.pi - 0.01, rings + 1), np.linspace(0, 2 * np.pi, rings + 1)
    t, p = np.meshgrid(theta, phi, indexing="ij")
    points = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(rings), np.arange(rings), indexing="ij")
    a = (i * (rings + 1) + j).ravel()
    triangles = np.concatenate([np.stack([a, a + rings + 1, a + 1], axis=1), np.stack([a + 1, a + rings + 1, a + rings + 2], axis=1)])
    mesh = Mesh(("ball", rings), points, points, triangles)
    placing = Instances(np.zeros(1), np.eye(4)[None], np.zeros(1), np.zeros(1), np.full((1, 4), 0.7))
    return Scene((mesh,), placing, ("ball",), np.zeros(3))


class Stage:
    """One scene on one device (None: cameras and light only)."""

    def __init__(self, device: Device | None, scene: Scene) -> None:
        self.device, self.scene = device, scene
        self.draw_list = device.store.sync(scene) if device is not None else None
        box = scene.bounds_ws()
        self.hull = np.array([[box[i][0], box[j][1], box[k][2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
        self.middle, self.radius = box.mean(axis=0), float(np.linalg.norm(box[1] - box[0]) / 2)
        self.rows = np.ones(len(scene.instances), bool)

    def camera(self, azimuth_deg: float, elevation_deg: float, distance_radii: float, half_fov_deg: float | None = None) -> Camera:
        """On a sphere round the middle; without a field of view the model's sphere just fits."""
        azimuth, elevation = radians(azimuth_deg), radians(min(max(elevation_deg, -80.0), 80.0))
        flat = np.array([np.cos(azimuth), np.sin(azimuth), 0.0]) * np.cos(elevation)
        distance = self.radius * distance_radii
        half = asin(1.0 / distance_radii) if half_fov_deg is None else radians(half_fov_deg)
        near, far = 0.02 * distance, distance + 2 * self.radius
        return Camera(
            spaces.look_at(self.middle + distance * (flat + [0, 0, np.sin(elevation)]), self.middle),
            spaces.perspective(half, 1.0, near, far),
            near,
            far,
        )

    def sun(self) -> Light:
        """A sun from the upper left."""
        return Light("sun", np.array([0.48, -0.6, 0.64]))

    def capture(
        self,
        camera: Camera,
        size: tuple[int, int],
        *,
        texels: float = 2.0,
        perspective: bool = True,
        with_back: bool = True,
        samples: int = SAMPLES,
    ) -> ImpostorTextures:
        """The whole model captured."""
        projection = "perspective" if perspective else "orthographic"
        settings = ImpostorSettings(projection=projection, texels_per_pixel=texels, max_texels=4096)
        frame = capture_frame(self.hull, camera, size, settings, samples)
        return capture(self.device, self.draw_list, self.rows, frame, with_back=with_back)

    def direct(self, camera: Camera, size: tuple[int, int]) -> GBuffer:
        """The G-buffer of the geometry, waited for."""
        target = self.device.gbuffer(size)
        draw_gbuffer(self.device.context, self.device.programs, target, self.draw_list, camera)
        self.device.context.finish()
        return target

    def drawn(self, camera: Camera, size: tuple[int, int], impostors: list[ImpostorTextures], method: str = "inverse") -> GBuffer:
        """The G-buffer of impostors alone, waited for. `method` 'dithered': of several captures as the program draws them."""
        target = self.device.gbuffer(size)
        draw_gbuffer(self.device.context, self.device.programs, target, self.draw_list, camera, ~self.rows)
        if method == "dithered":
            near, *others = sorted(impostors, key=lambda impostor: tilt_rad(impostor.frame, camera))
            DrawnImpostor(near, self.hull, False, "inverse", 1.0, None, tuple(others)).draw(self.device, target, camera)
            impostors = []
        for impostor in impostors:
            draw_impostor(self.device, target, impostor, self.hull, camera, method=method)
        self.device.context.finish()
        return target

    def picture(
        self, camera: Camera, side: int, impostors: list[ImpostorTextures] | None = None, method: str = "inverse"
    ) -> tuple[np.ndarray, np.ndarray]:
        """(picture (side, side, 3), silhouette): with shadows, 4 × 4 samples a pixel; of the geometry without impostors."""
        size, device = (side * SAMPLES, side * SAMPLES), self.device
        plan, maps = self._shadows(camera, size)
        gbuffer = self.direct(camera, size) if impostors is None else self.drawn(camera, size, impostors, method)
        target, triangles = device.shade_target(size, False), device.triangles(linked=True, normals=True)
        device.shade_pass.draw(
            target, gbuffer, maps, self.draw_list, triangles, camera, self.sun(), plan, LIT, impostors=impostors is not None
        )
        blocks = (side, SAMPLES, side, SAMPLES)
        image = np.clip(read_texture(target.textures[0])[..., :3], 0, 1).reshape(*blocks, 3).mean(axis=(1, 3))
        return image, (read_texture(gbuffer.ids)[..., 0] > 0).reshape(blocks).mean(axis=(1, 3)) >= 0.5

    def _shadows(self, camera: Camera, size: tuple[int, int]) -> tuple[ShadowPlan, ShadowMaps]:
        """The geometry's shadows in one map."""
        device, bounds = self.device, {"scene_bounds_ws": self.scene.bounds_ws(), "caster_bounds_ws": self.scene.instance_bounds_ws()}
        plan = plan_shadows(camera, self.sun(), LIT.warp, LIT.partition, LIT.fit, image_size=size, **bounds)
        maps = device.shadow_maps(LIT.fit.size, len(plan.projections), LIT.test)
        draw_shadow_maps(device.context, device.programs, maps, self.draw_list, plan, LIT.test, None)
        maps.holds = None
        return plan, maps

    def unseen(self, impostor: ImpostorTextures, camera: Camera, size: tuple[int, int]) -> int:
        """Pixels of the true picture whose surface point the capture's front layer does not hold.

        Held: one of the 3 × 3 texels round the point's place, continued as a plane, passes within two texels' depth of it.
        """
        depth = read_texture(self.direct(camera, size).view_depth)
        row, column = np.nonzero(depth)
        along, start = pixel_rays(camera, size)
        pixel = np.stack([column + 0.5, size[1] - row - 0.5, np.ones(len(row))], axis=-1)
        uv, relief = impostor.frame.texels(pixel @ start.T + depth[row, column, None] * (pixel @ along.T))
        return int((~_held(impostor, uv, np.abs(relief))).sum())


def _held(impostor: ImpostorTextures, uv: np.ndarray, relief: np.ndarray) -> np.ndarray:
    frame, mask = impostor.frame, impostor.mask
    unit = shift_unit(frame)
    layers = read_texture(impostor.texels.layers)
    front, slopes = np.where(mask, np.abs(layers[..., 0]), 0.0), (layers[..., 1], layers[..., 2])
    held = np.zeros(len(uv), bool)
    for dv in (-1, 0, 1):
        for du in (-1, 0, 1):
            cell = np.floor(uv).astype(int) + [du, dv]
            inside = ((cell >= 0) & (cell < [frame.width, frame.height])).all(axis=1)
            x, y = np.where(inside[:, None], cell, 0).T
            offset = uv - (cell + 0.5)
            plane = front[y, x] + slopes[0][y, x] * offset[:, 0] + slopes[1][y, x] * offset[:, 1]
            held |= inside & mask[y, x] & (np.abs(plane - relief) <= HELD_TEXELS * unit)
    return held
