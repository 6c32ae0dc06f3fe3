"""Lines of text in Blender's own fonts, which know every script. Drawn on the CPU: no window and no GPU are needed."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from math import ceil
from pathlib import Path
from tempfile import TemporaryDirectory, gettempdir

import blf
import bpy
import imbuf
import numpy as np

from ..errors import OutputError
from ..images import lettering
from ..scene.plain_text import shown

FONT, SIZE = 0, 13  # Blender's interface font; what it lacks comes from the fonts beside it
HEIGHT, BASELINE = 24, 7
AT_ONCE = 128


def lines(texts: Sequence[str], width: int) -> list[np.ndarray]:
    """(h, w) coverage 0…1 of each text; what is wider than `width` pixels ends in '…'. On the main thread. Raises `OutputError`.

    Blender before 4.5 draws its fonts into windows only: there it is the face of `images/lettering.py`.
    """
    if not hasattr(blf, "bind_imbuf"):
        return lettering.lines(texts, width)
    blf.size(FONT, SIZE)
    fitting = [_fitting(shown(text), width) for text in texts]
    return [line for first in range(0, len(fitting), AT_ONCE) for line in _drawn(fitting[first : first + AT_ONCE], width)]


def _width(text: str) -> float:
    return blf.dimensions(FONT, text)[0]


def _fitting(text: str, width: int) -> str:
    """The text, or as much of its beginning as there is room for."""
    if _width(text) <= width:
        return text
    kept = bisect_right(range(len(text)), width, key=lambda count: _width(f"{text[:count]}…"))
    return f"{text[: kept - 1]}…" if kept else ""


def _drawn(texts: list[str], width: int) -> list[np.ndarray]:
    image = imbuf.new((width, HEIGHT * len(texts)))
    blf.color(FONT, 1.0, 1.0, 1.0, 1.0)
    with blf.bind_imbuf(FONT, image):
        for row, text in enumerate(texts):
            blf.position(FONT, 0, row * HEIGHT + BASELINE, 0)
            blf.draw_buffer(FONT, text)
    coverage = _alpha(image)
    image.free()
    rows = [coverage[row * HEIGHT : (row + 1) * HEIGHT][::-1] for row in range(len(texts))]
    return [line[:, : min(ceil(_width(text)), width)] for line, text in zip(rows, texts, strict=True)]


def _alpha(image: imbuf.types.ImBuf) -> np.ndarray:
    """(h, w) float32 alpha of Blender's image, its first row at the bottom. Only 5.2 lets scripts read its pixels; all can write a file."""
    try:
        with TemporaryDirectory(prefix="cad-shadow-") as folder:
            path = str(Path(folder, "lines.png"))
            imbuf.write(image, filepath=path)
            loaded = bpy.data.images.load(path)
            width, height = loaded.size
            values = np.empty(width * height * 4, np.float32)
            loaded.pixels.foreach_get(values)
            bpy.data.images.remove(loaded)
    except (OSError, RuntimeError) as error:
        reason = " ".join(str(error).split())
        raise OutputError(f"No temporary file can be written to {gettempdir()} ({reason}): free space there, or set TMPDIR.") from error
    return values.reshape(height, width, 4)[..., 3]
