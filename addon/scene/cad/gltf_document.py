"""The container of a glTF 2.0 file: its JSON, its buffers, and the numbers its accessors name. Source: the specification, §3.6, §4.4.

Every count is held against the bytes there are, so that a small file cannot ask for much memory.
"""

from __future__ import annotations

import base64
import json
import struct
from pathlib import Path
from typing import Any
from urllib.parse import unquote_to_bytes

import numpy as np

from ...errors import CadFileError
from . import meshopt
from .companions import Buffers
from .meshopt_filters import filtered

COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
MESHOPT = ("EXT_meshopt_compression", "KHR_meshopt_compression")
MOST_ZEROS = 1 << 24  # values of an accessor that names no bytes
BOM = b"\xef\xbb\xbf"


class Document:
    """A parsed file: `header` its JSON object, `path` where it lies, `warnings` what was odd about the container."""

    def __init__(self, data: bytes, path: Path) -> None:
        self.path, self.warnings = path, []
        self._chunk: memoryview | None = None
        text = self._chunks(data) if data[:4] == b"glTF" else data
        if text.startswith(BOM):
            self.warnings.append(f"{path.name} starts with a byte order mark, which glTF does not allow: other programs may refuse it.")
        self.header = _parsed(text, path)
        self._companions = Buffers(path, self.header)
        self._entries: dict[tuple[str, ...], list] = {}
        self._buffers: dict[int, memoryview] = {}
        self._unpacked: dict[int, memoryview] = {}
        self._arrays: dict[int, np.ndarray] = {}

    def _chunks(self, data: bytes) -> bytes:
        """The JSON chunk of a GLB; its binary chunk is kept."""
        version, length = struct.unpack_from("<II", data, 4)
        if version != 2:
            raise CadFileError(f"{self.path.name} is of glTF {version}: export it again as glTF 2.0.")
        if length > len(data):
            raise ValueError(f"{length:,} bytes are announced, {len(data):,} are there")
        text, at = b"", 12
        while at + 8 <= len(data):
            size, kind = struct.unpack_from("<I4s", data, at)
            if size > len(data) - at - 8:
                raise ValueError(f"a chunk of {size:,} bytes is announced, {len(data) - at - 8:,} are there")
            body = memoryview(data)[at + 8 : at + 8 + size]
            if kind == b"JSON" and not text:
                text = bytes(body)
            elif kind == b"BIN\0" and self._chunk is None:
                self._chunk = body
            at += 8 + size
        return text

    def entries(self, *keys: str) -> list[dict]:
        """The array of objects under these keys, empty where there is none."""
        if keys not in self._entries:
            found: object = self.header
            for key in keys:
                found = found.get(key) if isinstance(found, dict) else None
            self._entries[keys] = found if isinstance(found, list) else []
            if keys[-1] != "extensionsRequired" and not all(isinstance(one, dict) for one in self._entries[keys]):
                raise ValueError(f"{keys[-1]} holds something else than objects")
        return self._entries[keys]

    def entry(self, key: str, index: object) -> dict:
        """One object of an array; raises `ValueError` where it is not there."""
        return picked(self.entries(key), index, key)

    def buffer(self, index: int) -> memoryview:
        """The bytes of a buffer. Raises `CadFileError` where a file it names is missing."""
        if index not in self._buffers:
            uri = self.entry("buffers", index).get("uri")
            if uri is None:
                if index or self._chunk is None:
                    raise ValueError(f"buffer {index} names no bytes")
                self._buffers[index] = self._chunk
            else:
                self._buffers[index] = memoryview(data_of(uri) if uri.startswith("data:") else self._companions.get(uri))
        return self._buffers[index]

    def view(self, index: int) -> tuple[memoryview, int]:
        """The bytes of a buffer view, and its stride (0: packed)."""
        view = self.entry("bufferViews", index)
        packed = next((view["extensions"][name] for name in MESHOPT if name in view.get("extensions", {})), None)
        if packed is None:
            return self._slice(view, index), view.get("byteStride", 0)
        if index not in self._unpacked:
            self._unpacked[index] = _unpacked(packed, bytes(self._slice(packed, index)))
        return self._unpacked[index], view.get("byteStride", 0)

    def _slice(self, view: dict, index: int) -> memoryview:
        buffer, start, length = self.buffer(view["buffer"]), view.get("byteOffset", 0), view["byteLength"]
        if not 0 <= start <= start + length <= len(buffer):
            raise ValueError(f"bufferView {index} lies outside its buffer of {len(buffer):,} bytes")
        return buffer[start : start + length]

    def numbers(self, index: int) -> np.ndarray:
        """(N,) or (N, k) the values of an accessor: integers as they are, normalized ones and floats as float32 (§3.6.2.2)."""
        if index not in self._arrays:
            self._arrays[index] = self._read(self.entry("accessors", index))
        return self._arrays[index]

    def provide(self, index: int, values: np.ndarray) -> None:
        """Let these be the values of an accessor, (N,) or (N, k) as stored."""
        is_parts = self.entry("accessors", index).get("normalized") and values.dtype.kind in "iu"
        self._arrays[index] = unit_range(values) if is_parts else values

    def _read(self, accessor: dict) -> np.ndarray:
        dtype, width, count = np.dtype(COMPONENTS[accessor["componentType"]]), WIDTHS[accessor["type"]], int(accessor["count"])
        if "bufferView" in accessor:
            values = self._table(accessor["bufferView"], accessor.get("byteOffset", 0), dtype, count, width)
        elif 0 <= count <= MOST_ZEROS:
            values = np.zeros((count, width), dtype)
        else:
            raise ValueError(f"{count:,} values are announced without data")
        if "sparse" in accessor:
            values = self._patched(values, accessor["sparse"], dtype, width)
        if accessor.get("normalized") and dtype.kind in "iu":
            values = unit_range(values)
        return values[:, 0] if width == 1 else values

    def _table(self, view: int, offset: int, dtype: np.dtype, count: int, width: int) -> np.ndarray:
        data, stride = self.view(view)
        stride = stride or dtype.itemsize * width
        end = offset + stride * (count - 1) + dtype.itemsize * width if count else offset
        if count < 0 or offset < 0 or stride < 0 or end > len(data):
            raise ValueError(f"an accessor of {count:,} values lies outside its bufferView of {len(data):,} bytes")
        return np.ndarray((count, width), dtype, data, offset, (stride, dtype.itemsize))

    def _patched(self, values: np.ndarray, sparse: dict, dtype: np.dtype, width: int) -> np.ndarray:
        """A copy with the rows that a sparse accessor writes down (§3.6.2.3)."""
        count, index, rows = int(sparse["count"]), sparse["indices"], sparse["values"]
        at = self._table(index["bufferView"], index.get("byteOffset", 0), np.dtype(COMPONENTS[index["componentType"]]), count, 1)[:, 0]
        if len(at) and int(at.max()) >= len(values):
            raise ValueError("a sparse accessor writes outside its values")
        out = values.copy()
        out[at] = self._table(rows["bufferView"], rows.get("byteOffset", 0), dtype, count, width)
        return out


