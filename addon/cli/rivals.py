"""Blender's own engines, asked for the same picture as ours: the same camera, the same light with sharp shadows, the same samples a pixel.

Each does the least that shows those shadows: Cycles no bounces and no denoising, with what it built kept from frame to frame; EEVEE and
Workbench no other effects. `nothing` is an engine that draws nothing: what Blender itself takes for an F12.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy
import numpy as np
from mathutils import Matrix, Vector

from ..blender.rendering import restored
from ..maths.view import Camera, Light
from ..pipeline.timing import FrameCost, costing

ENGINES = {"workbench": ("BLENDER_WORKBENCH",), "cycles": ("CYCLES",), "eevee": ("BLENDER_EEVEE_NEXT", "BLENDER_EEVEE")}
NOTHING = "nothing"
WORKBENCH_SAMPLES = {1: "OFF", 4: "5", 9: "8", 16: "16"}
WATTS = 4.0 * np.pi**2  # of a lamp whose irradiance at a metre is 1 W/m² over π: what the strength of ours stands for


class _NothingEngine(bpy.types.RenderEngine):
    """Gives Blender an empty picture."""

    bl_idname = "CAD_SHADOW_BENCH_NOTHING"
    bl_label = "Nothing (bench)"

    def render(self, depsgraph: bpy.types.Depsgraph) -> None:
        """Begin a result and end it."""
        render = depsgraph.scene.render
        self.end_result(self.begin_result(0, 0, render.resolution_x, render.resolution_y))


@contextmanager
def prepared(scene: bpy.types.Scene, size: tuple[int, int], samples: int, light: Light | None, origin_ws: np.ndarray) -> Iterator[None]:
    """The scene with that light alone and a camera of the bench's own, its engines set to do as little as ours; all put back at the end."""
    hidden = [ob for ob in scene.objects if ob.type == "LIGHT" and not ob.hide_render]
    camera = bpy.data.objects.new("Bench camera", bpy.data.cameras.new("Bench camera"))
    made = [camera, *([] if light is None else [_lamp(light, origin_ws)])]
    kept = ("engine", "resolution_x", "resolution_y", "resolution_percentage", "use_persistent_data", "use_compositing", "use_sequencer")
    bpy.utils.register_class(_NothingEngine)
    with restored(scene.render, kept), restored(scene, ("camera",)):
        for ob in made:
            scene.collection.objects.link(ob)
        for ob in hidden:
            ob.hide_render = True
        scene.camera = camera
        scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = *size, 100
        scene.render.use_persistent_data, scene.render.use_compositing, scene.render.use_sequencer = True, False, False
        _set_least_work(scene, samples, light)
        try:
            yield
        finally:
            for ob in hidden:
                ob.hide_render = False
            for ob in made:
                bpy.data.objects.remove(ob)
            bpy.utils.unregister_class(_NothingEngine)


def _set_least_work(scene: bpy.types.Scene, samples: int, light: Light | None) -> None:
    """Every engine's own settings."""
    if hasattr(scene, "cycles"):
        cycles = scene.cycles
        cycles.samples, cycles.use_denoising, cycles.use_adaptive_sampling = samples, False, False
        cycles.max_bounces, cycles.pixel_filter_type = 0, "BOX"
    scene.eevee.taa_render_samples = samples
    for name in ("use_raytracing", "use_gtao", "use_bloom", "use_ssr"):
        if hasattr(scene.eevee, name):
            setattr(scene.eevee, name, False)
    scene.display.shading.show_shadows, scene.display.render_aa = light is not None, WORKBENCH_SAMPLES.get(samples, "8")
    if light is not None and light.kind == "sun":
        scene.display.light_direction = Vector(light.direction_ws.tolist())


def _lamp(light: Light, origin_ws: np.ndarray) -> bpy.types.Object:
    """An object that shines as `light` does, with sharp shadows."""
    lamp = bpy.data.lights.new("Bench light", {"sun": "SUN", "spot": "SPOT", "point": "POINT"}[light.kind])
    strength = max(light.color)
    lamp.color = [c / strength if strength > 0.0 else 1.0 for c in light.color]
    if light.kind == "sun":
        lamp.angle, lamp.energy = 0.0, strength * float(np.pi)
    else:
        lamp.shadow_soft_size, lamp.energy = 0.0, strength * WATTS
    if light.kind == "spot":
        lamp.spot_size, lamp.spot_blend = 2.0 * light.cone_rad, light.cone_blend
    ob = bpy.data.objects.new("Bench light", lamp)
    if light.direction_ws is not None:
        ob.rotation_mode = "QUATERNION"
        ob.rotation_quaternion = Vector(light.direction_ws.tolist()).to_track_quat("Z", "Y")
    if light.position_ws is not None:
        ob.location = (light.position_ws + origin_ws).tolist()
    return ob


def cost_of(scene: bpy.types.Scene, rival: str, camera: Camera, origin_ws: np.ndarray) -> FrameCost:
    """What one F12 with that engine costs, the camera moved first. Inside `prepared` only."""
    known = scene.render.bl_rna.properties["engine"].enum_items.keys()
    names = (_NothingEngine.bl_idname,) if rival == NOTHING else ENGINES[rival]
    scene.render.engine = next((name for name in names if name in known), names[-1])
    place_camera(scene, camera, origin_ws)
    with costing() as cost:
        bpy.ops.render.render(scene=scene.name)
    return cost[0]


def place_camera(scene: bpy.types.Scene, camera: Camera, origin_ws: np.ndarray) -> None:
    """Put the scene's camera where `camera` is, with its lens."""
    placed = camera.world_from_view.copy()
    placed[:3, 3] += origin_ws
    ob, p = scene.camera, camera.clip_from_view
    ob.matrix_world = Matrix(placed.tolist())
    ob.data.sensor_fit = "VERTICAL"
    if camera.is_orthographic:
        ob.data.type, ob.data.ortho_scale = "ORTHO", 2.0 / float(p[1, 1])
    else:
        ob.data.type, ob.data.angle_y = "PERSP", 2.0 * camera.half_fov_rad
    ob.data.clip_start, ob.data.clip_end = camera.near, camera.far
