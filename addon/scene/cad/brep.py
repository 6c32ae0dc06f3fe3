"""OpenCASCADE's own BREP files, by the library OCP (cadquery-ocp) where it is installed: cascadio, which is always there, reads none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ...errors import CadFileError
from .cad_format import CadFormat, Likeness
from .losses import Losses
from .raw import RawFile, RawNode, RawPiece

COARSE_PART, ANGULAR_RAD = 1e-3, 0.3  # of the shape's size, between surface and facets; and between facets


def read_brep(path: Path) -> RawFile:
    """A `.brep` file: a part for each of the shapes it is composed of, in millimetres. Raises `CadFileError` where OCP is not installed."""
    try:
        from OCP.BinTools import BinTools
        from OCP.BRep import BRep_Builder
        from OCP.BRepTools import BRepTools
        from OCP.TopoDS import TopoDS_Iterator, TopoDS_Shape
    except ImportError as error:
        raise CadFileError(
            f"{path.name} is a BREP file, which takes the library OCP (cadquery-ocp), and that is not installed: export it as STEP."
        ) from error
    shape = TopoDS_Shape()
    if path.read_bytes()[:80].lstrip().startswith(b"Open CASCADE"):
        BinTools.Read_s(shape, str(path))
    else:
        BRepTools.Read_s(shape, str(path), BRep_Builder())
    if shape.IsNull():
        raise CadFileError(f"{path.name} cannot be read as BREP: it may be damaged. Export it again, or as STEP.")
    raw, losses = RawFile(), Losses()
    parts = [shape]
    if shape.ShapeType().value == 0:  # a compound
        parts, inside = [], TopoDS_Iterator(shape)
        while inside.More():
            parts.append(inside.Value())
            inside.Next()
    for number, part in enumerate(parts):
        name = path.stem if len(parts) == 1 else f"{path.stem} {number + 1}"
        raw.meshes[number] = (name, [_piece(part, losses, name)])
        raw.nodes.append(RawNode(name, mesh=number))
    raw.warnings += losses.lines(path.name, "left out: OpenCASCADE could not mesh them")
    return raw


def _piece(shape: Any, losses: Losses, name: str) -> RawPiece:
    """The facets of a shape's faces, which are turned as their face is."""
    from OCP.Bnd import Bnd_Box
    from OCP.BRep import BRep_Tool
    from OCP.BRepBndLib import BRepBndLib
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.TopAbs import TopAbs_FACE, TopAbs_REVERSED
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS

    box = Bnd_Box()
    BRepBndLib.Add_s(shape, box)
    size = float(np.sqrt(box.SquareExtent())) if not box.IsVoid() else 1.0
    BRepMesh_IncrementalMesh(shape, max(COARSE_PART * size, 1e-6), False, ANGULAR_RAD)
    points, triangles, first = [np.empty((0, 3))], [np.empty((0, 3), np.int64)], 0
    faces = TopExp_Explorer(shape, TopAbs_FACE)
    while faces.More():
        face, place = TopoDS.Face_s(faces.Current()) if hasattr(TopoDS, "Face_s") else TopoDS.Face(faces.Current()), TopLoc_Location()
        mesh = BRep_Tool.Triangulation_s(face, place)
        faces.Next()
        if mesh is None:
            losses.add("face{s}", name)
            continue
        move = place.Transformation()
        nodes = [mesh.Node(i + 1).Transformed(move) for i in range(mesh.NbNodes())]
        index = np.array([mesh.Triangle(i + 1).Get() for i in range(mesh.NbTriangles())], np.int64).reshape(-1, 3) - 1
        points.append(np.array([(p.X(), p.Y(), p.Z()) for p in nodes]).reshape(-1, 3))
        triangles.append(first + (index[:, ::-1] if face.Orientation() == TopAbs_REVERSED else index))
        first += len(nodes)
    return RawPiece(np.concatenate(points), np.concatenate(triangles))


def likeness(head: bytes, _size: int) -> Likeness:
    """The words that its two forms begin with."""
    start = head[:200].lstrip()
    is_text = start.startswith((b"DBRep_DrawableShape", b"CASCADE Topology"))
    return Likeness.BINARY if start.startswith(b"Open CASCADE Topology") else Likeness.TEXT if is_text else Likeness.NO


ROW = CadFormat("BREP", {".brep": likeness, ".brp": likeness}, read_brep, place=130, unit="mm", fixes_unit=True)
