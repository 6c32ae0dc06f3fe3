"""STEP: OpenCASCADE (cascadio) makes triangles of it, in a GLB in metres, Z up; what that loses is read from the file's own text.

Products and occurrences are given names that are marks before OpenCASCADE sees the text, so that its nodes can be told. A product far from
its own origin is moved there first, as OpenCASCADE's float32 would lose it, and put back in float64.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...errors import CadFileError
from ..cad_model import CadMaterial
from ..plain_text import shown_name
from .cad_format import CadFormat, starts_text
from .cleaning import is_coarse
from .companions import companion
from .gltf import read_glb_bytes
from .losses import Losses
from .raw import RawFile, RawNode
from .step_shapes import far_products, lost_faces, shared, without_context_styles, without_hidden
from .step_structure import OCCURRENCE, WANTED, Structure
from .step_text import Statements, edited

COARSEST, FINEST, LINEAR_MM, ANGULAR_RAD = 1e-4, 1e-5, 0.01, 0.5  # of the file's extent; the tolerance of ordinary parts
MARK = re.compile(r"([pu])~(\d+)")
MOST_DEPTH = 8  # of documents within documents


def read_step(path: Path, above: tuple[Path, ...] = ()) -> RawFile:
    """A `.step` or `.stp` file with the files beside it that it refers to; `above` are those that refer to this one."""
    statements = Statements(path.read_bytes(), WANTED)
    structure, losses = Structure(statements), Losses()
    hidden, coarse, edits = Losses(), Losses(), _marks(statements)
    edits += without_hidden(statements, structure, losses) + without_context_styles(statements, structure)
    offsets, extent_m, moves = far_products(statements, structure)
    raw = read_glb_bytes(_tessellated(edited(statements.data, edits + moves), path.name, tolerance_mm(extent_m)), path)
    _name(raw, structure, hidden)
    _note_coarse(raw, structure, coarse)
    _put_back(raw, structure, offsets)
    lost_faces(raw, statements, structure, losses)
    _color(raw, structure)
    shared(raw)
    _add_documents(raw, path, structure, (*above, path.resolve()))
    raw.nodes[:] = [replace_name(node, lambda name: MARK.sub("Part", name)) for node in raw.nodes]
    raw.meshes.update({key: (_title(name, structure), pieces) for key, (name, pieces) in raw.meshes.items()})
    raw.warnings += [
        *losses.lines(path.name),
        *coarse.lines(path.name, "read as they are: export near the origin"),
        *hidden.lines(path.name, "hidden, as the file says"),
    ]
    return raw


def _tessellated(data: bytes, name: str, linear_mm: float) -> bytes:
    """The GLB that OpenCASCADE makes of a file's text, with a primitive for every face."""
    try:
        import cascadio
    except ImportError as error:
        raise CadFileError(
            f"{name} is a STEP file, and the reader for STEP (cascadio) is not installed: use the zip for your platform."
        ) from error
    glb = cascadio.to_glb_bytes(data, tol_linear=linear_mm, tol_angular=ANGULAR_RAD, merge_primitives=False)
    if not glb:
        raise CadFileError(f"{name} cannot be read as STEP: it may be damaged. Export it again as AP203, AP214 or AP242.")
    return glb


def tolerance_mm(extent_m: float) -> float:
    """How far facets may be from the surface: `LINEAR_MM`, but not coarser than `COARSEST` nor finer than `FINEST` of the extent."""
    extent_mm = 1000.0 * extent_m
    return min(max(LINEAR_MM, FINEST * extent_mm), COARSEST * extent_mm) if extent_mm > 0.0 else LINEAR_MM


def _marks(statements: Statements) -> list[tuple[int, int, bytes]]:
    """Edits that name every product and occurrence by its number."""
    edits = []
    for kind, letter in ((b"PRODUCT", b"p"), (OCCURRENCE, b"u")):
        for number in statements.of_type[kind]:
            spans = statements.spans(number)
            if len(spans) > 1:
                edits.append((*spans[1], b"'%c~%d'" % (letter, number)))
    return edits


def replace_name(node: RawNode, change: Callable[[str], str]) -> RawNode:
    """The node under a changed name."""
    node.name = change(node.name)
    return node


def product_of(name: str) -> int | None:
    """The product that a mark stands for."""
    found = MARK.fullmatch(name)
    return int(found[2]) if found and found[1] == "p" else None


def _title(name: str, structure: Structure) -> str:
    return structure.products.get(product_of(name), name)


