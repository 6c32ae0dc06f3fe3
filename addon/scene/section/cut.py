"""A scene cut by planes: what they take away is gone, and closed bodies get caps where they are cut. numpy only.

The result is a scene like any other, so shadows, edges, every pass and the comparison with rays need to know nothing of sections.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from ..looks import CAP, HIDDEN
from ..records import Instances, Mesh, Scene
from .caps import area_triangles, cut_lines
from .clip import clipped, heights
from .closed import Solid, solid_of

OPEN = "No cap where the section cuts {}: not closed."
TOO_FINE = "No cap where the section cuts {}: more edges are cut there than can be filled."
NAMED = 3
APART, LEVELS = 1e-6, 32
"""Caps of bodies that reach into one another lie so far apart, as a share of the scene's size, that one covers the other."""


@dataclass(frozen=True, eq=False)
class _Row:
    """An instance to be: its mesh, the row it comes from, and the flag (`looks.CAP`, `HIDDEN`) that makes it other than that."""

    mesh: Mesh
    source: int
    flag: int = 0


def cut(scene: Scene, planes: tuple[float, ...], *, has_caps: bool = True, casts_whole: bool = False) -> Scene:
    """The scene without what lies on the side that the planes' normals point to.

    `planes` x, y, z of a point and x, y, z of a normal for each, metres in the true world. `casts_whole`: what is cut away still casts its
    shadow. Raises nothing for a scene that is cut away whole: it has no instances.
    """
    planes_ws = _planes(scene, planes)
    rows, warnings = [], _Warnings(scene)
    side = _sides(scene.instance_bounds_ws(), planes_ws)
    step = APART * float(np.ptp(scene.bounds_ws(), axis=0).max())
    for number, group in enumerate(_bodies(scene)):
        gone, across = (side[group] > 0).any(axis=1), (side[group] == 0).any(axis=1)
        if casts_whole:
            rows += [_Row(scene.meshes[scene.instances.mesh_index[i]], int(i), HIDDEN) for i in group[gone | across]]
        rows += [_Row(scene.meshes[scene.instances.mesh_index[i]], int(i)) for i in group[~gone & ~across]]
        if (across & ~gone).any():
            rows += _cut_body(scene, group[~gone], planes_ws, warnings if has_caps else None, step * (number % LEVELS))
    return _assembled(scene, rows, warnings.lines())


def _planes(scene: Scene, planes: tuple[float, ...]) -> np.ndarray:
    """(P, 4) unit normal and offset, relative to the scene's origin."""
    given = np.asarray(planes, np.float64).reshape(-1, 6)
    normal = given[:, 3:] / np.linalg.norm(given[:, 3:], axis=1, keepdims=True)
    return np.column_stack([normal, -((given[:, :3] - scene.origin_ws) * normal).sum(axis=1)])


def _sides(bounds_ws: np.ndarray, planes_ws: np.ndarray) -> np.ndarray:
    """(I, P) int: 1 where a box lies on the side that is cut away, −1 on the other, 0 across the plane."""
    middle, half = bounds_ws.mean(axis=1), (bounds_ws[:, 1] - bounds_ws[:, 0]) / 2.0
    height = middle @ planes_ws[:, :3].T + planes_ws[:, 3]
    reach = half @ np.abs(planes_ws[:, :3]).T
    return np.where(height - reach >= 0.0, 1, np.where(height + reach <= 0.0, -1, 0))


def _bodies(scene: Scene) -> Iterator[np.ndarray]:
    """Instance rows that are one body: those of one object at one place, one for each of its materials."""
    found: dict[tuple[int, bytes], list[int]] = {}
    for row, (number, matrix) in enumerate(zip(scene.instances.object_id, scene.instances.world_from_object, strict=True)):
        found.setdefault((int(number), matrix.tobytes()), []).append(row)
    return map(np.array, found.values())


def _cut_body(scene: Scene, rows: np.ndarray, planes_ws: np.ndarray, warnings: _Warnings | None, depth_m: float) -> list[_Row]:
    """What is left of one body, and its caps, which lie so deep in the cut; `warnings` None: no caps."""
    planes_os = planes_ws @ scene.instances.world_from_object[rows[0]]
    meshes = [scene.meshes[scene.instances.mesh_index[i]] for i in rows]
    kept = [(_clipped(mesh, planes_os), int(row)) for mesh, row in zip(meshes, rows, strict=True)]
    parts = [_Row(mesh, row) for mesh, row in kept if mesh is not None]
    if warnings is None or not parts:
        return parts
    body = solid_of(*_merged(meshes))
    crossed = [i for i, plane in enumerate(planes_os) if len(np.unique(heights(body.points, plane) > 0.0)) == 2]
    if crossed and not body.is_closed:
        warnings.open.add(int(rows[0]))
        return parts
    deeper = planes_ws + [0.0, 0.0, 0.0, depth_m]
    planes_os = deeper @ scene.instances.world_from_object[rows[0]]
    key = "cap", tuple(mesh.key for mesh in meshes), planes_os.tobytes()
    for i in crossed:
        cap = _cap(body, planes_os, i, (*key, i))
        if cap is None:
            warnings.fine.add(int(rows[0]))
        elif len(cap.triangles):
            parts.append(_Row(cap, int(rows[0]), CAP))
    return parts


