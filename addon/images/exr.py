"""OpenEXR files from arrays: one part, scan lines, ZIP blocks of 16, 32-bit float or unsigned channels.

Sources: "Technical Introduction to OpenEXR", "OpenEXR File Layout". Values are kept bit for bit; no colour management.
"""

from __future__ import annotations

import struct
import zlib

import numpy as np

MAGIC, VERSION = 20000630, 2
LINES = 16
UINT, FLOAT = 0, 2
ZIP = 3


def encode_exr(channels: dict[str, np.ndarray]) -> bytes:
    """The file's bytes for named channels (h, w) float32 or uint32, row 0 at the top, stored in alphabetical order."""
    names = sorted(channels)
    height, width = channels[names[0]].shape
    lines = np.stack([np.ascontiguousarray(channels[name]).view(np.uint32) for name in names], axis=1).astype("<u4")  # (h, channels, w)
    header = _header({name: channels[name].dtype for name in names}, width, height)
    blocks = [_block(y, lines[y : y + LINES]) for y in range(0, height, LINES)]
    ends = np.cumsum([len(header) + 8 * len(blocks), *map(len, blocks)])
    return header + ends[:-1].astype("<u8").tobytes() + b"".join(blocks)


def _block(y: int, lines: np.ndarray) -> bytes:
    raw = lines.tobytes()
    packed = zlib.compress(_predicted(np.frombuffer(raw, np.uint8)), 4)
    data = packed if len(packed) < len(raw) else raw
    return struct.pack("<ii", y, len(data)) + data


def _predicted(raw: np.ndarray) -> bytes:
    """Bytes reordered (even ones first), then each replaced by its difference to the one before, plus 128."""
    ordered = np.concatenate([raw[0::2], raw[1::2]])
    out = ordered.copy()
    out[1:] = ordered[1:] - ordered[:-1] + np.uint8(128)
    return out.tobytes()


def _attribute(name: str, kind: str, value: bytes) -> bytes:
    return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value


def _header(kinds: dict[str, np.dtype], width: int, height: int) -> bytes:
    listed = b"".join(
        name.encode() + b"\0" + struct.pack("<iB3xii", UINT if kind == np.uint32 else FLOAT, 0, 1, 1) for name, kind in kinds.items()
    )
    window = struct.pack("<iiii", 0, 0, width - 1, height - 1)
    return (
        struct.pack("<ii", MAGIC, VERSION)
        + b"".join(
            [
                _attribute("channels", "chlist", listed + b"\0"),
                _attribute("compression", "compression", bytes([ZIP])),
                _attribute("dataWindow", "box2i", window),
                _attribute("displayWindow", "box2i", window),
                _attribute("lineOrder", "lineOrder", b"\0"),
                _attribute("pixelAspectRatio", "float", struct.pack("<f", 1.0)),
                _attribute("screenWindowCenter", "v2f", struct.pack("<ff", 0.0, 0.0)),
                _attribute("screenWindowWidth", "float", struct.pack("<f", 1.0)),
            ]
        )
        + b"\0"
    )
