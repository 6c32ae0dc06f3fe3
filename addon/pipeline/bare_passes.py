"""The yardstick of the benchmark: one G-buffer draw and one depth draw per shadow map of *everything*, plain shaders, no culling.

Worker thread only.
"""

from __future__ import annotations

import moderngl
import numpy as np

from ..maths.shadow.projection import ShadowPlan
from ..maths.view import Camera
from ..scene.records import Scene
from .device import Device
from .gl.gl_raw import GL_DEPTH_CLAMP, finish
from .gl.programs import matrix_bytes, set_uniforms
from .job import Job
from .renderer import Ticket
from .timing import FrameCost, costed_frame, costing


class BarePasses:
    """All triangles of a scene in world space in one buffer, drawn with the targets of `Device`."""

    def __init__(self, device: Device, scene: Scene) -> None:
        self._device = device
        positions, normals, slots, indices = merged(scene)
        context = device.context
        self._buffers = [context.buffer(a.tobytes()) for a in (positions, normals, slots, indices)]
        self.color = device.programs.get("bare.vert", "bare.frag", COLOR=1)
        self.depth = device.programs.get("bare.vert", "shadow.frag", COLOR=0)
        p, n, s, i = self._buffers
        self._color_array = context.vertex_array(
            self.color, [(p, "3f4", "in_position"), (n, "3f4", "in_normal"), (s, "1u4", "in_slot")], index_buffer=i
        )
        self._depth_array = context.vertex_array(self.depth, [(p, "3f4", "in_position")], index_buffer=i)

    def draw(self, camera: Camera, plan: ShadowPlan, size: tuple[int, int], map_size: int) -> None:
        """Draw all passes and wait for them."""
        context = self._device.context
        target = self._device.gbuffer(size)
        target.use()
        target.framebuffer.clear()
        context.enable_only(moderngl.DEPTH_TEST)
        set_uniforms(
            self.color,
            u_clip_from_world=matrix_bytes(camera.clip_from_world),
            u_view_depth_from_world=np.asarray(-camera.view_from_world[2], np.float32).tobytes(),
        )
        self._color_array.render()
        context.enable_direct(GL_DEPTH_CLAMP)
        maps = self._device.shadow_maps(map_size, len(plan.projections))
        maps.holds = None
        for projection, framebuffer in zip(plan.projections, maps.framebuffers, strict=True):
            framebuffer.use()
            framebuffer.framebuffer.clear(depth=1.0)
            set_uniforms(self.depth, u_clip_from_world=matrix_bytes(projection.clip_from_world))
            self._depth_array.render()
        context.disable_direct(GL_DEPTH_CLAMP)
        finish(context)

    def release(self) -> None:
        """Free the buffers."""
        for thing in (self._color_array, self._depth_array, *self._buffers):
            thing.release()


class _Kept:
    """The bare passes of the scene measured last. Released with the device."""

    def __init__(self, device: Device) -> None:
        self._device, self._scene, self._passes = device, None, None

    def of(self, scene: Scene) -> BarePasses:
        """Those of that scene, made when it is another one than before."""
        if scene is not self._scene:
            self.release()
            self._passes, self._scene = BarePasses(self._device, scene), scene
        return self._passes

    def release(self) -> None:
        """Free them; idempotent."""
        if self._passes is not None:
            self._passes.release()
        self._scene = self._passes = None


def _kept(device: Device) -> _Kept:
    return device.attached("bare passes", lambda: _Kept(device))


def timed(device: Device, job: Job, ticket: Ticket) -> tuple[FrameCost, FrameCost]:
    """What the frame and the bare passes of the same scene and view cost (a task of the renderer)."""
    frame, ours = costed_frame(device, job, ticket)
    bare = _kept(device).of(job.scene)
    with costing() as cost:
        bare.draw(job.camera, frame.plan, job.size, job.settings.fit.size)
    return ours, cost[0]


def release_kept(device: Device, _job: Job, _ticket: Ticket) -> None:
    """Free what `timed` has kept (a task of the renderer)."""
    _kept(device).release()


def merged(scene: Scene) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """World positions (V, 3), normals (V, 3), instance rows (V,) and indices (T, 3) of all instances."""
    positions, normals, slots, indices, base = [], [], [], [], 0
    for row, mesh_index in enumerate(scene.instances.mesh_index):
        mesh, m = scene.meshes[mesh_index], scene.instances.world_from_object[row]
        positions.append((mesh.positions @ m[:3, :3].T + m[:3, 3]).astype(np.float32))
        normals.append(mesh.normals)
        slots.append(np.full(len(mesh.positions), row, np.uint32))
        indices.append(mesh.triangles.astype(np.uint32) + np.uint32(base))
        base += len(mesh.positions)
    return np.concatenate(positions), np.concatenate(normals), np.concatenate(slots), np.concatenate(indices)