def _unpacked(packed: dict, data: bytes) -> memoryview:
    """The bytes of a view that is compressed with meshopt, as its extension says."""
    mode, count, stride = packed["mode"], int(packed["count"]), int(packed["byteStride"])
    if mode == "ATTRIBUTES":
        return memoryview(filtered(meshopt.attributes(data, count, stride), packed.get("filter", "NONE")).tobytes())
    decode = {"TRIANGLES": meshopt.triangles, "INDICES": meshopt.indices}[mode]
    return memoryview(decode(data, count).astype({2: "<u2", 4: "<u4"}[stride]).tobytes())


def picked(array: list, index: object, what: str) -> Any:
    """One entry of an array; raises `ValueError` where it is not there."""
    if not isinstance(index, int) or not 0 <= index < len(array):
        raise ValueError(f"{what} {str(index)[:20]} is used and is not there")
    return array[index]


def unit_range(values: np.ndarray) -> np.ndarray:
    """Integers as float32 in 0…1, or −1…1 where they are signed (§3.6.2.2)."""
    most = np.float32(np.iinfo(values.dtype).max)
    return np.maximum(values.astype(np.float32) / most, np.float32(-1.0))


def data_of(uri: str) -> bytes:
    """The bytes of a `data:` URI."""
    head, _, body = uri.partition(",")
    raw = unquote_to_bytes(body)
    return base64.b64decode(raw) if head.rstrip().endswith(";base64") else raw


def _parsed(text: bytes, path: Path) -> dict:
    try:
        header = json.loads(text.decode("utf-8-sig", "replace"))
    except RecursionError as error:
        raise ValueError("its JSON is nested too deeply") from error
    if not isinstance(header, dict):
        raise ValueError("its JSON is no object")
    asset = header.get("asset")
    version = str(asset.get("version", "2.0")) if isinstance(asset, dict) else "2.0"
    if not version.startswith("2."):
        raise CadFileError(f"{path.name} is of glTF {version[:20]}: export it again as glTF 2.0.")
    return header
