"""Deferred shading: surface + light + error of every pixel that has a surface, the background in the others. Worker thread only.

The depth test tells them apart before a shader runs: a software rasteriser runs both sides of a branch for every pixel.
"""

from __future__ import annotations

import math
from collections.abc import Hashable
from dataclasses import replace
from functools import cache

import moderngl
import numpy as np

from ...images.color_bar import NOTHING
from ...images.heatmap import LOG2_HIGH, LOG2_LOW, SCALE_COLORS
from ...images.passes import id_colors
from ...maths.shadow.projection import ShadowPlan
from ...maths.spaces import translation
from ...maths.view import Camera, Light
from ...scene.looks import GROUND
from ...scene.records import Ground
from ...settings.groups import DISPLAYS, Settings, ShadingChoice, ShadingWorld
from ..geometry.draw_list import DrawList
from ..gl.gl_raw import BufferTexture, draw_triangles, write_buffer
from ..gl.programs import SAMPLER_UNITS, Programs, matrix_bytes, set_uniforms
from .gbuffer import FROM_TEXTURE, GBuffer, pixel_from_world, pixel_rays
from .large_receivers import LargePlanes
from .light_sums import LightSums
from .panes import PaneMaps
from .shadow import MAX_MAPS, ShadowMaps, plan_block
from .shadow_defines import shadow_defines, shadow_uniforms
from .sky_light import SkyLight

_SRC1_COLOR, _SRC1_ALPHA = 0x88F9, 0x8589  # blending by a shader's second output (OpenGL 3.3)
NO_SPREAD = 1.5
"""A panel's half spread from which on it counts as not narrowed."""
FOLLOWED = {"MOST_FOLLOWED": 64, "FROM_TEXTURE": f"{FROM_TEXTURE}u"}
"""Triangles at most from the one that an impostor's texel names to the one that the view ray meets, and the mark of such texels."""


class ShadeTarget:
    """`combined` RGBA32F; with `data` also errors (m, m_x, m_z, light), normal (xyz, view depth) and ids (object, map,
    instance row, 0).

    `holds` says what was shaded last, by whoever can say; None as soon as anything is.
    """

    def __init__(self, context: moderngl.Context, size: tuple[int, int], data: bool) -> None:
        self.size, self.data = size, data
        self.holds: Hashable = None
        self.textures = [context.texture(size, 4, dtype="f4")]
        if data:
            self.textures += [
                context.texture(size, 4, dtype="f4"),
                context.texture(size, 4, dtype="f4"),
                context.texture(size, 4, dtype="i4"),
            ]
        self.framebuffer = context.framebuffer(self.textures)
        self.picture = context.framebuffer(self.textures[:1]) if data else self.framebuffer

    def release(self) -> None:
        """Free the targets."""
        for framebuffer in {self.framebuffer, self.picture}:
            framebuffer.release()
        for texture in self.textures:
            texture.release()


def lay_over(
    context: moderngl.Context,
    picture: moderngl.Framebuffer,
    gbuffer: GBuffer,
    program: moderngl.Program,
    array: moderngl.VertexArray,
) -> None:
    """Run `program` where the G-buffer has a surface: what it shows is added to what it leaves of the picture there."""
    depth = gbuffer.projection
    set_uniforms(program, u_ndc_depth=2.0 * depth.farthest - 1.0)
    with gbuffer.depth.attached(picture):
        context.enable_only(moderngl.DEPTH_TEST | moderngl.BLEND)
        context.blend_func = moderngl.ONE, _SRC1_COLOR, moderngl.ONE, _SRC1_ALPHA
        context.depth_func = {"<": ">", ">": "<"}[depth.nearer]
        draw_triangles(context, array, 3)
        context.depth_func, context.blend_func = "<", moderngl.DEFAULT_BLENDING
    context.enable_only(moderngl.NOTHING)


