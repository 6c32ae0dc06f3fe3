"""The inputs of `../shared/field/files` with the right value of each, as checks on what a reader found."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import isclose

import numpy as np


@dataclass
class Found:
    """What a reader makes of a file: parts that show a mesh (hidden ones too) by name, meshes, triangles, area (m²), bounds (2, 3) of what
    is shown, a linear RGBA for each part (the mean of its triangles), whether colours vary within a part, hidden parts, kinds of lights and
    cameras, and every line it says: warnings, or why it refuses."""

    names: list[str] = field(default_factory=list)
    meshes: int = 0
    triangles: int = 0
    area: float = 0.0
    bounds: list[list[float]] = field(default_factory=list)
    colors: list[list[float]] = field(default_factory=list)
    varies: bool = False
    hidden: list[str] = field(default_factory=list)
    items: list[str] = field(default_factory=list)
    said: str = ""
    is_refused: bool = False

    def has(self, area: float, rel: float = 1e-3) -> bool:
        """Whether the area is right."""
        return isclose(self.area, area, rel_tol=rel)

    def lies(self, low: tuple[float, ...], high: tuple[float, ...], step: float = 1e-4) -> bool:
        """Whether the bounds are these."""
        return bool(self.bounds) and bool(np.allclose(self.bounds, [low, high], atol=step))

    def is_colored(self, *colors: tuple[float, ...]) -> bool:
        """Whether the parts, in order, have these colours (as many numbers as are given)."""
        return len(self.colors) == len(colors) and all(
            np.allclose(c[: len(w)], w, atol=0.02) for c, w in zip(self.colors, colors, strict=True)
        )

    def says(self, *words: str) -> bool:
        """Whether one of the words is said."""
        return any(word.lower() in self.said.lower() for word in words)


RED, GREEN, BLUE, YELLOW = (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0)
Check = Callable[[Found], bool]
CASES: dict[str, tuple[str, Check]] = {
    "keyhole.obj": ("hole kept: 12 m²", lambda f: f.has(12)),
    "wings.obj": ("`f 1// 2//`: 2 triangles, 1 m²", lambda f: f.triangles == 2 and f.has(1)),
    "same_names.obj": ("three parts named Valve", lambda f: [n.split(".")[0] for n in f.names] == ["Valve"] * 3),
    "abs_lib.obj": ("blue", lambda f: f.is_colored(BLUE)),
    "case_lib.obj": ("blue", lambda f: f.is_colored(BLUE)),
    "inline_comment.obj": ("red", lambda f: f.is_colored(RED)),
    "bom.obj": ("red", lambda f: f.is_colored(RED)),
    "cp1252.obj": ("green, named Träger", lambda f: f.is_colored(GREEN) and f.names == ["Träger"]),
    "bom_o.obj": ("named Pump", lambda f: f.names == ["Pump"]),
    "comma.obj": ("says decimal commas", lambda f: f.says("decimal commas")),
    "tr1.obj": ("opaque orange", lambda f: f.is_colored((1, 0.5, 0, 1))),
    "d_halo.obj": ("opacity 0.5", lambda f: f.is_colored((1, 0.5, 0, 0.5))),
    "lines.obj": ("12 triangles, says the line and the point", lambda f: f.triangles == 12 and f.says("1 line") and f.says("1 point")),
    "vcol_many.glb": ("gradient", lambda f: f.varies or f.says("vertex colo")),
    "neg5000.obj": ("5,000 quads", lambda f: f.triangles == 10_000 and f.has(5000)),
    "le_mixed.ply": ("12 triangles, 6 m²", lambda f: f.triangles == 12 and f.has(6)),
    "tristrips.ply": ("10 triangles", lambda f: f.triangles == 10),
    "upper.stl": ("12 triangles, 6 m²", lambda f: f.triangles == 12 and f.has(6)),
    "binary_extra.stl": ("12 triangles, 6 m²", lambda f: f.triangles == 12 and f.has(6)),
    "face_col.off": ("red", lambda f: f.is_colored(RED)),
    "onelinebody.off": ("cube, 6 m²", lambda f: f.has(6)),
    "same_mat_names.glb": ("red, blue, green, yellow", lambda f: f.is_colored(RED, BLUE, GREEN, YELLOW)),
    "quantized.glb": ("two balls of 1 m", lambda f: f.lies((-0.5, -0.5, -0.5), (2.5, 0.5, 0.5), 1e-3)),
    "gpu_instancing.glb": ("10 boxes, x 0…19", lambda f: f.triangles == 120 and len(f.names) == 10 and f.lies((0, -1, 0), (19, 0, 1))),
    "brace_two_same.glb": ("2 parts with braces", lambda f: len(f.names) == 2 and all(n.startswith("Wall {A1}") for n in f.names)),
    "sparse_patch.glb": ("box 1×3×1, 14 m²", lambda f: f.has(14)),
    "fan_and_box.glb": ("18 triangles", lambda f: f.triangles == 18),
    "names.glb": (
        "Bolt ×4, Bolt_1, Box ×2, Ventil…",
        lambda f: [n.split(".0")[0] for n in f.names] == ["Bolt"] * 4 + ["Bolt_1", "Box", "Box", "Ventil/Öl №5 泵"],
    ),
    "specgloss.glb": ("green (0, 0.5, 0)", lambda f: f.is_colored((0, 0.5, 0))),
    "percent space.gltf": ("box, 12 triangles", lambda f: f.triangles == 12),
    "missing_bin.gltf": ("says which .bin and where", lambda f: f.is_refused and f.says("gone.bin") and f.says("put it beside")),
    "bom.gltf": ("read, or says byte order mark", lambda f: f.says("byte order mark")),
    "draco_only_used.glb": ("read, or says Draco", lambda f: f.has(6) or (f.is_refused and f.says("with Draco"))),
    "light_camera.glb": ("a sun and a camera", lambda f: f.items == ["CAMERA", "SUN"]),
    "nauo.step": ("parts named Valve", lambda f: f.names == ["Valve"] * 4),
    "hidden.step": ("Space reservation hidden and said", lambda f: "Space reservation" in " ".join(f.hidden) and f.says("hidden")),
    "instance_colours.step": ("red, green, blue, grey", lambda f: f.is_colored(RED, GREEN, BLUE, (0.3186, 0.3186, 0.3186))),
    "many.step": ("2,000 parts of one mesh", lambda f: len(f.names) == 2000 and f.meshes == 1),
    "ext/skid.step": ("3 parts, 1×0.5×0.3 m", lambda f: len(f.names) == 3 and f.lies((0, 0, 0), (1, 0.5, 0.3))),
    "far_baked.step": (
        "Ø 40 × 200 mm at UTM, 0.0276 m²",
        lambda f: f.has(0.02764) and f.lies((449_999.98, 5_399_999.98, 100), (450_000.02, 5_400_000.02, 100.2), 1e-3),
    ),
    "pipe_10km.step": ("Ø 50 × 500 mm at 10 km, 0.08247 m²", lambda f: f.has(0.08247)),
    "transparent.step": ("glass with a core", lambda f: f.is_colored((0.3186, 0.604, 1, 0.2), (1, 0.0331, 0.01, 1))),
    "root_elsewhere.3mf": ("10 mm cube", lambda f: f.lies((0, 0, 0), (0.01, 0.01, 0.01))),
    "gradient.3mf": ("colours of corners", lambda f: f.varies),
    "lattice_mixed.3mf": ("says beam lattice", lambda f: f.says("beam lattice")),
}
