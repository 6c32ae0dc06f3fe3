"""A small valid file of each format that is read, with what the format has: names, colours, instances, polygons."""

from __future__ import annotations

import io
import struct
import zipfile
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from tests.cad.gltf_writer import Gltf
from tests.cad.step_writer import Step

POINTS = np.array([[x, y, z] for x in (0, 2) for y in (0, 4) for z in (0, 6)], np.float32)
SIDES = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
TRIANGLES = np.concatenate([SIDES[:, [0, 1, 2]], SIDES[:, [0, 2, 3]]])


class Seed(NamedTuple):
    """`data`, the file; `inner`, what lies within its packing, where it has one, and `packed(inner)`, the file of that."""

    data: bytes
    inner: bytes | None = None
    packed: Callable[[bytes], bytes] | None = None


def _gltf(is_binary: bool) -> bytes:
    gltf = Gltf()
    red = gltf.add("materials", name="red", pbrMetallicRoughness={"baseColorFactor": [1, 0, 0, 1], "metallicFactor": 0.5})
    mesh = gltf.mesh(POINTS, TRIANGLES, red, "box")
    top = gltf.node(name="Bolt", translation=[1, 2, 3])
    for number in range(2):
        gltf.node(top, name="Bolt", mesh=mesh, rotation=[0, 0, 0.7071068, 0.7071068], scale=[1, 1, 1 + number])
    return gltf.glb() if is_binary else gltf.gltf()


def _stl() -> bytes:
    facets = (struct.pack("<12fH", 0, 0, 1, *POINTS[t].ravel(), 0) for t in TRIANGLES)
    return b"seed".ljust(80) + struct.pack("<I", len(TRIANGLES)) + b"".join(facets)


def _obj() -> bytes:
    text = "# seed\no first\nusemtl red\n" + "".join(f"v {x} {y} {z}\n" for x, y, z in POINTS) + "vn 0 0 1\nvt 0 0\n"
    text += "".join("f " + " ".join(f"{i + 1}/1/1" for i in side) + "\n" for side in SIDES[:3])
    text += "o second\n" + "".join("f " + " ".join(f"{i - 8}" for i in side) + "\n" for side in SIDES[3:])
    return (text + "o third\nv 0 0 0 1 0 0\nv 9 0 0 0 1 0\nv 9 9 0 0 0 1\nv 4 4 0 1 1 1\nv 0 9 0 1 1 0\nf -5 -4 -3 -2 -1\n").encode()


def _ply() -> bytes:
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(POINTS)}\n" + "".join(f"property float {c}\n" for c in "xyz")
    head += f"element face {len(TRIANGLES)}\nproperty list uchar int vertex_indices\nend_header\n"
    return head.encode() + POINTS.astype("<f4").tobytes() + b"".join(struct.pack("<B3i", 3, *t) for t in TRIANGLES)


def _off() -> bytes:
    text = f"COFF\n{len(POINTS)} {len(SIDES)} 0\n" + "".join(f"{x} {y} {z} 255 0 0 255\n" for x, y, z in POINTS)
    return (text + "".join("4 " + " ".join(map(str, side)) + " 0 255 0\n" for side in SIDES)).encode()


def _3mf() -> bytes:
    vertices = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>\n' for x, y, z in POINTS)
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}" pid="9" p1="{i % 2}"/>\n' for i, (a, b, c) in enumerate(TRIANGLES))
    model = (
        '<?xml version="1.0" encoding="UTF-8"?>\n<model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">'
        '<resources>\n<basematerials id="9"><base name="paint" displaycolor="#FF0000"/><base name="bare" displaycolor="#00FF0080"/>'
        f'</basematerials>\n<object id="1" name="box" pid="9" pindex="0"><mesh><vertices>\n{vertices}</vertices><triangles>\n{triangles}'
        '</triangles></mesh></object>\n<object id="2" name="pair"><components><component objectid="1"/>'
        '<component objectid="1" transform="1 0 0 0 1 0 0 0 1 10 0 0"/></components></object></resources>\n'
        '<build><item objectid="2" transform="0 1 0 -1 0 0 0 0 1 0 0 100"/></build></model>'
    )
    return model.encode()


def _zipped(model: bytes) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        archive.writestr("[Content_Types].xml", "<Types/>")
        archive.writestr("3D/3dmodel.model", model)
    return out.getvalue()


def _glb_of(document: bytes) -> bytes:
    """A .glb with this document before the example's buffer."""
    _, rest = _glb_parts()
    document += b" " * (-len(document) % 4)
    return struct.pack("<4sIII4s", b"glTF", 2, 20 + len(document) + len(rest), len(document), b"JSON") + document + rest


def _glb_parts() -> tuple[bytes, bytes]:
    data = _gltf(is_binary=True)
    length = struct.unpack_from("<I", data, 12)[0]
    return data[20 : 20 + length], data[20 + length :]


def _step() -> bytes:
    step = Step()
    solid = step.box((2.0, 4.0, 6.0), name="box")
    step.colored(solid, (1.0, 0.0, 0.0), alpha=0.5)
    bolt, plant = step.product("Bolt", solid), step.product("Plant")
    for number in range(2):
        step.occurrence(plant, bolt, f"Bolt {number}", str(number), at=(10.0 * number, 0.0, 0.0))
    return step.text().encode()


def seeds() -> dict[str, Seed]:
    """Suffix to seed."""
    return {
        ".glb": Seed(_gltf(is_binary=True), _glb_parts()[0], _glb_of),
        ".gltf": Seed(_gltf(is_binary=False)),
        ".stl": Seed(_stl()),
        ".obj": Seed(_obj()),
        ".ply": Seed(_ply()),
        ".off": Seed(_off()),
        ".3mf": Seed(_zipped(_3mf()), _3mf(), _zipped),
        ".step": Seed(_step()),
    }