class ShadePass:
    """Holds what shading needs beside its inputs: the uniform block and an attribute-less vertex array per program."""

    def __init__(self, context: moderngl.Context, programs: Programs) -> None:
        self._context, self._programs = context, programs
        self._block = context.buffer(reserve=len(plan_block(None)))
        self._arrays: dict[int, moderngl.VertexArray] = {}

    def draw(
        self,
        target: ShadeTarget | LightSums,
        gbuffer: GBuffer,
        maps: ShadowMaps | None,
        draw_list: DrawList,
        triangles: dict[str, BufferTexture],
        camera: Camera,
        light: Light | None,
        plan: ShadowPlan | None,
        settings: Settings,
        large: LargePlanes | None = None,
        impostors: bool = False,
        side: int = 1,
        part: float | None = None,
        sky: SkyLight | None = None,
        panes: PaneMaps | None = None,
        is_layer: bool = False,
    ) -> None:
        """Shade `gbuffer` into `target`, or add a `part` of it to what sums hold. `large`: the planes of triangles too large for
        float32, relative to the plan's origin.

        `impostors`: it holds some, whose texels name a triangle near the one seen; `triangles` must be linked. `side`: so many pixels of
        the target to a side of the picture's own, which softness and error are told in. `sky`: what stands before it; None: nothing does.
        `panes`: what tints the light. `is_layer`: `gbuffer` is a layer of what is see-through, laid over the picture that `target` holds.
        """
        looks = draw_list.looks()
        more = {} if looks is None else {"u_looks": looks}
        more |= {} if large is None else {"u_large": large.texture}
        more |= {} if sky is None else sky.inputs()
        more |= {} if panes is None else {"u_panes": panes.array}
        kind = {"DATA": target.data and not is_layer, "SUMS": part is not None, "LAYER": is_layer, "PANES": panes is not None}
        program = self._program(draw_list, plan, settings, LARGE=large is not None, IMPOSTORS=impostors, SKY=sky is not None, **kind)
        self._bind(program, gbuffer, maps, draw_list, triangles | more)
        origin = plan.origin_ws if plan else np.zeros(3)
        set_uniforms(
            program,
            **_pixel_uniforms(camera, target.size, origin),
            u_origin=tuple(origin),
            u_section=(camera.near, camera.far),
            u_large_count=large.count if large is not None else 0,
            u_map_count=len(plan.projections) if plan else 0,
            u_map_size=float(settings.fit.size),
            **({} if panes is None else panes.uniforms()),
            u_side=float(side),
            u_part=part or 0.0,
            **({} if sky is None else sky.uniforms(origin)),
            u_footprint=settings.shading.samples**-0.5,
            **_light_uniforms(light, settings, origin),
            **_colors(settings, draw_list.scene.ground, origin),
            **_data_colors(),
            **shadow_uniforms(settings.test, plan),
        )
        write_buffer(self._context, self._block, plan_block(plan))
        if is_layer:
            lay_over(self._context, target.picture, gbuffer, program, self._array(program))
        elif part is None:
            self._cover(target, gbuffer, program, settings, everywhere=impostors)
        else:
            self._add(target, gbuffer, program, everywhere=impostors)

    def _program(
        self,
        draw_list: DrawList,
        plan: ShadowPlan | None,
        settings: Settings,
        **kind: bool,
    ) -> moderngl.Program:
        """The program with what this picture needs compiled in. The edges of soft shadows need no smoothing."""
        return self._programs.get(
            "fullscreen.vert",
            "shade.frag",
            INSTANCED=0,
            MAX_MAPS=MAX_MAPS,
            ANY_LOG=any(p.log is not None for p in plan.projections) if plan else False,
            DISPLAY=DISPLAYS.index(settings.shading.display),
            ERROR_COLORS=len(SCALE_COLORS),
            USE_OBJECT_COLORS=settings.shading.use_object_colors,
            **kind,
            **FOLLOWED,
            LOOKS=draw_list.looks() is not None,
            GROUND=GROUND if draw_list.scene.ground is not None else 0,
            **shadow_defines(replace(settings.test, smoothing=1) if kind["SUMS"] and settings.lights.samples else settings.test),
        )

    def _add(self, sums: LightSums, gbuffer: GBuffer, program: moderngl.Program, everywhere: bool) -> None:
        """Add what `program` draws where the G-buffer has a surface."""
        context, depth = self._context, gbuffer.projection
        set_uniforms(program, u_ndc_depth=2.0 * depth.farthest - 1.0)
        with gbuffer.depth.attached(sums.framebuffer):
            context.enable_only(moderngl.BLEND if everywhere else moderngl.BLEND | moderngl.DEPTH_TEST)
            context.blend_func = moderngl.ONE, moderngl.ONE
            context.depth_func = {"<": ">", ">": "<"}[depth.nearer]
            draw_triangles(context, self._array(program), 3)
            context.depth_func = "<"
        context.enable_only(moderngl.NOTHING)

    def lay_sums_over(self, target: ShadeTarget, gbuffer: GBuffer, sums: LightSums, draw_list: DrawList) -> None:
        """Lay a layer of what is see-through, as lights have added it up, over the picture that `target` holds."""
        program = self._programs.get("fullscreen.vert", "resolve_layer.frag")
        set_uniforms(program, u_share=1.0 / sums.total)
        for name, texture in {"u_sampled": sums.textures[0], "u_ids": gbuffer.ids, "u_looks": draw_list.looks()}.items():
            texture.use(SAMPLER_UNITS[name])
        draw_list.bind_table()
        lay_over(self._context, target.picture, gbuffer, program, self._array(program))

    def _cover(self, target: ShadeTarget, gbuffer: GBuffer, program: moderngl.Program, settings: Settings, everywhere: bool) -> None:
        """Run `program` where the G-buffer has a surface, and the background's where it has none; `everywhere`, as impostors' outlines are
        found by the program: over the background, and where it finds nothing it leaves it."""
        context, depth = self._context, gbuffer.projection
        target.holds = None
        background = self._programs.get("fullscreen.vert", "background.frag", DATA=target.data)
        set_uniforms(background, u_background=settings.shading.under(ShadingWorld()).background)
        farther = {"<": ">", ">": "<"}[depth.nearer]
        with gbuffer.depth.attached(target.framebuffer):
            context.enable_only(moderngl.NOTHING if everywhere else moderngl.DEPTH_TEST)
            for shader, passes in ((background, "=="), (program, farther)):
                set_uniforms(shader, u_ndc_depth=2.0 * depth.farthest - 1.0)
                context.depth_func = passes
                draw_triangles(context, self._array(shader), 3)
            context.depth_func = "<"

    def _bind(
        self,
        program: moderngl.Program,
        gbuffer: GBuffer,
        maps: ShadowMaps | None,
        draw_list: DrawList,
        triangles: dict[str, BufferTexture],
    ) -> None:
        tables = {"u_extents": draw_list.extents()} if "u_extents" in program else {}  # made before anything is bound
        inputs = {
            **tables,
            **triangles,
            "u_view_depth": gbuffer.view_depth,
            "u_normal": gbuffer.normal,
            "u_ids": gbuffer.ids,
        }
        if maps is not None:
            inputs |= maps.inputs()
        for name, texture in inputs.items():
            texture.use(SAMPLER_UNITS[name])
        draw_list.bind_table()
        self._block.bind_to_uniform_block(0)
        program["ShadowPlan"].binding = 0

    def _array(self, program: moderngl.Program) -> moderngl.VertexArray:
        if program.glo not in self._arrays:
            self._arrays[program.glo] = self._context.vertex_array(program, [])
        return self._arrays[program.glo]

    def release(self) -> None:
        """Free the block and the vertex arrays."""
        self._block.release()
        for array in self._arrays.values():
            array.release()
        self._arrays.clear()


