"""Draco streams of glTF primitives, decoded by Google's library in the wheel DracoPy. Source: KHR_draco_mesh_compression."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...errors import CadFileError

INDICES = "indices"


def decoded(data: bytes, names: Mapping[str, int], file: str) -> dict[str, np.ndarray]:
    """(V, k) each attribute named, by its number in the stream, and under "indices" the triangles (3 T,). `file` is for messages.

    Raises `CadFileError` where the library is missing, `ValueError` for what is no such stream.
    """
    try:
        import DracoPy
    except ImportError as error:
        raise CadFileError(missing_message(file)) from error
    try:
        mesh = DracoPy.decode(data)
    except DracoPy.FileTypeException as error:
        raise ValueError("its Draco data is no such stream") from error
    by_number = {own["unique_id"]: own["data"] for own in mesh.attributes}
    if lacking := [name for name, number in names.items() if number not in by_number]:
        raise ValueError(f"its Draco data lacks {', '.join(lacking)[:80]}")
    found = {name: np.asarray(by_number[number]) for name, number in names.items()}
    return {**found, INDICES: np.asarray(mesh.faces, np.int64).ravel()}


def missing_message(file: str) -> str:
    """What to do with a compressed file where the library is missing."""
    return (
        f"{file} is compressed with Draco (KHR_draco_mesh_compression), and the library that reads it (DracoPy) is not installed: "
        f"use the zip for your platform, or export the file without compression."
    )
