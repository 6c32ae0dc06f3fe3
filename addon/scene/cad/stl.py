"""STL, read here: trimesh's reader refuses words in capitals, files without `endsolid`, with bytes behind their facets or a count of 0."""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np

from .cad_format import CadFormat, Likeness
from .colors import of_faces, rgba
from .decimals import Words
from .mtl import text_of
from .polygons import triangulate
from .raw import RawFile, RawNode, RawPiece
from .text_numbers import with_points

HEADER, FACET = 84, 50
LAYOUT = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
SOLID = re.compile(rb"[ \t]*solid\b[ \t]*([^\r\n]*)", re.IGNORECASE)
MOST_FACETS, LARGEST = 1 << 27, 1e15  # and of the coordinates, of a file that is taken for an STL by its looks


def read_stl(path: Path) -> RawFile:
    """A `.stl` file: a part for each solid of a text. Its facet normals are not kept: they say nothing the triangles do not say."""
    data, raw = path.read_bytes().removeprefix(b"\xef\xbb\xbf"), RawFile()
    if _is_text(data):
        for number, (name, piece) in enumerate(_text_pieces(data, path, raw)):
            raw.meshes[number] = (name or path.stem, [piece])
    else:
        raw.meshes[0] = (path.stem, [_binary_piece(data, path, raw)])
    raw.nodes += [RawNode(name, mesh=key) for key, (name, _) in raw.meshes.items()]
    raw.warnings[:] = dict.fromkeys(raw.warnings)
    return raw


def _is_text(data: bytes) -> bool:
    is_exact = len(data) >= HEADER and len(data) == HEADER + FACET * struct.unpack_from("<I", data, 80)[0]
    return not is_exact and likeness(data[:4096], len(data)) is Likeness.TEXT


def _text_pieces(data: bytes, path: Path, raw: RawFile) -> Iterator[tuple[str, RawPiece]]:
    """The name and the triangles of each solid; `endsolid` may be missing."""
    words = Words(data)
    read = partial(_numbers, words, path, raw)
    is_corner, is_end = words.are(b"vertex"), words.are(b"endloop")
    begins = [match for at in words.starts[words.are(b"solid")].tolist() if (match := SOLID.match(data, _line_of(data, at - 1)))]
    ends = [match.start() for match in begins[1:]] + [len(data)]
    for match, end in zip(begins, ends, strict=True):
        first, last = np.searchsorted(words.starts, [match.end() + 1, end + 1])
        yield text_of(match[1].strip()), _text_piece(words, read, first + np.flatnonzero(is_corner[first:last]), is_end[first:last], first)


def _line_of(data: bytes, at: int) -> int:
    """Where the line begins that this byte is in."""
    return max(data.rfind(b"\n", 0, at), data.rfind(b"\r", 0, at)) + 1


def _numbers(words: Words, path: Path, raw: RawFile, chosen: np.ndarray) -> np.ndarray:
    """The numbers that the chosen words are, with decimal points or commas."""
    try:
        return words.numbers(chosen)
    except ValueError:
        text = b" ".join(words.raw[at : at + size].tobytes() for at, size in zip(words.starts[chosen], words.lengths[chosen], strict=True))
        if b"," not in text:
            raise
        return Words(with_points(text, path.name, raw.warnings)).numbers()


def _text_piece(words: Words, read: Callable[[np.ndarray], np.ndarray], corners: np.ndarray, is_end: np.ndarray, first: int) -> RawPiece:
    """The triangles on these corners, places of words; `is_end` which of the words from `first` on end a loop."""
    corners = corners[corners + 3 < len(words.starts)]
    points = read((corners[:, None] + [1, 2, 3]).ravel()).reshape(-1, 3)
    ends = first + np.flatnonzero(is_end)
    if 3 * len(ends) == len(points):
        return RawPiece(points, np.arange(len(points)).reshape(-1, 3))
    before = np.concatenate([[0], np.searchsorted(corners, ends), [len(points)]])
    triangles, _ = triangulate(points, np.diff(before))  # a loop of more than three corners, or one that is cut off
    return RawPiece(points, triangles)


def _binary_piece(data: bytes, path: Path, raw: RawFile) -> RawPiece:
    count, there = struct.unpack_from("<I", data, 80)[0], (len(data) - HEADER) // FACET
    if count > there:
        raw.warnings.append(f"{path.name} announces {count:,} facets and holds {there:,}: it was cut off.")
    elif count == 0 and there:
        raw.warnings.append(f"{path.name} announces no facet and holds {there:,}: they are read.")
        count = there
    facets = np.frombuffer(data, LAYOUT, min(count, there), HEADER)
    points = facets["corners"].reshape(-1, 3)
    colors = _colors(facets["attribute"], data[:80])
    return RawPiece(points, np.arange(len(points)).reshape(-1, 3), None, None, None if colors is None else of_faces(colors))


def _colors(attributes: np.ndarray, header: bytes) -> np.ndarray | None:
    """(T, 4) the colours that two programs write into the attribute of a facet, 5 bits each: Magics, whose header names a colour, red first
    and bit 15 for that colour; VisCAM, blue first and bit 15 for a colour of its own. None where there are none."""
    named, bits = header.find(b"COLOR="), [attributes >> shift & 31 for shift in (0, 5, 10)]
    is_own = attributes & 0x8000 != 0
    if named >= 0 and named + 10 <= len(header):
        plain, own = np.frombuffer(header, np.uint8, 4, named + 6) / 255.0, np.stack(bits, axis=1) / 31.0
        is_own = ~is_own
    elif is_own.any():
        plain, own = np.array([0.8, 0.8, 0.8, 1.0]), np.stack(bits[::-1], axis=1) / 31.0
    else:
        return None
    return rgba(np.where(is_own[:, None], np.concatenate([own, np.ones((len(own), 1))], axis=1), plain), is_srgb=True)


def likeness(head: bytes, size: int) -> Likeness:
    """A binary STL's length follows from its count of facets, whatever its first 80 bytes say; a text has the words. One with bytes behind
    its facets, or a count of 0 or beyond its end, is told by its first facet."""
    if len(head) >= HEADER and size == HEADER + FACET * struct.unpack_from("<I", head, 80)[0]:
        return Likeness.BINARY
    is_solid = re.match(rb"[\xef\xbb\xbf \t\r\n]*solid\b", head, re.IGNORECASE)
    if is_solid and re.search(rb"facet|endsolid", head, re.IGNORECASE):
        return Likeness.TEXT
    return Likeness.MAYBE if len(head) >= HEADER + FACET and _has_facet(head, size) else Likeness.NO


def _has_facet(head: bytes, size: int) -> bool:
    """Whether the first facet has coordinates and a normal such as STL files have."""
    count = struct.unpack_from("<I", head, 80)[0]
    facet = np.frombuffer(head, LAYOUT, 1, HEADER)[0]
    values = np.abs(np.concatenate([facet["normal"], facet["corners"].ravel()]).astype(np.float64))
    is_number = bool(np.isfinite(values).all()) and float(values.max()) < LARGEST and not ((values > 0.0) & (values < 1e-30)).any()
    length = float(np.linalg.norm(values[:3])) if is_number else -1.0
    is_unit = length == 0.0 or abs(length - 1.0) < 0.01
    is_whole = 0 < count < MOST_FACETS or (count == 0 and (size - HEADER) % FACET == 0)
    return is_whole and is_number and is_unit and values.max() > 0.0


ROW = CadFormat("STL", {".stl": likeness}, read_stl, place=20)