def _name(raw: RawFile, structure: Structure, hidden: Losses) -> None:
    """Names for marks, places in float64, and what the file hides."""
    products, occurrences, _ = structure.hidden
    for node in raw.nodes:
        found = MARK.fullmatch(node.name)
        number = int(found[2]) if found else None
        product = number if found and found[1] == "p" else None
        is_occurrence = found is not None and found[1] == "u" and number in structure.occurrences
        if is_occurrence:
            node.mark, node.name, product = number, structure.title(number), structure.occurrences[number][2]
            place = structure.places.get(number)
            if place is not None and _is_close(place, np.eye(4) if node.matrix is None else node.matrix):
                node.matrix = place
        elif product is None and node.mesh is not None:  # an occurrence without a statement of its own, as OpenCASCADE numbers it
            product = product_of(raw.meshes[node.mesh][0])
            node.name = structure.products.get(product, node.name)
        else:
            node.name = structure.products.get(product, node.name)
        node.product = product
        node.is_hidden = product in products or (is_occurrence and number in occurrences)
        if node.is_hidden:
            hidden.add("part{s}", node.name)
        node.is_hidden |= node.parent >= 0 and raw.nodes[node.parent].is_hidden


def _is_close(place: np.ndarray, rough: np.ndarray) -> bool:
    """Whether a place is what float32 made of it, so that it can be trusted."""
    step = 1e-5 + 1e-6 * float(np.abs(rough[:3, 3]).max())
    return bool(np.abs(place[:3, :3] - rough[:3, :3]).max() < 1e-5 and np.abs(place[:3, 3] - rough[:3, 3]).max() < step)


def _note_coarse(raw: RawFile, structure: Structure, losses: Losses) -> None:
    """Note the parts that still lie too far from their origin for float32, as their geometry could not be moved."""
    for name, pieces in raw.meshes.values():
        if any(is_coarse(piece.positions) for piece in pieces):
            losses.add("part{s} far from the origin, where shapes become coarse,", _title(name, structure))


def _put_back(raw: RawFile, structure: Structure, offsets: dict[int | None, np.ndarray]) -> None:
    """The meshes of products that were moved to their origin, in float64 where they belong."""
    for name, pieces in raw.meshes.values() if offsets else ():
        offset = offsets.get(product_of(name))
        if offset is not None:
            pieces[:] = [replace(piece, positions=piece.positions.astype(np.float64) + offset) for piece in pieces]


def _color(raw: RawFile, structure: Structure) -> None:
    """Occurrences that have a colour of their own get a mesh of that colour."""
    for node in raw.nodes:
        color = structure.occurrence_colors.get(node.mark)
        if color is None or node.mesh is None:
            continue
        key, material = (node.mesh, color), ("occurrence", color)
        title = "Color " + "".join(f"{round(255 * c):02x}" for c in color[:3])
        raw.materials.setdefault(material, CadMaterial(title, color))
        if key not in raw.meshes:
            name, pieces = raw.meshes[node.mesh]
            raw.meshes[key] = (name, [replace(piece, material=material) for piece in pieces])
        node.mesh = key


def _add_documents(raw: RawFile, path: Path, structure: Structure, above: tuple[Path, ...]) -> None:
    """Below every part whose product lies in another file, what that file holds."""
    read: dict[str, RawFile] = {}
    for index, node in enumerate(list(raw.nodes)):
        name = structure.documents.get(node.product)
        if name is None or node.mesh is not None:
            continue
        if name not in read:
            read[name] = _document(raw, path, name, above)
        _graft(raw, index, read[name], name)


def _document(raw: RawFile, path: Path, name: str, above: tuple[Path, ...]) -> RawFile:
    """Another file that this one refers to; empty with a warning where it cannot be read."""
    file, title = companion(path, name), shown_name(name)
    if file is None or file.suffix.lower() not in (".step", ".stp"):
        raw.warnings.append(f"{title} is missing: put it beside {path.name}; the parts it holds are left out.")
    elif file.resolve() in above or len(above) >= MOST_DEPTH:
        raw.warnings.append(f"{title} refers back to {path.name}: left out.")
    else:
        try:
            return read_step(file, above)
        except (CadFileError, OSError) as error:
            raw.warnings.append(f"{title}, which {path.name} refers to, is left out: {error}")
    return RawFile()


def _graft(raw: RawFile, index: int, other: RawFile, name: str) -> None:
    """The other file's nodes below one of this file's; a single root that only shows a mesh is the node itself."""
    raw.warnings += [line for line in other.warnings if line not in raw.warnings]
    raw.materials.update({(name, key): material for key, material in other.materials.items()})
    for key, (title, pieces) in other.meshes.items():
        own = [replace(p, material=None if p.material is None else (name, p.material)) for p in pieces]
        raw.meshes.setdefault((name, key), (title, own))
    roots = [node for node in other.nodes if node.parent < 0]
    if len(roots) == 1 and len(other.nodes) == 1 and roots[0].matrix is None:
        raw.nodes[index].mesh = None if roots[0].mesh is None else (name, roots[0].mesh)
        return
    first, hidden = len(raw.nodes), raw.nodes[index].is_hidden
    for node in other.nodes:
        parent = index if node.parent < 0 else first + node.parent
        mesh = None if node.mesh is None else (name, node.mesh)
        raw.nodes.append(RawNode(node.name, parent, mesh, node.matrix, node.item, node.is_hidden or hidden))


IS_STEP = starts_text(rb"ISO-10303-21")
ROW = CadFormat("STEP", {".step": IS_STEP, ".stp": IS_STEP}, read_step, place=10, fixes_unit=True)