def _pixel_uniforms(camera: Camera, size: tuple[int, int], origin_ws: np.ndarray) -> dict[str, object]:
    """What takes pixels to places relative to the origin, and back."""
    along, start = pixel_rays(camera, size)
    return {
        "u_along_from_pixel": matrix_bytes(along),
        "u_start_from_pixel": matrix_bytes(start - origin_ws[:, None] * [0.0, 0.0, 1.0]),
        "u_pixel_from_world": matrix_bytes(pixel_from_world(camera, size) @ translation(origin_ws)),
    }


def _light_uniforms(light: Light | None, settings: Settings, origin_ws: np.ndarray) -> dict[str, object]:
    """u_light (a position relative to the origin), u_light_color, u_lamp, u_spot, u_cone."""
    if light is None:
        return {"u_light": (0.0, 0.0, 1.0, 0.0), "u_light_color": (0.0, 0.0, 0.0, 0.0), "u_lamp": 0}
    is_sun = light.kind == "sun"
    vector = light.direction_ws if is_sun else light.position_ws - origin_ws
    color = tuple(c * radiance_per_color(light, settings.shading) for c in light.color)
    lamp = (1 if light.spread_rad is None else 2) if light.kind == "spot" else 0
    return {
        "u_light": (*map(float, vector), 0.0 if is_sun else 1.0),
        "u_light_color": (*color, 1.0),
        "u_lamp": lamp,
        **(_cone_uniforms(light) if lamp else {}),
    }


