"""The render engine CAD_SHADOW_PREVIEW: F12, animation and background renders, and the viewport's Rendered shading (`viewport.py`).

A failure is reported as an error, so that Blender writes no file: an exception, `error_set` or a cancelled result would still write one.
Blender's images have row 0 at the bottom, ours at the top: they are flipped here on their way out.
"""

from __future__ import annotations

import logging

import bpy
import numpy as np

from ..errors import SceneError, UserError
from ..images.cryptomatte import layer_key, manifest
from ..pipeline.frame import Frame
from ..pipeline.job import Job
from ..pipeline.render_passes import LAYER_PASSES, RENDER_PASSES
from ..pipeline.render_passes.row import BlenderPass, RenderPass
from ..scene.records import Scene
from ..studies.run import Outcome, run
from . import session, sources
from .render_wish import ENGINE, RenderWish, active_wish
from .viewport import LiveView

log = logging.getLogger(__name__)
LAYERS = tuple(RENDER_PASSES[name] for name in LAYER_PASSES)


def border_window(render: bpy.types.RenderSettings, width: int, height: int) -> tuple[int, int, int, int]:
    """(x0, y0, x1, y1) in pixels, y upwards, of the part of the picture that Blender wants: all of it, or the render border."""
    if not render.use_border:
        return 0, 0, width, height
    return (
        int(render.border_min_x * width),
        int(render.border_min_y * height),
        int(render.border_max_x * width),
        int(render.border_max_y * height),
    )


def rect_of(name: str, image: np.ndarray, window: tuple[int, int, int, int]) -> np.ndarray:
    """Our image as the flat float32 array, bottom row first, that a render pass takes."""
    x0, y0, x1, y1 = window
    image = RENDER_PASSES[name].blender.shown(image[::-1][y0:y1, x0:x1])
    return np.ascontiguousarray(image, dtype=np.float32).ravel()


def is_on(row: RenderPass, layer: bpy.types.ViewLayer) -> bool:
    """Whether the view layer wants a pass."""
    flag = row.blender.flag
    return flag is None or bool(getattr(layer, flag, False))


def name_of(own: BlenderPass) -> str:
    """What this Blender calls a pass."""
    return own.old_name if own.old_name and bpy.app.version < (5, 0, 0) else own.name


class CadShadowEngine(bpy.types.RenderEngine):
    """Renders with the add-on's own pipeline; all OpenGL happens on the pipeline's worker thread."""

    bl_idname = ENGINE
    bl_label = "CAD Shadow Preview"
    bl_use_preview = False
    bl_use_postprocess = True
    bl_use_shading_nodes_custom = False

    def update_render_passes(self, scene: bpy.types.Scene | None = None, renderlayer: bpy.types.ViewLayer | None = None) -> None:
        """Tell the compositor which passes there are."""
        for own in (row.blender for row in LAYERS if renderlayer is None or is_on(row, renderlayer)):
            self.register_pass(scene, renderlayer, name_of(own), len(own.channels), own.channels, own.kind)

    def render(self, depsgraph: bpy.types.Depsgraph) -> None:
        """One frame, for F12, animations, `blender -b` and `rendering.render`."""
        wish = active_wish()
        try:
            if depsgraph.scene.render.use_multiview and sum(view.use for view in depsgraph.scene.render.views) > 1:
                raise SceneError("Stereo pictures are not made by this engine: switch Stereoscopy off in the output settings.")
            job = sources.job_for_render(depsgraph)
            if wish is not None and wish.reads_only:
                wish.job = job
                return
            outcome = self._outcome(job, depsgraph.scene)
            self._deliver(outcome.frame, depsgraph, job.scene)
            if wish is not None:
                wish.outcome = outcome
        except UserError as error:
            self._failed(wish, error)
        except MemoryError:
            self._failed(wish, UserError("The picture needs more memory than there is: choose a smaller size, or fewer passes."))
        except Exception as error:
            self._failed(wish, UserError(f"CAD Shadow Preview failed ({type(error).__name__}: {error}): please report this."))
            raise

    def _failed(self, wish: RenderWish | None, error: UserError) -> None:
        if wish is not None:
            wish.error = error
        if not self.test_break():
            log.info("render: %s", error)
            self.report({"ERROR"}, " ".join(str(error).split()))

    def _outcome(self, job: Job, scene: bpy.types.Scene) -> Outcome:
        outcome = run(job, self._progress, self.test_break)
        session.remember(outcome, scene)
        for warning in outcome.report["warnings"]:
            self.report({"WARNING"}, warning)
        return outcome

    def _progress(self, fraction: float, stage: str) -> None:
        self.update_progress(fraction)
        self.update_stats("", stage)

    def _deliver(self, frame: Frame, depsgraph: bpy.types.Depsgraph, scene: Scene) -> None:
        layer = depsgraph.view_layer
        window = border_window(depsgraph.scene.render, *frame.passes["combined"].shape[1::-1])
        wanted = [row for row in LAYERS if is_on(row, layer)]
        for own in (row.blender for row in wanted[1:]):  # Blender has added Combined
            self.add_pass(name_of(own), len(own.channels), own.channels, layer=layer.name)
        result = self.begin_result(0, 0, window[2] - window[0], window[3] - window[1], layer=layer.name)
        passes = result.layers[0].passes
        for row in wanted:
            passes[name_of(row.blender)].rect.foreach_set(rect_of(row.name, frame.passes[row.array], window))
        self.end_result(result)
        self._name_mattes(scene, layer, wanted)

    def _name_mattes(self, scene: Scene, layer: bpy.types.ViewLayer, wanted: list[RenderPass]) -> None:
        """The metadata by which viewers know the names in Cryptomatte passes."""
        named = {"cryptomatte-object": scene.object_names, "cryptomatte-material": [name for name, _ in scene.materials]}
        for row in wanted:
            if row.name in named:
                title = f"{layer.name}.{row.blender.name.removesuffix('00')}"
                fields = {"name": title, "hash": "MurmurHash3_32", "conversion": "uint32_to_float32", "manifest": manifest(named[row.name])}
                for field, value in fields.items():
                    self.get_result().stamp_data_add_field(f"cryptomatte/{layer_key(title)}/{field}", value)

    def view_update(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        """Something in the scene changed while a viewport shows it."""
        self._live().update(context, depsgraph)

    def view_draw(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        """Draw the last picture; ask for a new one when the view moved."""
        self._live().draw(self, context, depsgraph)

    def _live(self) -> LiveView:
        if "live" not in self.__dict__:
            self.live = LiveView()
        return self.live


def register() -> None:
    """Offer the engine in Blender's list."""
    bpy.utils.register_class(CadShadowEngine)


def unregister() -> None:
    """Take the engine out of Blender's list."""
    bpy.utils.unregister_class(CadShadowEngine)
