"""What a reader of one format hands over, in the file's own unit and axes, before `cad.read` makes a `CadModel` of it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..cad_model import CadCamera, CadLight, CadMaterial


@dataclass(eq=False)
class RawPiece:
    """Triangles of one material: `positions` (V, 3), `triangles` (T, 3), `normals` (V, 3) or None.

    `material` is a key of `RawFile.materials` or None. Where the file colours faces or vertices: `corner_colors` (T, 3, 4) linear RGBA of
    the triangles' corners, which multiply the material's; `corner_uvs` (T, 3, 2), v upwards, where the material has an image.
    """

    positions: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray | None = None
    material: object | None = None
    corner_colors: np.ndarray | None = None
    corner_uvs: np.ndarray | None = None


@dataclass(eq=False)
class RawNode:
    """A node of the tree: `parent` an earlier index or −1, `mesh` a key of `RawFile.meshes` or None, `matrix` (4, 4) or None (identity).

    `item` the light or camera that stands there, looking along −Z of the file's axes; `is_hidden` for a node that is not to be shown.
    `product` and `mark` are the numbers that a STEP file has for the product shown and for its occurrence here.
    """

    name: str
    parent: int = -1
    mesh: object | None = None
    matrix: np.ndarray | None = None
    item: CadLight | CadCamera | None = None
    is_hidden: bool = False
    product: int | None = None
    mark: int | None = None


@dataclass(eq=False)
class RawFile:
    """One file: meshes by key (each some pieces and a name), nodes, materials by key; `units`, `up` None when the file says nothing."""

    meshes: dict[object, tuple[str, list[RawPiece]]] = field(default_factory=dict)
    nodes: list[RawNode] = field(default_factory=list)
    materials: dict[object, CadMaterial] = field(default_factory=dict)
    units: str | None = None
    up: str | None = None
    warnings: list[str] = field(default_factory=list)
