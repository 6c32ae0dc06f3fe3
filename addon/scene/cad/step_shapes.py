"""The geometry of STEP products: those far from their own origin, hidden pieces, equal ones, faces that OpenCASCADE gave no triangles."""

from __future__ import annotations

import hashlib
import re

import numpy as np

from .losses import Losses
from .raw import RawFile, RawPiece
from .step_structure import FACES, Structure
from .step_text import Statements, farthest, numbers_of, references

FAR = 1000.0  # sizes from the origin at which float32 begins to show: 1e-4 of the size
UNMOVABLE = frozenset({b"MAPPED_ITEM", b"REPRESENTATION_MAP"})
Edit = tuple[int, int, bytes]


def without_hidden(statements: Statements, structure: Structure, losses: Losses) -> list[Edit]:
    """Edits that take hidden pieces of geometry out of products that also show some."""
    edits = []
    for representation, pieces in structure.hidden[2].items():
        spans = statements.spans(representation)
        kept = [n for n in references(statements.data[slice(*spans[1])]) if n not in pieces]
        edits.append((*spans[1], b"(" + b",".join(b"#%d" % n for n in kept) + b")"))
        owner = next((p for p, own in structure.representations.items() if representation in own), None)
        losses.add("hidden piece{s} within parts that are shown", structure.products.get(owner, ""), len(pieces))
    return edits


def without_context_styles(statements: Statements, structure: Structure) -> list[Edit]:
    """Edits that take away the styles of single occurrences, which OpenCASCADE gives to all of them."""
    return [(*statements.spans(number)[1], b"()") for number in structure.styled_in_context]


def far_products(statements: Statements, structure: Structure) -> tuple[dict[int | None, np.ndarray], float, list[Edit]]:
    """Of products that lie far from their own origin how far (3,), metres; the extent of the largest product; the edits that move them.

    Only points that belong to one product's geometry alone are moved, all or none.
    """
    units = {p: next((u for r in own if (u := structure.unit(r)) is not None), 0.001) for p, own in structure.representations.items()}
    reach = farthest(statements.data)
    largest_unit = max(units.values(), default=0.001)
    if reach * largest_unit < 1.0 or not units:
        return {}, 2.0 * reach * largest_unit, []
    used: dict[int, int] = {}
    places = {p: _points(statements, structure, own) for p, own in structure.representations.items()}
    for own in places.values():
        for number in own or ():
            used[number] = used.get(number, 0) + 1
    offsets, edits, extent = {}, [], 0.0
    for product, own in places.items():
        if not own:
            continue
        points = np.array(list(own.values()))
        low, high = points.min(axis=0), points.max(axis=0)
        size = float((high - low).max())
        extent = max(extent, size * units[product])
        center = (low + high) / 2.0
        if float(np.abs(center).max()) > FAR * size and all(used[n] == 1 for n in own) and not _is_held_elsewhere(statements, own):
            offsets[product] = center * units[product]
            edits += [_moved(statements, n, point - center) for n, point in own.items()]
    return offsets, extent, edits


def _points(statements: Statements, structure: Structure, representations: list[int]) -> dict[int, np.ndarray] | None:
    """The points in space of a product's geometry; None where it holds placements of other geometry."""
    reached = statements.reached([item for r in representations for item in structure.items(r)])
    kinds = {number: statements.kind(number) for number in reached}
    if UNMOVABLE & set(kinds.values()):
        return None
    found = {}
    for number in (n for n, kind in kinds.items() if kind == b"CARTESIAN_POINT"):
        a = statements.arguments(number)
        values = numbers_of(a[1]) if len(a) > 1 else []
        if len(values) == 3 and np.isfinite(values).all():
            found[number] = np.array(values)
    return found


def _is_held_elsewhere(statements: Statements, points: dict[int, np.ndarray]) -> bool:
    """Whether a transformation between products uses one of the points, so that they cannot move."""
    text = statements.data
    axes = {n for m in re.finditer(rb"ITEM_DEFINED_TRANSFORMATION\s*\(([^;]*)\)\s*;", text) for n in references(m[1])}
    return any(n in points for axis in axes for n in statements.references(axis))


def _moved(statements: Statements, number: int, point: np.ndarray) -> Edit:
    start, end = statements.spans(number)[1]
    return start, end, ("(" + ",".join(_real(c) for c in point.tolist()) + ")").encode()


def _real(value: float) -> str:
    """A number as STEP writes it: with a point, and E for the exponent."""
    text = repr(value).upper()
    mantissa, mark, exponent = text.partition("E")
    return (mantissa if "." in mantissa else mantissa + ".") + mark + exponent


def lost_faces(raw: RawFile, statements: Statements, structure: Structure, losses: Losses) -> None:
    """Note the faces of products of which OpenCASCADE made no triangles: it writes a primitive for each face that has some."""
    faces = sum(len(statements.of_type[kind]) for kind in FACES)
    made: dict[int | None, int] = {}
    for name, pieces in raw.meshes.values():
        if name.startswith("p~") and name[2:].isdigit():
            made[int(name[2:])] = max(made.get(int(name[2:]), 0), len(pieces))
    if faces <= sum(made.values()):
        return
    for product, representations in structure.representations.items():
        if product in structure.documents:
            continue
        items = [item for r in representations for item in structure.items(r) if item not in structure.hidden[2].get(r, ())]
        wanted = sum(statements.kind(n) in FACES for n in statements.reached(items)) if items else 0
        losses.add("face{s} that OpenCASCADE cannot mesh", structure.products.get(product, ""), max(wanted - made.get(product, 0), 0))


def shared(raw: RawFile) -> None:
    """Meshes of equal geometry and looks become one."""
    first: dict[object, object] = {}
    by_pieces: dict[tuple, object] = {}
    stands_for = {}
    for key, (_, pieces) in raw.meshes.items():
        quick = tuple((id(piece.positions), id(piece.triangles), piece.material) for piece in pieces)
        if quick not in by_pieces:
            by_pieces[quick] = first.setdefault(_digest(pieces), key)
        stands_for[key] = by_pieces[quick]
    for node in raw.nodes:
        if node.mesh is not None:
            node.mesh = stands_for[node.mesh]
    used = {node.mesh for node in raw.nodes}
    raw.meshes = {key: mesh for key, mesh in raw.meshes.items() if key in used}


def _digest(pieces: list[RawPiece]) -> bytes:
    digest = hashlib.blake2b(digest_size=16)
    for piece in pieces:
        for array in (piece.positions, piece.triangles, piece.normals):
            if array is not None:
                digest.update(repr((array.shape, array.dtype.str)).encode())
                digest.update(np.ascontiguousarray(array).data)
        digest.update(repr(piece.material).encode())
    return digest.digest()
