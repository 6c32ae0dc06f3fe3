"""From Blender to a `Job`: reads the scene, chooses camera and light, notes what the user should know. Used by every face of the add-on."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import replace
from math import inf

import bpy

from ..errors import SceneError
from ..maths.view import Camera, Light
from ..pipeline.job import Job
from ..pipeline.render_passes import ENGINE_PASSES, LAYER_PASSES, RENDER_PASSES
from ..scene.asked_view import named_light, sun_from
from ..scene.default_view import default_sun, world_sun
from ..scene.light_choice import best_light, is_notably_soft, lighting
from ..scene.local_origin import based_near
from ..scene.records import Scene
from ..settings.groups import Settings
from ..studies.impostors.asked import choice_of
from ..studies.run import on_worker
from ..studies.staged import seeing_ground, staged
from .light_kind import remember
from .properties import settings_from
from .render_wish import NO_CAMERA, RenderWish, active_wish, isometric
from .snapshot import Collected, SceneReader, camera_from_object, camera_from_region, choose_light, world_of

DRAWN_TYPES = ("MESH", "CURVE", "SURFACE", "FONT", "META", "CURVES", "EMPTY")
FAINT_LIGHT = "'{}' hardly reaches the model: a sun from the upper left is used. Choose that light under Light to use it."
NO_LIGHT = "There is no light: a sun from the upper left is used."
SLICE_S = 0.04  # of fetching new meshes, between two events of the window

_render_reader = SceneReader()
view_reader = SceneReader()


def render_size(scene: bpy.types.Scene) -> tuple[int, int]:
    """(width, height) in pixels of the scene's renders."""
    render = scene.render
    scale = render.resolution_percentage
    return max(render.resolution_x * scale // 100, 1), max(render.resolution_y * scale // 100, 1)


def job_for_render(depsgraph: bpy.types.Depsgraph) -> Job:
    """The job of a render (F12, animation, `rendering.render`): the scene's camera, light and settings, unless a wish says otherwise."""
    blender_scene, wish = depsgraph.scene, active_wish() or RenderWish(bpy.data.filepath or "unsaved scene")
    size = render_size(blender_scene)
    scene, sync_ms = _read(_render_reader, depsgraph, size, wish.marked)
    scene.bounds_ws()  # says so when there is nothing
    if wish.camera is not None:
        camera, camera_warnings = wish.camera(scene, size), ()
    else:
        camera, camera_warnings = _scene_camera(blender_scene, depsgraph, size, scene)
    camera = wish.lens.on(camera)
    light, light_warnings = light_for(blender_scene.cad_shadow, scene, camera, wish)
    asked = wish.settings or settings_from(blender_scene.cad_shadow)
    settings, world_warnings = surrounded(asked, blender_scene, depsgraph.view_layer)
    more, more_warnings = others_for(blender_scene.cad_shadow, scene, light, settings, wish)
    warnings = (*wish.warnings, *scene.warnings, *camera_warnings, *light_warnings, *more_warnings, *world_warnings)
    layer = depsgraph.view_layer
    switched = (
        name for name in LAYER_PASSES if RENDER_PASSES[name].blender.flag and getattr(layer, RENDER_PASSES[name].blender.flag, False)
    )
    passes = tuple(dict.fromkeys((*ENGINE_PASSES, *switched, *wish.passes)))
    scene, camera, light = based_near(scene if more else scene.lit_by(light), camera, light)
    impostors = choice_of(scene, settings.impostor, fresh=settings.impostor.fresh)
    others = tuple(scene.lights[i] for i in more)
    job = Job(scene, camera, light, settings, size, passes, others=others, impostors=impostors, name=wish.name, sync_ms=sync_ms)
    job = staged(replace(job, warnings=warnings))
    return replace(job, camera=seeing_ground(camera, job.scene)) if wish.camera is not None or blender_scene.camera is None else job


def _space_of_view(context: bpy.types.Context) -> bpy.types.SpaceView3D | None:
    area = _viewport(context)
    return area.spaces.active if area else None


class ViewReading:
    """What the user looks at, being read (a `Pending`): Blender's part in slices, the rest on the worker. `scene`, `job` wait for both.

    That is the 3D viewport under the mouse or, without one, the largest; else the scene's camera. `space_of` gives the 3D viewport whose
    visibility counts, None for the whole scene; by default that of the view.
    """

    def __init__(self, space_of: Callable[[bpy.types.Context], bpy.types.SpaceView3D | None] = _space_of_view) -> None:
        self._space_of = space_of
        self._collected: Collected | None = None
        self._future: Future[Scene] | None = None
        self._scene: Scene | None = None
        self._seconds = 0.0

    def collect(self, context: bpy.types.Context, seconds: float = inf) -> bool:
        """Go on with Blender's part for about so long; True when it is done, and the worker has the rest. Raises `GpuError`."""
        if self._collected is None:
            begin, depsgraph = time.perf_counter(), context.evaluated_depsgraph_get()
            crease, space = context.scene.cad_shadow.crease_angle, self._space_of(context)
            self._collected = view_reader.collect(depsgraph, crease_angle_rad=crease, space=space, seconds=seconds)
            self._seconds += time.perf_counter() - begin
            if self._collected is None:
                return False
            self._collected.rows.cameras.clear()  # nothing of Blender's goes to another thread
            self._future = on_worker(self._finished)
        return True

    def _finished(self) -> Scene:
        begin = time.perf_counter()
        scene = self._collected.scene()
        self._seconds += time.perf_counter() - begin
        return scene

    @property
    def progress(self) -> tuple[float, str]:
        """How far it is: nobody knows how much there is to read."""
        return 0.0, "reading the scene"

    def done(self) -> bool:
        """True when `scene` and `job` will not wait. Goes on with Blender's part, a slice at a time; on the main thread."""
        return self.collect(bpy.context, SLICE_S) and self._future.done()

    def result(self, _timeout_s: float | None = None) -> ViewReading:
        """Itself: its `scene` and `job` wait for what is left to read."""
        return self

    def cancel(self) -> None:
        """Give it up where it has not begun."""
        if self._future is not None:
            self._future.cancel()

    def scene(self, context: bpy.types.Context) -> Scene:
        """The scene. Raises `SceneError` for an empty one, `GpuError` when there is no worker."""
        if self._scene is None:
            self.collect(context)
            self._scene = self._future.result()
            view_reader.take(self._collected)
        self._scene.bounds_ws()
        return self._scene

    def job(self, context: bpy.types.Context) -> Job:
        """The job, with the view and the settings of now. Raises `SceneError` for an empty scene, a missing light or camera."""
        scene = self.scene(context)
        camera, size, camera_warnings = _view_camera(context, scene)
        light, light_warnings = light_for(context.scene.cad_shadow, scene, camera)
        settings, world_warnings = surrounded(settings_from(context.scene.cad_shadow), context.scene, context.view_layer)
        more, more_warnings = others_for(context.scene.cad_shadow, scene, light, settings)
        scene, camera, light = based_near(scene if more else scene.lit_by(light), camera, light)
        job = Job(
            scene,
            camera,
            light,
            settings,
            size,
            ENGINE_PASSES,
            others=tuple(scene.lights[i] for i in more),
            impostors=choice_of(scene, settings.impostor),
            name=bpy.data.filepath or "unsaved scene",
            sync_ms=self._seconds * 1e3,
            warnings=(*scene.warnings, *camera_warnings, *light_warnings, *more_warnings, *world_warnings),
        )
        return staged(job)


def _viewport(context: bpy.types.Context) -> bpy.types.Area | None:
    """The 3D viewport under the mouse or, without one, the largest; None in background."""
    is_under_mouse = context.area and context.area.type == "VIEW_3D" and not bpy.app.background
    return context.area if is_under_mouse else _largest_viewport(context)


def _view_camera(context: bpy.types.Context, scene: Scene) -> tuple[Camera, tuple[int, int], tuple[str, ...]]:
    """The viewport's camera, or the scene's where it looks through it or there is no viewport; the picture's size; warnings."""
    depsgraph, size, area = context.evaluated_depsgraph_get(), render_size(context.scene), _viewport(context)
    if area is None:
        camera, warnings = _scene_camera(context.scene, depsgraph, size, scene)
        return camera, size, warnings
    rv3d = area.spaces.active.region_3d
    if rv3d.view_perspective == "CAMERA" and context.scene.camera:
        return camera_from_object(context.scene.camera.evaluated_get(depsgraph), depsgraph, size, scene.origin_ws), size, ()
    region = next(r for r in area.regions if r.type == "WINDOW")
    size = (region.width, region.height)
    return camera_from_region(rv3d, area.spaces.active, scene.origin_ws, size), size, ()


def _read(
    reader: SceneReader, depsgraph: bpy.types.Depsgraph, size: tuple[int, int], marked: Sequence[bpy.types.ID] | None
) -> tuple[Scene, float]:
    """The scene and the milliseconds it took."""
    begin = time.perf_counter()
    scene = reader.read(depsgraph, size=size, crease_angle_rad=depsgraph.scene.cad_shadow.crease_angle, marked=marked)
    return scene, (time.perf_counter() - begin) * 1e3


def _largest_viewport(context: bpy.types.Context) -> bpy.types.Area | None:
    areas = [area for area in context.screen.areas if area.type == "VIEW_3D"] if context.screen and not bpy.app.background else []
    return max(areas, key=lambda area: area.width * area.height, default=None)


def _scene_camera(
    blender_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph, size: tuple[int, int], scene: Scene
) -> tuple[Camera, tuple[str, ...]]:
    active = blender_scene.camera
    if active is None or active.type != "CAMERA":
        return isometric(scene, size), (NO_CAMERA,)
    return camera_from_object(active.evaluated_get(depsgraph), depsgraph, size, scene.origin_ws), ()


def light_for(
    props: bpy.types.PropertyGroup, scene: Scene, camera: Camera, wish: RenderWish | None = None
) -> tuple[Light, tuple[str, ...]]:
    """The main light, and a warning when it had to be made up.

    One that is made up stands in the world. Only the standard views, which are drawings rather than places, have one each.
    """
    if wish is not None and wish.light is not None:
        return wish.light(scene, camera), ()
    if props.light_source == "VIEW":
        return default_sun(camera), ()
    if props.light_source == "DIRECTION":
        return sun_from(tuple(props.light_direction)), ()
    if props.light_source == "OBJECT":
        if props.light is None:
            raise SceneError("No light object is chosen: choose one in the Light panel, or set Light to Automatic.")
        return choose_light(scene.lights, props.light.name), ()
    light = best_light(scene.lights, camera, scene.instance_bounds_ws())
    remember(props.id_data, light)
    if light is None:
        sun = default_sun(camera) if wish is not None and wish.is_drawing else world_sun()
        return sun, (FAINT_LIGHT.format(scene.lights[0].name) if scene.lights else NO_LIGHT,)
    return light, ()


def others_for(
    props: bpy.types.PropertyGroup, scene: Scene, light: Light, settings: Settings, wish: RenderWish | None = None
) -> tuple[tuple[int, ...], tuple[str, ...]]:
    """Which of the scene's lights light the picture beside the main one, and what should be said of them."""
    asked = wish is not None and wish.light is not None
    if asked:
        found = tuple(scene.lights.index(named_light(scene, name)) for name in wish.more_lights)
    elif props.light_source == "AUTOMATIC" and light in scene.lights:
        found = tuple(i for i in lighting(scene.lights, scene.instance_bounds_ws()) if scene.lights[i] is not light)
    else:
        found = ()
    warnings = []
    if found and settings.lights.which == "one" and not asked:
        warnings.append(f"'{light.name}' casts the shadows; {len(found)} other light{'s' * (len(found) > 1)} left out (Lights: One).")
        found = ()
    soft = [one.name for one in (light, *(scene.lights[i] for i in found)) if is_notably_soft(one)]
    if soft and settings.lights.samples == 0:
        warnings.append(f"{', '.join(soft[:3])}{', …' * (len(soft) > 3)}: shadows are hard, from the middle. Soft ones: set Light Samples.")
    return found, tuple(warnings)


def settings_of(blender_scene: bpy.types.Scene) -> Settings:
    """The settings that pictures of this scene are made with. Raises `SettingsError`."""
    return surrounded(settings_from(blender_scene.cad_shadow), blender_scene)[0]


def surrounded(
    settings: Settings, blender_scene: bpy.types.Scene, layer: bpy.types.ViewLayer | None = None
) -> tuple[Settings, tuple[str, ...]]:
    """The settings with the scene's world (or the view layer's own) in the place of what they leave to it, and what should be said of it.

    Film > Transparent makes the background transparent, as in every engine.
    """
    world, complaint = world_of(getattr(layer, "world_override", None) or blender_scene.world)
    own = settings.shading
    if settings.sky.kind == "scene":
        own = replace(own, ambient_sky=None, ambient_ground=None)
    is_asked = None in (own.ambient_sky, own.ambient_ground, own.background)
    shading = own.under(world)
    if blender_scene.render.film_transparent:
        shading = replace(shading, background=(0.0, 0.0, 0.0, 0.0))
    return replace(settings, shading=shading), (complaint,) if complaint and is_asked else ()


def clear_readers() -> None:
    """Drop the readers' caches."""
    view_reader.clear()
    _render_reader.clear()
