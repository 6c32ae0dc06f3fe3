"""A small glTF writer, independent of the reader: numpy arrays to accessors, a document to .glb or .gltf."""

import base64
import json
import struct

import numpy as np

COMPONENTS = {"int8": 5120, "uint8": 5121, "int16": 5122, "uint16": 5123, "uint32": 5125, "float32": 5126}
TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}


class Gltf:
    """A document that grows; `blob` is its binary chunk."""

    def __init__(self, **header):
        self.document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], **header}
        self.blob = b""

    def add(self, kind, **entry):
        """Append to an array of the document; gives the index."""
        self.document.setdefault(kind, []).append(entry)
        return len(self.document[kind]) - 1

    def view(self, data, **extra):
        self.blob += b"\0" * (-len(self.blob) % 4)
        start, self.blob = len(self.blob), self.blob + data
        return self.add("bufferViews", buffer=0, byteOffset=start, byteLength=len(data), **extra)

    def accessor(self, array, stride=None, **extra):
        """An accessor of (N,) or (N, k), its rows `stride` bytes apart."""
        table = np.ascontiguousarray(array).reshape(len(array), -1)
        rows = [row.tobytes() for row in table]
        data = b"".join(row + b"\xee" * ((stride or len(row)) - len(row)) for row in rows)
        view = self.view(data, **({"byteStride": stride} if stride else {}))
        kind, component = TYPES[table.shape[1]], COMPONENTS[str(table.dtype)]
        return self.add("accessors", bufferView=view, componentType=component, count=len(table), type=kind, **extra)

    def mesh(self, positions, triangles, material=None, name=None, attributes=(), **primitive):
        """A mesh of one primitive."""
        entry = {"attributes": {"POSITION": self.accessor(np.asarray(positions, np.float32)), **dict(attributes)}, **primitive}
        if triangles is not None:
            entry["indices"] = self.accessor(np.asarray(triangles, np.uint32).ravel())
        if material is not None:
            entry["material"] = material
        return self.add("meshes", primitives=[entry], **({"name": name} if name is not None else {}))

    def node(self, parent=None, **entry):
        """A node below another, or at the root."""
        index = self.add("nodes", **entry)
        above = self.document["scenes"][0]["nodes"] if parent is None else self.document["nodes"][parent].setdefault("children", [])
        above.append(index)
        return index

    def glb(self):
        data = self.blob + b"\0" * (-len(self.blob) % 4)
        document = {**self.document, "buffers": [{"byteLength": len(data)}]} if data and "buffers" not in self.document else self.document
        text = json.dumps(document).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text + (struct.pack("<I4s", len(data), b"BIN\0") + data if data else b"")
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks

    def gltf(self, uri=None):
        """The text form; without a uri its buffer stands within it."""
        uri = uri or "data:application/octet-stream;base64," + base64.b64encode(self.blob).decode()
        return json.dumps({**self.document, "buffers": [{"byteLength": len(self.blob), "uri": uri}]}).encode()


def box(size=(1.0, 1.0, 1.0), at=(0.0, 0.0, 0.0)):
    """(8, 3) corners and (12, 3) triangles, outwards."""
    points = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], np.float64) * size + at
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    return points, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