def _cone_uniforms(light: Light) -> dict[str, object]:
    """u_spot and u_cone of a spot or a panel."""
    cone, axes = light.cone_rad, light.local_from_world
    if axes is None:
        axes = np.zeros((3, 3))
        axes[2] = light.direction_ws
        axes[0] = np.eye(3)[np.abs(light.direction_ws).argmin()]
        axes[1] = np.cross(axes[2], axes[0])
        axes[1] /= np.linalg.norm(axes[1])
        axes[0] = np.cross(axes[1], axes[2])
    else:
        cone = light.local_cone_rad
    spread = light.spread_rad
    is_narrow = spread is not None and spread < NO_SPREAD
    tangent = math.tan(spread) if is_narrow else 0.0
    share = (1.0 / (tangent - spread) if spread > 0.05 else 3.0 / max(spread, 1e-4) ** 3) if is_narrow else 0.0
    return {"u_spot": matrix_bytes(axes), "u_cone": (math.cos(cone), light.cone_blend, tangent, share)}


def radiance_per_color(light: Light, shading: ShadingChoice) -> float:
    """What a white diffuse surface facing the light shows (at 1 m, of one with a place), over the light's colour: 1/π by Lambert."""
    return shading.light_strength * (1.0 / math.pi if light.is_physical else shading.own_sun)


def _colors(settings: Settings, ground: Ground | None, origin_ws: np.ndarray) -> dict[str, object]:
    """Ambient light, background, clay, and what common_ground.glsl needs."""
    shading = settings.shading.under(ShadingWorld())
    colors = {
        "u_ambient_sky": (*shading.ambient_sky, 1.0),
        "u_ambient_ground": (*shading.ambient_ground, 1.0),
        "u_background": shading.background,
        "u_clay": (*shading.clay, 1.0),
    }
    if ground is None:
        return colors
    place = ground.moved_by(origin_ws)
    more = {"u_ground": (*place.centre, *place.half), "u_ground_reach": place.reach, "u_ground_strength": settings.ground.strength}
    return colors | more


@cache
def _data_colors() -> dict[str, object]:
    """The colours of errors and maps, sRGB 0…1, those of the pictures written as files."""
    rgb = {"u_error_colors": SCALE_COLORS, "u_map_colors": id_colors(np.arange(MAX_MAPS))}
    return {name: np.asarray(colors / 255.0, np.float32).tobytes() for name, colors in rgb.items()} | {
        "u_no_color": tuple(c / 255.0 for c in NOTHING),
        "u_error_scale": (LOG2_LOW, LOG2_HIGH),
    }
