"""A CAD file (or a procedural example) as arrays: parts in a tree, shared meshes, materials, lights, cameras. No bpy, no trimesh.

`cad.read` and `platform_deck.build` return it; `blender/cad_import.py` turns it into objects. Always metres and Z up: the file's
unit and axes have been applied to meshes and matrices, so no part carries an odd scale or a quarter turn.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..maths.spaces import linear
from .records import frozen

CREASED = "cad_shadow_creased"
"""The custom property of Blender's meshes that come from a file without normals: the crease angle shades them."""


@dataclass(frozen=True, slots=True)
class CadImage:
    """A picture as the file has it, undecoded: a file beside the model (`path`), or the bytes of a PNG, JPEG or WebP within it (`data`)."""

    name: str
    path: str | None = None
    data: bytes | None = None


@dataclass(frozen=True, slots=True)
class CadMaterial:
    """A colour: `base_color` linear RGBA, 0…1, with the file's metalness and roughness where it has them.

    `image` multiplies the colour where the mesh has `corner_uvs`; `has_vertex_colors`: so do the mesh's `corner_colors`. `emission` is
    linear RGB radiance, `transmission` the share of light that goes through.
    """

    name: str
    base_color: tuple[float, ...]
    metallic: float = 0.0
    roughness: float = 0.6
    image: CadImage | None = None
    has_vertex_colors: bool = False
    emission: tuple[float, ...] = (0.0, 0.0, 0.0)
    transmission: float = 0.0


@dataclass(frozen=True, eq=False)
class CadMesh:
    """Geometry shared by any number of parts.

    `positions` (V, 3) float32 metres; `triangles` (T, 3) int32; `normals` (V, 3) float32 unit, the file's own, or None;
    `materials` the slots (indices into `CadModel.materials`); `triangle_slots` (T,) int32 slot of each triangle, None = all slot 0;
    `corner_colors` (T, 3, 4) float32 linear RGBA and `corner_uvs` (T, 3, 2) float32, v upwards, of each triangle's corners, or None.
    """

    name: str
    positions: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray | None = None
    materials: tuple[int, ...] = ()
    triangle_slots: np.ndarray | None = None
    corner_colors: np.ndarray | None = None
    corner_uvs: np.ndarray | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "positions", frozen(self.positions, np.float32))
        object.__setattr__(self, "triangles", frozen(self.triangles, np.int32))
        for name, dtype in (
            ("normals", np.float32),
            ("triangle_slots", np.int32),
            ("corner_colors", np.float32),
            ("corner_uvs", np.float32),
        ):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, frozen(getattr(self, name), dtype))


@dataclass(frozen=True, slots=True)
class CadLight:
    """A lamp that shines along its part's −Z: `kind` sun, point or spot; `color` linear RGB; `energy` W/m² of a sun, else watts, as Blender
    has them; `cone` the full angle of a spot in radians, `blend` the share of it that fades out."""

    name: str
    kind: str
    color: tuple[float, ...]
    energy: float
    cone: float = 0.0
    blend: float = 0.0


@dataclass(frozen=True, slots=True)
class CadCamera:
    """A camera that looks along its part's −Z, Y up: `fov_y` its full vertical angle in radians, or None for an orthographic one of
    `height` metres; `near` and `far` metres, `far` None for none."""

    name: str
    fov_y: float | None
    height: float = 0.0
    near: float = 0.1
    far: float | None = None


@dataclass(frozen=True, eq=False)
class CadPart:
    """One node of the tree: `parent` is an earlier index or −1, `mesh` an index or −1 (a group), `parent_from_part` (4, 4) float64.

    `item` the light or camera that stands there; `is_hidden`: the file says that it is not to be shown.
    """

    name: str
    parent: int
    mesh: int
    parent_from_part: np.ndarray
    item: CadLight | CadCamera | None = None
    is_hidden: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "parent_from_part", frozen(self.parent_from_part, np.float64))


@dataclass(frozen=True, eq=False)
class CadModel:
    """Everything read from one file. `units` names the unit that was taken, `metres_per_unit` and `up` what was applied."""

    name: str
    meshes: tuple[CadMesh, ...]
    parts: tuple[CadPart, ...]
    materials: tuple[CadMaterial, ...] = ()
    units: str = "m"
    metres_per_unit: float = 1.0
    up: str = "Z"
    warnings: tuple[str, ...] = field(default=())

    @property
    def part_count(self) -> int:
        """Parts that show a mesh (instances counted)."""
        return sum(part.mesh >= 0 for part in self.parts)

    @property
    def triangle_count(self) -> int:
        """Triangles with every instance counted."""
        return sum(len(self.meshes[part.mesh].triangles) for part in self.parts if part.mesh >= 0)

    def world_from_part(self) -> np.ndarray:
        """(P, 4, 4) float64 placement of every part."""
        world = np.empty((len(self.parts), 4, 4))
        for i, part in enumerate(self.parts):
            world[i] = part.parent_from_part if part.parent < 0 else world[part.parent] @ part.parent_from_part
        return world

    def bounds(self) -> np.ndarray:
        """(2, 3) float64 axis-aligned bounds of the vertices of all parts, metres; of those that are not hidden where there are such.
        Worked out once, and once for all parts of a mesh that are turned alike."""
        return self._bounds

    @cached_property
    @np.errstate(under="ignore")
    def _bounds(self) -> np.ndarray:
        has_shown = any(part.mesh >= 0 and not part.is_hidden for part in self.parts)
        turned: dict[tuple[int, bytes], np.ndarray] = {}
        boxes = [np.array([[np.inf] * 3, [-np.inf] * 3])]
        for part, matrix in zip(self.parts, self.world_from_part(), strict=True):
            if part.mesh >= 0 and not (part.is_hidden and has_shown) and len(self.meshes[part.mesh].positions):
                key = part.mesh, matrix[:3, :3].tobytes()
                if key not in turned:
                    points = linear(matrix[:3, :3], self.meshes[part.mesh].positions.T.astype(np.float64))
                    turned[key] = np.stack([points.min(axis=1), points.max(axis=1)])
                boxes.append(turned[key] + matrix[:3, 3])
        every = np.stack(boxes)
        return frozen(np.stack([every[:, 0].min(axis=0), every[:, 1].max(axis=0)]), np.float64)
