"""PNG files from arrays (W3C PNG, third edition): 8 or 16 bits, grey, RGB or RGBA. No colour management: what goes in is shown."""

from __future__ import annotations

import struct
import zlib

import numpy as np

SIGNATURE = b"\x89PNG\r\n\x1a\n"
COLOR_TYPES = {1: 0, 3: 2, 4: 6}
LEVEL = 6


def encode_png(image: np.ndarray) -> bytes:
    """The file's bytes for an image (h, w) or (h, w, 1 | 3 | 4), uint8 or uint16, row 0 at the top."""
    if image.dtype not in (np.uint8, np.uint16):
        raise TypeError(f"a PNG holds uint8 or uint16, not {image.dtype}")
    height, width = image.shape[:2]
    pixels = image.reshape(height, width, -1)
    header = struct.pack(">IIBBBBB", width, height, 8 * image.itemsize, COLOR_TYPES[pixels.shape[2]], 0, 0, 0)
    rows = np.ascontiguousarray(pixels, dtype=image.dtype.newbyteorder(">")).view(np.uint8).reshape(height, -1)
    filtered = np.empty((height, 1 + rows.shape[1]), np.uint8)
    filtered[:, 0] = 2  # "up": the difference to the row above
    filtered[0, 1:] = rows[0]
    np.subtract(rows[1:], rows[:-1], out=filtered[1:, 1:])
    return SIGNATURE + _chunk(b"IHDR", header) + _chunk(b"IDAT", zlib.compress(filtered.tobytes(), LEVEL)) + _chunk(b"IEND", b"")


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
