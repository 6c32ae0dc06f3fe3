"""Whether a picture file is whole: all there, to its last byte, and decodable. For what others write, who may not tell of a full disk.

Sources: W3C PNG, third edition; "OpenEXR File Layout". Pixels are unpacked as far as the standard library can: all of PNG, EXR's ZIP.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from .exr import MAGIC
from .png import COLOR_TYPES, SIGNATURE

CHANNELS = {color_type: channels for channels, color_type in COLOR_TYPES.items()} | {3: 1, 4: 2}
BLOCK = 1 << 20
TILED, DEEP_OR_PARTS = 0x200, 0x1800
HALF = 1
ZIPPED = (2, 3)
LINES_PER_BLOCK = {0: 1, 1: 1, 2: 1, 3: 16, 4: 32, 5: 16, 6: 32, 7: 32, 8: 32, 9: 256}
"""Scan lines of a block by compression: none, RLE, ZIPS, ZIP, PIZ, PXR24, B44, B44A, DWAA, DWAB."""


def check_picture(path: Path) -> None:
    """Raise `ValueError`, which says what is wrong, when a .png or .exr file is not whole. Other files need only hold something."""
    if not path.stat().st_size:
        raise ValueError("it is empty")
    check = {".png": check_png, ".exr": check_exr}.get(path.suffix.lower())
    if check is None:
        return
    with path.open("rb") as file:
        try:
            check(file)
        except (struct.error, zlib.error, IndexError, KeyError) as error:
            raise ValueError("its end is missing") from error


def check_png(file: BinaryIO) -> None:
    """Every chunk whole, and as much picture in them as the header says."""
    if file.read(len(SIGNATURE)) != SIGNATURE:
        raise ValueError("it is no PNG")
    unpacker, size, found = zlib.decompressobj(), None, 0
    for kind, data in _chunks(file):
        if kind == b"IHDR":
            width, height, bits, color, _, _, interlaced = struct.unpack(">IIBBBBB", data)
            size = None if interlaced else height * (1 + (width * CHANNELS[color] * bits + 7) // 8)
        elif kind == b"IDAT":
            found += sum(map(len, _unpacked(unpacker, data)))
    if size is not None and found != size:
        raise ValueError("its end is missing")


def _chunks(file: BinaryIO) -> Iterator[tuple[bytes, bytes]]:
    """The chunks up to IEND, each checked; `ValueError` when one is not whole."""
    kind = b""
    while kind != b"IEND":
        length, kind = struct.unpack(">I4s", file.read(8))
        data, check = file.read(length), file.read(4)
        if len(data) < length or struct.unpack(">I", check)[0] != zlib.crc32(kind + data):
            raise ValueError("its end is missing")
        yield kind, data


def _unpacked(unpacker: object, data: bytes) -> Iterator[bytes]:
    """What `data` unpacks to, never much at a time."""
    while data:
        yield unpacker.decompress(data, BLOCK)
        data = unpacker.unconsumed_tail


def check_exr(file: BinaryIO) -> None:
    """Every block of a plain image there and as long as it says, the last one ending with the file; of others only the header."""
    magic, version = struct.unpack("<ii", file.read(8))
    if magic != MAGIC:
        raise ValueError("it is no OpenEXR file")
    header = _header(file)
    lines = LINES_PER_BLOCK.get(header["compression"][0])
    if version & (TILED | DEEP_OR_PARTS) or lines is None:
        return
    x0, y0, x1, y1 = struct.unpack("<iiii", header["dataWindow"])
    line_bytes = _pixel_bytes(header["channels"]) * (x1 - x0 + 1)
    count = -(-(y1 - y0 + 1) // lines)
    starts, last = struct.unpack(f"<{count}Q", file.read(8 * count)), 0
    for start in starts:
        y, data = _block(file, start)
        last = max(last, file.tell())
        raw = line_bytes * min(lines, y1 + 1 - y)
        if header["compression"][0] in ZIPPED and len(data) < raw and len(zlib.decompress(data)) != raw:
            raise ValueError("its end is missing")
    if last != file.seek(0, 2):
        raise ValueError("its end is missing")


def _pixel_bytes(channels: bytes) -> int:
    """Bytes of a pixel of a channel list: 32 bits, but 16 of a half float."""
    total = 0
    while len(channels) > 1:
        name, _, rest = channels.partition(b"\0")
        total += 2 if struct.unpack_from("<i", rest)[0] == HALF else 4
        channels = rest[16:]
    return total


def _header(file: BinaryIO) -> dict[str, bytes]:
    """The attributes by name."""
    found: dict[str, bytes] = {}
    while name := _text(file):
        _text(file)
        length = struct.unpack("<i", file.read(4))[0]
        found[name] = file.read(length)
    return found


def _text(file: BinaryIO) -> str:
    out = b""
    while (byte := file.read(1)) != b"\0":
        if not byte:
            raise ValueError("its end is missing")
        out += byte
    return out.decode("latin-1")


def _block(file: BinaryIO, start: int) -> tuple[int, bytes]:
    """(first line, packed pixels) of the block that starts there; `ValueError` when it is not all there."""
    file.seek(start)
    y, length = struct.unpack("<ii", file.read(8))
    data = file.read(length)
    if not start or len(data) < length:
        raise ValueError("its end is missing")
    return y, data
