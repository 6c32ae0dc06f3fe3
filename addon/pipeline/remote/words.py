"""What the two ends of a renderer in its own process say to each other: pickles behind their length.

Both ends are this package, but Blender gives it a longer name: classes are looked up under the name it has at the reading end.
"""

from __future__ import annotations

import pickle
import struct
from typing import BinaryIO

PACKAGE = __package__.removesuffix(".pipeline.remote")
_LENGTH = struct.Struct("<Q")


class _Unpickler(pickle.Unpickler):
    def __init__(self, stream: BinaryIO, peer: str) -> None:
        super().__init__(stream)
        self._peer = peer

    def find_class(self, module: str, name: str) -> object:
        if module.startswith(self._peer + "."):
            module = PACKAGE + module.removeprefix(self._peer)
        return super().find_class(module, name)


def send(stream: BinaryIO, message: tuple) -> None:
    """Write one message. Raises `OSError` when nobody reads."""
    data = pickle.dumps(message, protocol=5)
    stream.write(_LENGTH.pack(len(data)))
    stream.write(data)
    stream.flush()


def receive(stream: BinaryIO, peer: str) -> tuple | None:
    """The next message of the process whose package is called `peer`; None at the end of the stream."""
    head = stream.read(_LENGTH.size)
    if len(head) < _LENGTH.size:
        return None
    return _Unpickler(_Limited(stream, _LENGTH.unpack(head)[0]), peer).load()


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
