"""A `CadModel` as bytes and back: a head of JSON, then the arrays as they lie in memory.

Not pickled: what comes from a process that has read a stranger's file is data, and names no code. Records are those of `cad_model` alone.
"""

from __future__ import annotations

import dataclasses
import json
import struct
from typing import IO, Any

import numpy as np

from .. import cad_model

_LENGTH = struct.Struct("<Q")
MOST_HEAD = 1 << 31
RECORDS = {name: kind for name, kind in vars(cad_model).items() if dataclasses.is_dataclass(kind) and isinstance(kind, type)}


def send(stream: IO[bytes], message: object) -> None:
    """Write a message: None, bool, int, float, str, bytes, tuples, dicts, arrays of numbers, records of `cad_model`.

    Raises `TypeError` for anything else, `OSError` when nobody reads.
    """
    arrays: list[np.ndarray] = []
    tree = _packed(message, arrays)
    head = json.dumps({"tree": tree, "arrays": [(array.dtype.str, array.shape) for array in arrays]}, separators=(",", ":")).encode()
    stream.write(_LENGTH.pack(len(head)))
    stream.write(head)
    for array in arrays:
        stream.write(memoryview(array).cast("B") if array.size else b"")
    stream.flush()


def receive(stream: IO[bytes]) -> Any:
    """Read a message; lists come as tuples. Raises `EOFError` where it ends early and `ValueError` for what is no message."""
    length = _LENGTH.unpack(_filled(stream, np.empty(_LENGTH.size, np.uint8)).tobytes())[0]
    if length > MOST_HEAD:
        raise ValueError(f"a head of {length} bytes")
    head = json.loads(_filled(stream, np.empty(length, np.uint8)).tobytes())
    arrays = [_filled(stream, np.empty(shape, _numbers(kind))) for kind, shape in head["arrays"]]
    return _unpacked(head["tree"], arrays)


def _numbers(kind: str) -> np.dtype:
    dtype = np.dtype(kind)
    if dtype.kind not in "biuf":
        raise ValueError(f"an array of {kind}")
    return dtype


def _filled(stream: Any, array: np.ndarray) -> np.ndarray:
    """The array, filled with what comes next."""
    left = memoryview(array).cast("B") if array.size else memoryview(b"")
    while len(left):
        count = stream.readinto(left)
        if not count:
            raise EOFError
        left = left[count:]
    return array


def _packed(value: object, arrays: list[np.ndarray]) -> object:
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, tuple | list):
        return [_packed(one, arrays) for one in value]
    if isinstance(value, bytes):
        value, kind = np.frombuffer(value, np.uint8), "bytes"
    elif isinstance(value, np.generic):
        return value.item()
    elif isinstance(value, np.ndarray):
        kind = "array"
    elif isinstance(value, dict):
        return {"dict": [[_packed(key, arrays), _packed(one, arrays)] for key, one in value.items()]}
    elif type(value).__name__ in RECORDS and dataclasses.is_dataclass(value):
        fields = [(field.name, getattr(value, field.name)) for field in dataclasses.fields(value)]
        return {"record": type(value).__name__, "fields": {name: _packed(one, arrays) for name, one in fields}}
    else:
        raise TypeError(f"{type(value).__name__} cannot be sent")
    arrays.append(np.ascontiguousarray(value))
    return {kind: len(arrays) - 1}


def _unpacked(tree: object, arrays: list[np.ndarray]) -> object:
    if isinstance(tree, list):
        return tuple(_unpacked(one, arrays) for one in tree)
    if not isinstance(tree, dict):
        return tree
    if "record" in tree:
        return RECORDS[tree["record"]](**{name: _unpacked(one, arrays) for name, one in tree["fields"].items()})
    if "dict" in tree:
        return {_unpacked(key, arrays): _unpacked(one, arrays) for key, one in tree["dict"]}
    return arrays[tree["array"]] if "array" in tree else arrays[tree["bytes"]].tobytes()
