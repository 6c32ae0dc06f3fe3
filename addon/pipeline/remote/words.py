"""What the two ends of a renderer in its own process say to each other: pickles behind their length.

Both ends are this package, but Blender gives it a longer name: classes are looked up under the name it has at the reading end. A message
makes nothing but arrays and records and errors of this package; tasks, which are functions, are taken only by the end that does them.
"""

from __future__ import annotations

import dataclasses
import pickle
import struct
from enum import Enum
from types import FunctionType
from typing import BinaryIO

from ...errors import UserError

PACKAGE = __package__.removesuffix(".pipeline.remote")
_LENGTH = struct.Struct("<Q")


_ARRAYS = {("numpy", "dtype"), ("numpy", "ndarray")} | {
    (f"numpy.{core}.{module}", name)
    for core in ("_core", "core")
    for module, name in (("multiarray", "scalar"), ("multiarray", "_reconstruct"), ("numeric", "_frombuffer"))
}


class _Unpickler(pickle.Unpickler):
    def __init__(self, stream: BinaryIO, peer: str, takes_tasks: bool) -> None:
        super().__init__(stream)
        self._peer, self._takes_tasks = peer, takes_tasks

    def find_class(self, module: str, name: str) -> object:
        if (module, name) in _ARRAYS:
            return super().find_class(module, name)
        if not module.startswith(self._peer + ".") or "." in name:
            raise pickle.UnpicklingError(f"{module}.{name} is not for messages")
        found = super().find_class(PACKAGE + module.removeprefix(self._peer), name)
        is_ours = getattr(found, "__module__", "").startswith(PACKAGE + ".")
        is_data = isinstance(found, type) and (dataclasses.is_dataclass(found) or issubclass(found, tuple | Enum | UserError))
        is_task = self._takes_tasks and isinstance(found, FunctionType) and found.__module__.startswith(PACKAGE + ".pipeline.")
        if not (is_ours and (is_data or is_task)):
            raise pickle.UnpicklingError(f"{module}.{name} is not for messages")
        return found


def send(stream: BinaryIO, message: tuple) -> None:
    """Write one message. Raises `OSError` when nobody reads."""
    data = pickle.dumps(message, protocol=5)
    stream.write(_LENGTH.pack(len(data)))
    stream.write(data)
    stream.flush()


def receive(stream: BinaryIO, peer: str, takes_tasks: bool = False) -> tuple | None:
    """The next message of the process whose package is called `peer`; None at the end of the stream.

    Raises `pickle.UnpicklingError` for what names anything else than data, or tasks where `takes_tasks`.
    """
    head = stream.read(_LENGTH.size)
    if len(head) < _LENGTH.size:
        return None
    return _Unpickler(_Limited(stream, _LENGTH.unpack(head)[0]), peer, takes_tasks).load()


class _Limited:
    """So many bytes of a stream, as a file to read."""

    def __init__(self, stream: BinaryIO, length: int) -> None:
        self._stream, self._left = stream, length

    def read(self, count: int = -1) -> bytes:
        """At most what is left."""
        data = self._stream.read(self._left if count < 0 else min(count, self._left))
        self._left -= len(data)
        return data

    def readinto(self, buffer: memoryview) -> int:
        """Fill the buffer; how many bytes."""
        count = self._stream.readinto(memoryview(buffer)[: self._left])
        self._left -= count
        return count

    def readline(self) -> bytes:
        """A line, which pickles of protocol 0 have."""
        data = self._stream.readline(self._left)
        self._left -= len(data)
        return data
