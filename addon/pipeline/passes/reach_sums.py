"""Receivers that many lights are counted at, and the sums over these lights. Worker thread only.

Receivers are what a G-buffer shows, or places given with their normals; behind `SurfacePlaces` there is no difference.
"""

from __future__ import annotations

from collections.abc import Hashable
from contextlib import ExitStack

import moderngl
import numpy as np

from ...maths.light_set import LightSet
from ...maths.shadow.projection import ShadowPlan
from ...maths.view import Camera
from ...settings.groups import ShadowTestChoice
from ...settings.shadowing import SHADOW_TESTS
from ..geometry.draw_list import DrawList
from ..gl.allocation import freed_with
from ..gl.gl_raw import BufferTexture, draw_triangles, write_buffer
from ..gl.programs import SAMPLER_UNITS, Programs, matrix_bytes, set_uniforms
from .gbuffer import FROM_TEXTURE, GBuffer, pixel_rays
from .large_receivers import LargePlanes
from .shadow import MAX_MAPS, ShadowMaps, plan_block
from .shadow_defines import shadow_defines, shadow_uniforms

NOISE = 4.8e-7  # of the largest coordinate: what float32 cannot tell, as in common_surface_seen.glsl
FOUND_ALIKE = {"INSIDE_ITS_TRIANGLE": 1, "FROM_TEXTURE": f"{FROM_TEXTURE}u"}
NOTHING_SMOOTHED = {"SMOOTHING": 1}  # a place is a point: there is no footprint of a pixel to smooth over
LEAST_FACING = 1e-6  # as the ray-traced truth has it


class SurfacePlaces:
    """The receivers as textures of one size: place (RGBA32F, with its noise), plane (RGBA32F, 1 where there is one), ids (RG32UI)."""

    def __init__(self, context: moderngl.Context, size: tuple[int, int]) -> None:
        self.context, self.size = context, size
        with ExitStack() as made:
            self.place, self.plane = (freed_with(made, context.texture(size, 4, dtype="f4")) for _ in range(2))
            self.framebuffer = freed_with(made, context.framebuffer([self.place, self.plane]))
            self._given_ids = freed_with(made, context.texture((1, 1), 2, data=bytes(8), dtype="u4"))
            self.ids = self._given_ids
            for texture in (self.place, self.plane, self._given_ids):
                texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
            self._made = made.pop_all()

    def see(
        self,
        programs: Programs,
        gbuffer: GBuffer,
        draw_list: DrawList,
        triangles: dict[str, BufferTexture],
        camera: Camera,
        origin_ws: np.ndarray,
        large: LargePlanes | None,
    ) -> None:
        """Take what a G-buffer of the same size shows, counted from `origin_ws`."""
        program = programs.get("fullscreen.vert", "receiver_places.frag", LARGE=large is not None, INSTANCED=0, **FOUND_ALIKE)
        along, start = pixel_rays(camera, self.size)
        inputs = {**triangles, "u_view_depth": gbuffer.view_depth, "u_normal": gbuffer.normal, "u_ids": gbuffer.ids} | (
            {"u_large": large.texture} if large else {}
        )
        _bind(draw_list, inputs)
        set_uniforms(
            program,
            u_ndc_depth=0.0,
            u_origin=tuple(origin_ws),
            u_along_from_pixel=matrix_bytes(along),
            u_start_from_pixel=matrix_bytes(start - origin_ws[:, None] * [0.0, 0.0, 1.0]),
            u_large_count=large.count if large else 0,
        )
        self.ids = gbuffer.ids
        self.framebuffer.use()
        self.framebuffer.clear()
        cover(self.context, program)

    def take(self, points_ws: np.ndarray, normals_ws: np.ndarray, origin_ws: np.ndarray) -> None:
        """Take places (P, 3) with unit normals (P, 3), P at most the pixels of the textures, counted from `origin_ws`."""
        width, height = self.size
        place, plane = np.zeros((width * height, 4), np.float32), np.zeros((width * height, 4), np.float32)
        place[: len(points_ws), :3] = points_ws - origin_ws
        place[: len(points_ws), 3] = NOISE * np.abs(place[: len(points_ws), :3]).max(axis=1)
        plane[: len(points_ws), :3], plane[: len(points_ws), 3] = normals_ws, 1.0
        self.place.write(place.tobytes())
        self.plane.write(plane.tobytes())
        self.ids = self._given_ids

    def release(self) -> None:
        """Free the textures."""
        self._made.close()


