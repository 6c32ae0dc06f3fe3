"""Units and axes of CAD files: names, and the change of basis to metres and Z up."""

from __future__ import annotations

import numpy as np

from ...errors import CadFileError
from ..plain_text import shown_name

METRES_PER_UNIT = {"m": 1.0, "cm": 0.01, "mm": 0.001, "um": 1e-6, "km": 1000.0, "in": 0.0254, "ft": 0.3048, "yd": 0.9144}
LONG_NAMES = {
    "metre": "m",
    "meter": "m",
    "metres": "m",
    "meters": "m",
    "centimeter": "cm",
    "centimetre": "cm",
    "millimeter": "mm",
    "millimetre": "mm",
    "millimeters": "mm",
    "millimetres": "mm",
    "micron": "um",
    "inch": "in",
    "inches": "in",
    "foot": "ft",
    "feet": "ft",
}
UPS = ("X", "Y", "Z", "-X", "-Y", "-Z")


def metres_per_unit(unit: str) -> tuple[str, float]:
    """(short name, metres) of a unit given by short or long name; raises `CadFileError` for an unknown one."""
    short = LONG_NAMES.get(unit.strip().lower(), unit.strip().lower())
    if short not in METRES_PER_UNIT:
        raise CadFileError(f"'{shown_name(unit)}' is no unit this program knows: choose one of {', '.join(METRES_PER_UNIT)}.")
    return short, METRES_PER_UNIT[short]


def z_up_from(up: str) -> np.ndarray:
    """(3, 3) rotation that turns the file's up axis to +Z, about a horizontal axis (identity for Z, y-up turns as glTF's does)."""
    rotations = {
        "Z": np.eye(3),
        "Y": np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]),
        "X": np.array([[0, 0, -1], [0, 1, 0], [1, 0, 0]]),
        "-Z": np.diag([1, -1, -1]),
        "-Y": np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]]),
        "-X": np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]]),
    }
    key = up.strip().upper()
    if key not in rotations:
        raise CadFileError(f"'{shown_name(up)}' is no up axis: choose one of {', '.join(UPS)}.")
    return rotations[key].astype(np.float64)
