"""The contact sheet of a batch: what was written, read back and put side by side. Needs Blender, which reads the pictures."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np

from ...blender.lettering import lines
from ...images.contact_sheet import contact_sheet
from ...images.png import encode_png
from ...images.srgb import srgb
from ...studies.outputs import write_bytes
from .stamp import picture_of

NAME = "contact_sheet.png"
EMPTY = np.full((90, 160, 3), 0.2, np.float32)


def write_sheet(path: Path, pictures: list[np.ndarray], captions: list[str], columns: int | None = None) -> None:
    """Write pictures as displayed (0…1) with captions as one PNG; raises `OutputError`."""
    sheet = contact_sheet(pictures, captions, columns, written=lines)
    write_bytes(path, encode_png(np.rint(np.clip(sheet[..., :3], 0.0, 1.0) * 255.0).astype(np.uint8)))


def batch_sheet(reports: list[dict[str, object]], names: list[str], folder: Path) -> tuple[list[np.ndarray], list[str]]:
    """Picture and caption of every input; an empty tile for one that failed or has no picture."""
    pictures, captions = [], []
    for report, name in zip(reports, names, strict=True):
        path = picture_of(report, folder)
        pictures.append(EMPTY if path is None else read_picture(path))
        captions.append(f"{name}: failed" if report["errors"] else name)
    return pictures, captions


def read_picture(path: Path) -> np.ndarray:
    """(h, w, 4) float32 of a picture as displayed, row 0 at the top. EXR and npz hold linear light and get the sRGB curve."""
    if path.suffix == ".npz":
        with np.load(path) as arrays:
            return srgb(arrays["combined"]) if "combined" in arrays else EMPTY
    image = bpy.data.images.load(str(path.absolute()), check_existing=False)
    try:
        image.colorspace_settings.name = "Non-Color"
        width, height = image.size
        values = np.empty(width * height * 4, np.float32)
        image.pixels.foreach_get(values)
    finally:
        bpy.data.images.remove(image)
    picture = values.reshape(height, width, 4)[::-1]
    return srgb(picture) if path.suffix == ".exr" else picture
