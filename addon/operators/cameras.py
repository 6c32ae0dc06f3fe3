"""Helpers for cameras: `cad_shadow.fit_clip` (near and far to the scene) and `cad_shadow.frame_camera` (a camera that sees everything)."""

from __future__ import annotations

from math import atan, degrees

import bpy
from mathutils import Matrix

from ..blender import sources
from ..blender.snapshot.cameras import matrix, rigid_inverse
from ..errors import SceneError
from ..scene.default_view import VIEWS, camera_for_view, depth_range
from ..scene.records import Scene
from ..studies.pending import Pending, ready
from .background import JobOperator, view_read
from .row import OperatorRow


def free_viewport(context: bpy.types.Context) -> bpy.types.SpaceView3D | None:
    """The 3D viewport the operator is called from, None for another editor or while it looks through the scene's camera."""
    space = context.space_data
    if space is None or space.type != "VIEW_3D" or (space.region_3d.view_perspective == "CAMERA" and context.scene.camera):
        return None
    return space


class SceneOperator(JobOperator):
    """Mix-in: reads the scene without holding the window up; `take(context, scene)` then changes something, as one step of undo."""

    def start(self, context: bpy.types.Context) -> Pending:
        """Have the scene read; raises `UserError`."""
        return view_read(context, lambda reading: ready(reading.scene(bpy.context)), sources.ViewReading(self.space_of))

    @staticmethod
    def space_of(_context: bpy.types.Context) -> bpy.types.SpaceView3D | None:
        """The 3D viewport whose visibility counts, None for the whole scene."""
        return None


class CAD_SHADOW_OT_fit_clip(SceneOperator, bpy.types.Operator):
    """Set near and far clip distances closely around the scene: of this viewport, or of the scene's camera when looking through it.
    The closer they are, the better warps and partitions spread the shadow map"""

    bl_idname = "cad_shadow.fit_clip"
    bl_label = "Fit Near and Far"
    bl_options = {"REGISTER", "UNDO"}
    space_of = staticmethod(free_viewport)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Grey without anything to see or to see with."""
        if not super().poll(context):
            return False
        if free_viewport(context) is None and (context.scene.camera is None or context.scene.camera.type != "CAMERA"):
            cls.poll_message_set("The scene has no camera: add one, for example with Add Framing Camera")
            return False
        return True

    def take(self, context: bpy.types.Context, scene: Scene) -> None:
        """Set the distances."""
        space, camera = free_viewport(context), context.scene.camera
        world_from_view = space.region_3d.view_matrix.inverted() if space else camera.matrix_world
        near, far = depth_range(rigid_inverse(matrix(world_from_view), scene.origin_ws), scene)
        if far < 1e-5:
            raise SceneError("Everything lies behind the camera: turn it towards the scene first.")
        holder = space or camera.data
        holder.clip_start, holder.clip_end = near, far
        self.report({"INFO"}, f"{'Viewport' if space else camera.name}: near {near:.4g} m, far {far:.4g} m")


class CAD_SHADOW_OT_frame_camera(SceneOperator, bpy.types.Operator):
    """Add a camera that sees the whole scene from a standard side, near and far closely around it, and make it the scene's camera"""

    bl_idname = "cad_shadow.frame_camera"
    bl_label = "Add Framing Camera"
    bl_options = {"REGISTER", "UNDO"}

    view: bpy.props.EnumProperty(
        name="View",
        description="The side from which the camera looks",
        items=[(name.upper(), name.capitalize(), "From above a corner" if name == "iso" else f"From the {name}") for name in VIEWS],
    )
    fov_y: bpy.props.FloatProperty(
        name="Field of View", description="Vertical field of view", subtype="ANGLE", default=0.6981317, min=0.01745, max=2.9
    )

    def take(self, context: bpy.types.Context, scene: Scene) -> None:
        """Add the camera."""
        wanted = camera_for_view(scene, sources.render_size(context.scene), self.view.lower(), self.fov_y)
        data = bpy.data.cameras.new(f"CAD {self.view.capitalize()}")
        data.sensor_fit, data.sensor_height = "VERTICAL", 24.0
        data.angle_y = 2.0 * atan(1.0 / wanted.clip_from_view[1, 1])
        data.clip_start, data.clip_end = wanted.near, wanted.far
        camera = bpy.data.objects.new(data.name, data)
        context.scene.collection.objects.link(camera)
        world_from_view = wanted.world_from_view.copy()
        world_from_view[:3, 3] += scene.origin_ws
        camera.matrix_world = Matrix(world_from_view.tolist())
        context.scene.camera = camera
        self.report({"INFO"}, f"{camera.name}: {degrees(data.angle_y):.3g}° high, near {wanted.near:.4g} m, far {wanted.far:.4g} m")


ROW = OperatorRow("cameras", 110, (CAD_SHADOW_OT_fit_clip, CAD_SHADOW_OT_frame_camera), group="camera")
