"""GLSL: the only place that reads `addon/shaders`. Includes, defines, and errors that name file and line. Worker thread only."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import moderngl
import numpy as np

from ...errors import DriverError
from ...maths.spaces import translation
from .gl_raw import raw_gl

SHADER_DIR = Path(__file__).resolve().parents[2] / "shaders"
VERSION = "#version 330 core\n"
_INCLUDE = re.compile(r'^\s*#include\s+(?:"([^"]+)"|(\w+))\s*$', re.MULTILINE)
# Every sampler of every shader has its own texture unit, set once when the program is linked.
SAMPLER_UNITS = {
    "u_table": 0,
    "u_info": 1,
    "u_visible": 2,
    "u_view_depth": 3,
    "u_normal": 4,
    "u_ids": 5,
    "u_positions": 6,
    "u_indices": 7,
    "u_shadow_depth": 8,
    "u_shadow_ids": 9,
    "u_cells_0": 10,
    "u_cells_1": 11,
    "u_outline_ids": 11,
    "u_cell_ids_0": 12,
    "u_cell_ids_1": 13,
    "u_extents": 14,
    "u_layers": 15,
    "u_back_normal": 16,
    "u_back_ids": 17,
    "u_tiles": 18,
    "u_windows": 19,
    "u_sample_layers": 20,
    "u_sample_normal": 21,
    "u_sample_ids": 22,
    "u_back_layers": 23,
    "u_front_normals": 24,
    "u_both_ids": 25,
    "u_large": 26,
    "u_links": 27,
    "u_normals": 28,
    "u_sampled": 29,
    "u_looks": 30,
    "u_lines": 31,
    "u_line_depth": 32,
    "u_coverage": 33,
    "u_places": 34,
    "u_planes": 35,
    "u_sky_sums": 36,
    "u_shares": 37,
    "u_coarse_places": 38,
    "u_coarse_sources": 39,
    "u_panes": 40,
    "u_peeled": 41,
    "u_peeled_depth": 42,
}
Defines = tuple[tuple[str, int | float | str], ...]


@cache
def _file(name: str) -> str:
    return (SHADER_DIR / name).read_text(encoding="utf-8")


def source(name: str, defines: Defines = ()) -> str:
    """The text of a shader file with its includes resolved (each once, in order) and defines put first.

    `#include NAME` takes the file that the define `NAME` names.
    """
    seen: list[str] = [name]
    files = {key: value for key, value in defines if str(value).endswith(".glsl")}

    def resolve(text: str, number: int) -> str:
        def include(match: re.Match[str]) -> str:
            child = match[1] or files[match[2]]
            if child in seen:
                return ""
            seen.append(child)
            index = len(seen) - 1
            line = text.count("\n", 0, match.start()) + 2
            return f"\n#line 1 {index}\n{resolve(_file(child), index)}\n#line {line} {number}"

        return _INCLUDE.sub(include, text)

    body = resolve(_file(name), 0)
    head = "".join(f"#define {key} {value}\n" for key, value in defines if key not in files)
    names = "".join(f"// file {i}: {n}\n" for i, n in enumerate(seen))
    return f"{VERSION}{names}{head}#line 1 0\n{body}"


class Programs:
    """Compiled programs of one context, by file names and defines."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._programs: dict[tuple, moderngl.Program] = {}

    def get(self, vertex: str, fragment: str, geometry: str | None = None, **defines: int | float | bool | str) -> moderngl.Program:
        """The program of `vertex` + `fragment` (+ `geometry`) with these defines, compiled once. Raises `DriverError`."""
        values: Defines = tuple(sorted((k, int(v) if isinstance(v, bool) else v) for k, v in defines.items()))
        key = (vertex, fragment, geometry, values)
        if key not in self._programs:
            try:
                program = self._context.program(
                    vertex_shader=source(vertex, values),
                    fragment_shader=source(fragment, values),
                    geometry_shader=source(geometry, values) if geometry else None,
                )
            except moderngl.Error as error:
                raise DriverError(
                    f"A shader did not compile ({vertex}, {fragment}: {' '.join(str(error).split())}): update the graphics driver."
                ) from error
            _set_samplers(self._context, program)
            self._programs[key] = program
        return self._programs[key]

    def release(self) -> None:
        """Free every program (none may be current: GL keeps a current program alive)."""
        raw_gl(self._context).UseProgram(0)
        for program in self._programs.values():
            program.release()
        self._programs.clear()


def _set_samplers(context: moderngl.Context, program: moderngl.Program) -> None:
    """Point the samplers at their units. By raw calls: moderngl does not know buffer samplers and leaves them unset."""
    raw = raw_gl(context)
    raw.UseProgram(program.glo)
    for name in program:
        if name in SAMPLER_UNITS:
            raw.Uniform1i(program[name].location, SAMPLER_UNITS[name])


def set_uniforms(program: moderngl.Program, **values: object) -> None:
    """Set the uniforms that the compiled program kept; those the compiler removed as unused are passed over."""
    for name, value in values.items():
        member = program.get(name, None)
        if member is not None:
            if isinstance(value, (bytes, bytearray)):
                member.write(value)
            else:
                member.value = value


def relative_to(origin_ws: np.ndarray, clip_from_world: np.ndarray) -> dict[str, object]:
    """`u_origin` and `u_clip_from_world` of places relative to it: `clip_from_world` (4, 4) with nothing large in it."""
    return {"u_origin": tuple(origin_ws), "u_clip_from_world": matrix_bytes(clip_from_world @ translation(origin_ws))}


def matrix_bytes(matrix: object) -> bytes:
    """A row-major matrix as the float32 column-major bytes that GLSL wants."""
    return np.ascontiguousarray(np.asarray(matrix, dtype=np.float64).T, dtype=np.float32).tobytes()
