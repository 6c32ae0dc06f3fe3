"""The scene a live view shows, read anew after a change, off the main thread where it can be."""

from __future__ import annotations

from concurrent.futures import Future
from functools import partial

import bpy

from ..pipeline.job import Job
from ..scene.local_origin import based_near
from ..scene.records import Scene
from ..studies.impostors.asked import choice_of
from ..studies.run import on_worker
from ..studies.staged import is_ready, key_of, prepared, staged
from .snapshot import Collected, camera_from_region
from .sources import SLICE_S, light_for, others_for, settings_of, view_reader


def pixel_size(chosen: str, of_screen: float) -> int:
    """Pixels of the screen to a side of the live view's: as chosen, else two on a screen of fine pixels."""
    return int(chosen) if chosen != "AUTO" else 2 if of_screen > 1.5 else 1


class LiveScene:
    """The scene a live view shows, read anew only after a change, and replaced only when the content differs.

    Blender's part of the reading happens here, on the main thread, in slices; the rest, which for big new meshes takes long, on the
    worker. Until it is done the scene stays what it was.
    """

    def __init__(self) -> None:
        self._scene: Scene | None = None
        self._fingerprint = b""
        self._is_stale = True
        self.is_unfinished = False  # Blender's part takes more slices: `job` has to be called again
        self._reading: tuple[Collected, Future[tuple[Scene, bytes]]] | None = None
        self._staging: Future[object] | None = None

    def mark_changed(self) -> None:
        """The next `job` reads again."""
        self._is_stale = True

    @property
    def is_read(self) -> bool:
        """True when the worker has finished a scene that `job` has not used yet."""
        return self._reading is not None and self._reading[1].done()

    def job(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> Job | None:
        """The job of this viewport as it is now, None before the first scene is read; cheap when only the view moved."""
        region, space = context.region, context.space_data
        self._take_over()
        if self._is_stale and self._reading is None:
            crease = depsgraph.scene.cad_shadow.crease_angle
            collected = view_reader.collect(depsgraph, crease_angle_rad=crease, space=space, seconds=SLICE_S)
            self._is_stale = self.is_unfinished = collected is None
            if collected is not None:
                collected.rows.cameras.clear()  # nothing of Blender's goes to another thread
                self._reading = collected, on_worker(lambda: _finished(collected))
        if self.is_newly_staged:
            self._staging.result()
            self._staging = None
        if self._scene is None:
            return None
        self._scene.bounds_ws()  # says so when there is nothing
        pixel = pixel_size(depsgraph.scene.render.preview_pixel_size, context.preferences.system.pixel_size)
        size = (max(region.width // pixel, 1), max(region.height // pixel, 1))
        camera = camera_from_region(context.region_data, space, self._scene.origin_ws, size)
        light, about_light = light_for(depsgraph.scene.cad_shadow, self._scene, camera)
        settings = settings_of(depsgraph.scene)
        more, _ = others_for(depsgraph.scene.cad_shadow, self._scene, light, settings)
        self._scene, camera, light = based_near(self._scene, camera, light)
        scene = self._scene if more else self._scene.lit_by(light)
        others = tuple(scene.lights[i] for i in more)
        impostors = choice_of(self._scene, settings.impostor)
        kinds = {"measure": False, "is_live": True, "keeps_depth": True, "warnings": (*self._scene.warnings, *about_light)}
        job = Job(scene, camera, light, settings, size, others=others, impostors=impostors, name="viewport", **kinds)
        return staged(job) if self._is_staged(job) else None

    def _is_staged(self, job: Job) -> bool:
        """Whether sections are cut and ground is laid for this job; if not, the worker is asked to."""
        if is_ready(job.scene, job.camera, job.settings):
            return True
        if self._staging is None or self._staging.done():
            self._staging = on_worker(partial(prepared, job.scene, key_of(job.scene, job.camera, job.settings)))
        return False

    @property
    def is_newly_staged(self) -> bool:
        """True when the worker has cut a scene that `job` has not used yet."""
        return self._staging is not None and self._staging.done()

    def _take_over(self) -> None:
        """Use the scene that the worker has finished, if it has."""
        if not self.is_read:
            return
        (collected, future), self._reading = self._reading, None
        if future.cancelled():
            self._is_stale = True
            return
        scene, fingerprint = future.result()
        view_reader.take(collected)
        if fingerprint != self._fingerprint:
            self._scene, self._fingerprint = scene, fingerprint


def _finished(collected: Collected) -> tuple[Scene, bytes]:
    scene = collected.scene()
    return scene, scene.fingerprint