class ReachSums:
    """The sums at every receiver (RGBA32F, `reach_sums.frag`), and what adds to them. `holds`: of what, and what its places count from, by
    whoever can say; None as soon as they begin anew."""

    def __init__(self, context: moderngl.Context, size: tuple[int, int]) -> None:
        self.context, self.size = context, size
        self.holds: tuple[Hashable, np.ndarray] | None = None
        with ExitStack() as made:
            self.texture = freed_with(made, context.texture(size, 4, dtype="f4"))
            self.texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
            self.framebuffer = freed_with(made, context.framebuffer([self.texture]))
            self._block = freed_with(made, context.buffer(reserve=len(plan_block(None))))
            self._made = made.pop_all()

    def clear(self) -> None:
        """Begin anew."""
        self.holds = None
        self.framebuffer.clear()

    def add(
        self,
        programs: Programs,
        places: SurfacePlaces,
        maps: ShadowMaps,
        draw_list: DrawList,
        triangles: dict[str, BufferTexture],
        plan: ShadowPlan,
        lights: LightSet,
        test: ShadowTestChoice,
        sums: int,
    ) -> None:
        """Add what the lights, one for each of the maps, bring. `triangles` must be linked where the test walks surfaces."""
        program = programs.get(
            "fullscreen.vert",
            "reach_sums.frag",
            INSTANCED=0,
            MAX_MAPS=MAX_MAPS,
            ANY_LOG=0,
            SUMS=sums,
            FROM_TEXTURE=FOUND_ALIKE["FROM_TEXTURE"],
            **shadow_defines(test) | NOTHING_SMOOTHED,
        )
        _bind(draw_list, {**triangles, **maps.inputs(), "u_places": places.place, "u_planes": places.plane} | {"u_ids": places.ids})
        table, brightness = np.zeros((MAX_MAPS, 4), np.float32), np.zeros(MAX_MAPS, np.float32)
        table[: len(lights), :3], table[: len(lights), 3] = lights.directions_ws, lights.weights
        brightness[: len(lights)] = lights.brightness
        set_uniforms(
            program,
            u_ndc_depth=0.0,
            u_origin=tuple(plan.origin_ws),
            u_map_count=len(plan.projections),
            u_map_size=float(maps.size),
            u_lights=table.tobytes(),
            u_brightness=brightness.tobytes(),
            u_least_facing=LEAST_FACING,
            **shadow_uniforms(test, plan),
        )
        write_buffer(self.context, self._block, plan_block(plan))
        self._block.bind_to_uniform_block(0)
        program["ShadowPlan"].binding = 0
        self.framebuffer.use()
        self.context.enable_only(moderngl.BLEND)
        self.context.blend_func = moderngl.ONE, moderngl.ONE
        cover(self.context, program, keeps_state=True)
        self.context.enable_only(moderngl.NOTHING)

    def release(self) -> None:
        """Free the texture."""
        self._made.close()


def walks(test: ShadowTestChoice) -> bool:
    """Whether the test follows surfaces from triangle to triangle."""
    return SHADOW_TESTS[test.kind].walks_surfaces


def cover(context: moderngl.Context, program: moderngl.Program, *, keeps_state: bool = False) -> None:
    """Run `program` on every pixel of the bound target."""
    if not keeps_state:
        context.enable_only(moderngl.NOTHING)
    array = context.vertex_array(program, [])
    draw_triangles(context, array, 3)
    array.release()


def _bind(draw_list: DrawList, inputs: dict[str, object]) -> None:
    for name, texture in inputs.items():
        texture.use(SAMPLER_UNITS[name])
    draw_list.bind_table()
