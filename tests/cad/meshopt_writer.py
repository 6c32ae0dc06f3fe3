"""The encoders of meshoptimizer itself, in the library that Blender 5.2 carries: independent of the decoders here."""

import ctypes
from importlib.util import find_spec
from pathlib import Path

import numpy as np


def library():
    """meshoptimizer's library; None where this Blender has none."""
    found = sorted(Path(find_spec("bpy").origin).parent.glob("lib/libmeshoptimizer.*"))
    return ctypes.CDLL(str(found[0])) if found else None


class Encoder:
    """Byte streams of `library`, a ctypes library; `version` of the vertex codec, 0 or 1, and the pains it takes, 0 to 3."""

    def __init__(self, lib, version, level=3):
        self._lib, self._version, self._level = lib, version, level

    def attributes(self, elements):
        """Of (N, stride) uint8."""
        return self._called("Vertex", elements, elements.shape, elements.shape, "Level", self._level, self._version)

    def triangles(self, index):
        """Of (3 T,) indices."""
        index = np.ascontiguousarray(index, np.uint32)
        return self._called("Index", index, (len(index), int(index.max()) + 1), (len(index),))

    def indices(self, index):
        """Of (N,) indices in any order."""
        index = np.ascontiguousarray(index, np.uint32)
        return self._called("IndexSequence", index, (len(index), int(index.max()) + 1), (len(index),))

    def _called(self, kind, array, bound, sizes, variant="", *further):
        array = np.ascontiguousarray(array)
        name = kind if kind == "IndexSequence" else kind + "Buffer"
        most, encode = getattr(self._lib, f"meshopt_encode{name}Bound"), getattr(self._lib, f"meshopt_encode{name}{variant}")
        most.restype = encode.restype = ctypes.c_size_t
        out = ctypes.create_string_buffer(most(*map(ctypes.c_size_t, bound)))
        size = encode(out, ctypes.c_size_t(len(out)), array.ctypes.data_as(ctypes.c_void_p), *map(ctypes.c_size_t, sizes), *further)
        return out.raw[:size]

    def filtered(self, name, values, stride, bits):
        """(N, stride) uint8 of (N, k) floats."""
        values = np.ascontiguousarray(values, np.float32)
        out = np.zeros((len(values), stride), np.uint8)
        arguments = [ctypes.c_size_t(len(values)), ctypes.c_size_t(stride), bits, values.ctypes.data_as(ctypes.c_void_p)]
        getattr(self._lib, f"meshopt_encodeFilter{name}")(out.ctypes.data_as(ctypes.c_void_p), *arguments, *([0] if name == "Exp" else []))
        return out