def _clipped(mesh: Mesh, planes_os: np.ndarray) -> Mesh | None:
    """The mesh behind all planes; itself where none takes anything, None where nothing is left."""
    positions, normals, triangles, is_cut = mesh.positions, mesh.normals, mesh.triangles, False
    for plane in planes_os:
        height = heights(positions, plane)
        if (height <= 0.0).all():
            continue
        positions, normals, triangles = clipped(positions, normals, triangles, height)
        is_cut = True
        if not len(triangles):
            return None
    return Mesh(("cut", mesh.key, planes_os.tobytes()), positions, normals, triangles) if is_cut else mesh


def _merged(meshes: list[Mesh]) -> tuple[np.ndarray, np.ndarray]:
    """Positions and triangles of several meshes as one."""
    first = np.cumsum([0, *(len(mesh.positions) for mesh in meshes)])
    triangles = [mesh.triangles + np.int32(offset) for mesh, offset in zip(meshes, first, strict=False)]
    return np.concatenate([mesh.positions for mesh in meshes]), np.concatenate(triangles)


def _cap(body: Solid, planes_os: np.ndarray, which: int, key: Hashable) -> Mesh | None:
    """What plane `which` cuts out of the whole body, behind the other planes; None where it is too much to fill."""
    plane = planes_os[which]
    length = float(np.linalg.norm(plane[:3]))
    normal = plane[:3] / length
    across = np.eye(3)[np.abs(normal).argmin()]
    u = np.cross(normal, across)
    u /= np.linalg.norm(u)
    v = np.cross(normal, u)
    foot = body.points.mean(axis=0)
    foot = foot - normal * (foot @ normal + plane[3] / length)
    lines = cut_lines(body, heights(body.points, plane)) - foot
    flat = area_triangles(np.stack([lines @ u, lines @ v], axis=-1), body.is_oriented)
    if flat is None:
        return None
    positions = (foot + flat.reshape(-1, 2) @ np.stack([u, v])).astype(np.float32)
    normals, triangles = np.tile(normal.astype(np.float32), (len(positions), 1)), np.arange(len(positions), dtype=np.int32).reshape(-1, 3)
    for i, other in enumerate(planes_os):
        if i != which and len(triangles):
            positions, normals, triangles = clipped(positions, normals, triangles, heights(positions, other))
    return Mesh(key, positions, normals, triangles)


class _Warnings:
    """The bodies that have no cap, by their first row."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self.open: set[int] = set()
        self.fine: set[int] = set()

    def lines(self) -> tuple[str, ...]:
        """A line for each reason."""
        return tuple(words.format(self._names(rows)) for words, rows in ((OPEN, self.open), (TOO_FINE, self.fine)) if rows)

    def _names(self, rows: set[int]) -> str:
        names = sorted({self._scene.object_names[self._scene.instances.object_id[row]] for row in rows})
        more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
        return ", ".join(f"'{name}'" for name in names[:NAMED]) + more


def _assembled(scene: Scene, rows: list[_Row], warnings: tuple[str, ...]) -> Scene:
    """A scene of these rows; meshes that are the same are one."""
    number: dict[Hashable, int] = {}
    meshes: list[Mesh] = []
    for row in rows:
        if row.mesh.key not in number:
            number[row.mesh.key] = len(meshes)
            meshes.append(row.mesh)
    source, old = np.array([row.source for row in rows], np.int64), scene.instances
    instances = Instances(
        np.array([number[row.mesh.key] for row in rows], np.int32),
        old.world_from_object[source].reshape(-1, 4, 4),
        old.object_id[source],
        old.material_slot[source],
        old.base_color[source].reshape(-1, 4),
        old.look[source],
        old.flags[source] | np.array([row.flag for row in rows], np.uint8),
    )
    return replace(scene, meshes=tuple(meshes), instances=instances, warnings=(*scene.warnings, *warnings))
