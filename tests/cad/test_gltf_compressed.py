"""Compressed glTF: meshopt's streams against meshoptimizer itself, Draco's against Google's library; what cannot be read is said."""

import math
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from addon.errors import CadFileError
from addon.scene import cad
from addon.scene.cad import meshopt
from addon.scene.cad.meshopt_filters import filtered
from tests.cad.gltf_writer import Gltf, box
from tests.cad.measured import area, colors, names
from tests.cad.meshopt_writer import Encoder, library

LIBRARY = library()
needs_meshoptimizer = pytest.mark.skipif(LIBRARY is None, reason="this Blender carries no meshoptimizer")


def grid(side, order):
    """Triangles over side × side corners, shuffled by the seed `order` (None: rows)."""
    cell = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    rows = np.concatenate([cell[:, None] + [0, 1, side], cell[:, None] + [1, side + 1, side]])
    return rows if order is None else np.random.default_rng(order).permutation(rows)


@needs_meshoptimizer
@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.integers(1, 700),
    stride=st.sampled_from([4, 8, 12, 16, 20, 64, 256]),
    step=st.sampled_from([0, 1, 3, 200, 2**16]),
    version=st.sampled_from([0, 1]),
)
def test_elements_of_any_kind_are_decoded_as_they_were(seed, count, stride, step, version):
    random = np.random.default_rng(seed)
    words = np.cumsum(random.integers(-step, step + 1, (count, stride // 4)), axis=0).astype(np.int32)
    elements = np.ascontiguousarray(words).view(np.uint8).reshape(count, stride)
    data = Encoder(LIBRARY, version).attributes(elements)
    assert data[0] == 0xA0 + version
    assert (meshopt.attributes(data, count, stride) == elements).all()


@needs_meshoptimizer
@pytest.mark.parametrize(("version", "level"), [(0, 0), (1, 0), (1, 1), (1, 2), (1, 3)])
def test_elements_of_floats_are_decoded_as_they_were(version, level):
    random = np.random.default_rng(3)
    points = random.normal(size=(1000, 3)).cumsum(axis=0).astype(np.float32)
    points[:, 1:] = np.exp2(random.integers(-3, 3, (1000, 2)))  # what changes is the exponent
    data = Encoder(LIBRARY, version, level).attributes(points.view(np.uint8).reshape(1000, 12))
    assert (meshopt.attributes(data, 1000, 12).view(np.float32) == points).all()


@needs_meshoptimizer
@given(side=st.integers(2, 20), order=st.none() | st.integers(0, 1000), scattered=st.booleans())
def test_triangles_are_decoded_as_they_were_but_for_their_first_corner(side, order, scattered):
    index = grid(side, order)
    index = np.random.default_rng(side).permutation(10 * side * side)[index] if scattered else index
    data = Encoder(LIBRARY, 1).triangles(index.ravel())
    decoded = meshopt.triangles(data, index.size).reshape(-1, 3).astype(np.int64)
    turned = [np.roll(index, -k, axis=1) for k in range(3)]
    assert np.any([(decoded == one).all(axis=1) for one in turned], axis=0).all()


@needs_meshoptimizer
@given(index=st.lists(st.integers(0, 2**20), min_size=1, max_size=300))
def test_indices_in_any_order_are_decoded_as_they_were(index):
    data = Encoder(LIBRARY, 1).indices(index)
    assert meshopt.indices(data, len(index)).tolist() == index


@needs_meshoptimizer
@pytest.mark.parametrize(("stride", "bits"), [(4, 8), (4, 6), (8, 12), (8, 16)])
def test_filters_give_vectors_quaternions_floats_and_colours(stride, bits):
    random, encoder = np.random.default_rng(bits), Encoder(LIBRARY, 1)
    vectors = random.normal(size=(200, 4))
    vectors[:, :3] /= np.linalg.norm(vectors[:, :3], axis=1, keepdims=True)
    vectors[:, 3] = 0.0
    number = "i1" if stride == 4 else "<i2"
    got = filtered(encoder.filtered("Oct", vectors, stride, bits), "OCTAHEDRAL").view(number) / np.iinfo(number).max
    assert np.abs(got - vectors).max() < 5.0 / 2**bits + 1.0 / np.iinfo(number).max
    if stride == 8:
        turns = random.normal(size=(200, 4))
        turns /= np.linalg.norm(turns, axis=1, keepdims=True)
        got = filtered(encoder.filtered("Quat", turns, 8, bits), "QUATERNION").view("<i2") / 32767.0
        assert np.abs(np.abs((got * turns).sum(axis=1)) - 1.0).max() < 4.0 / 2**bits
    floats = random.normal(size=(200, stride // 4)) * 100.0
    got = filtered(encoder.filtered("Exp", floats, stride, 20), "EXPONENTIAL").view("<f4")
    assert np.abs(got - floats).max() < 1e-3
    shades = random.random((200, 4))
    number = "u1" if stride == 4 else "<u2"
    got = filtered(encoder.filtered("Color", shades, stride, bits), "COLOR").view(number) / np.iinfo(number).max
    assert np.abs(got - shades).max() < 6.0 / 2**bits


def test_the_example_of_the_specification_gives_its_deltas():
    deltas = bytes.fromhex("175ff0bc77a9210034b5")
    wanted = [-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0]
    still = b"\x00" * 3
    data = b"\xa0" + b"\x02" + deltas + still + bytes(32)
    elements = meshopt.attributes(data, 16, 4)
    assert np.diff(elements[:, 0].astype(np.int8), prepend=np.int8(0)).tolist() == wanted
    assert not elements[:, 1:].any()


@pytest.mark.parametrize("count", [3, 6, 9])
def test_streams_that_end_early_or_announce_too_much_are_one_line(count):
    for decode in (meshopt.triangles, meshopt.indices):
        for data in (b"", b"\xe1", b"\xe1\xff" + bytes(16), b"\xe1" + b"\xff" * count + b"\x80" * 16, b"\xd1" + b"\xff" * 20):
            with pytest.raises(ValueError, match="meshopt|indices"):
                decode(data, count)
    for data in (b"\xa0" + bytes(32), b"\xa1" + bytes(3), b"\xa2" + bytes(99), b"\xa0" + b"\xff" * 60):
        with pytest.raises(ValueError, match="meshopt|elements"):
            meshopt.attributes(data, 100 * count, 12)
    with pytest.raises(ValueError, match="elements"):
        meshopt.attributes(b"\xa1" + bytes(100), 10**9, 4)


def compressed(gltf, encoder, extension):
    """The document with every buffer view as a stream of meshopt."""
    streams, document = b"", gltf.document
    for accessor in document["accessors"]:
        view = document["bufferViews"][accessor["bufferView"]]
        data = gltf.blob[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
        width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        stride = view.get("byteStride", width * {5121: 1, 5123: 2, 5125: 4, 5126: 4}[accessor["componentType"]])
        if accessor["type"] == "SCALAR":
            stream, mode = encoder.triangles(np.frombuffer(data, f"<u{stride}")), "TRIANGLES"
        else:
            stream, mode = encoder.attributes(np.frombuffer(data, np.uint8).reshape(-1, stride)), "ATTRIBUTES"
        own = {"buffer": 0, "byteOffset": len(streams), "byteLength": len(stream), "byteStride": stride, "count": len(data) // stride}
        view["extensions"], view["buffer"] = {extension: {**own, "mode": mode}}, 1
        streams += stream
    document["buffers"] = [{"byteLength": len(streams)}, {"byteLength": len(gltf.blob), "extensions": {extension: {"fallback": True}}}]
    document["extensionsUsed"] = document["extensionsRequired"] = [extension]
    gltf.blob = streams
    return gltf


@needs_meshoptimizer
@pytest.mark.parametrize(("extension", "version"), [("EXT_meshopt_compression", 0), ("KHR_meshopt_compression", 1)])
def test_a_file_compressed_with_meshopt_is_read_like_the_same_file_without(tmp_path, extension, version):
    def model():
        gltf = Gltf()
        shades = np.linspace(0, 255, 32).astype(np.uint8).reshape(8, 4)
        gltf.node(mesh=gltf.mesh(*box((1, 2, 3)), name="Box", attributes={"COLOR_0": gltf.accessor(shades, normalized=True)}), name="Tank")
        gltf.node(mesh=gltf.mesh(*box()), name="Lid", translation=[5, 0, 0])
        return gltf

    (tmp_path / "plain.glb").write_bytes(model().glb())
    (tmp_path / "packed.glb").write_bytes(compressed(model(), Encoder(LIBRARY, version), extension).glb())
    plain, packed = cad.read(tmp_path / "plain.glb"), cad.read(tmp_path / "packed.glb")
    assert names(packed) == names(plain) == ["Tank", "Lid"]
    assert (packed.bounds() == plain.bounds()).all()
    assert math.isclose(area(packed), 28.0, rel_tol=1e-6)
    assert np.sort(colors(packed, 0).reshape(-1, 4), axis=0).tolist() == np.sort(colors(plain, 0).reshape(-1, 4), axis=0).tolist()


def draco_box(gltf, size=(1.0, 2.0, 3.0), **entry):
    """A node that shows a box whose numbers stand in a Draco stream alone."""
    draco = pytest.importorskip("DracoPy", reason="the environment is older than its lock: DracoPy is not there")
    points, triangles = box(size)
    shades = np.tile(np.array([255, 0, 0], np.uint8), (8, 1))
    outwards = (points - np.array(size) / 2.0) / np.linalg.norm(np.array(size) / 2.0)
    data = draco.encode(points, triangles.astype(np.uint32), quantization_bits=20, colors=shades, normals=outwards)
    found = {one["attribute_type"]: one for one in draco.decode(data).attributes}
    count = len(found[0]["data"])
    shared = {"count": count, "type": "VEC3"}
    attributes = {
        "POSITION": gltf.add("accessors", componentType=5126, **shared),
        "NORMAL": gltf.add("accessors", componentType=5126, **shared),
        "COLOR_0": gltf.add("accessors", componentType=5121, normalized=True, **shared),
    }
    numbers = {"POSITION": found[0]["unique_id"], "NORMAL": found[1]["unique_id"], "COLOR_0": found[2]["unique_id"]}
    extension = {"KHR_draco_mesh_compression": {"bufferView": gltf.view(data), "attributes": numbers}}
    index = gltf.add("accessors", componentType=5125, count=36, type="SCALAR")
    mesh = gltf.add("meshes", primitives=[{"attributes": attributes, "indices": index, "extensions": extension}])
    gltf.node(mesh=mesh, **entry)


def test_a_file_compressed_with_draco_is_read(tmp_path):
    gltf = Gltf(extensionsUsed=["KHR_draco_mesh_compression"], extensionsRequired=["KHR_draco_mesh_compression"])
    draco_box(gltf, name="Tank")
    draco_box(gltf, (1, 1, 1), name="Lid", translation=[5, 0, 0])
    (tmp_path / "a.glb").write_bytes(gltf.glb())
    model = cad.read(tmp_path / "a.glb")
    assert names(model) == ["Tank", "Lid"]
    assert (model.triangle_count, model.warnings) == (24, ())
    assert math.isclose(area(model), 28.0, rel_tol=1e-4)
    assert np.allclose(colors(model, 0), [1, 0, 0, 1], atol=1e-6)
    assert model.meshes[0].normals is not None


@pytest.mark.parametrize("data", [b"", b"DRACO", b"no such stream at all", b"DRACO\x02\x02\x01\x01\x00\x00" + b"\xff" * 40])
def test_damaged_draco_is_one_line(tmp_path, data):
    pytest.importorskip("DracoPy", reason="the environment is older than its lock: DracoPy is not there")
    gltf = Gltf()
    draco_box(gltf)
    gltf.document["bufferViews"][0] |= {"byteOffset": len(gltf.blob), "byteLength": len(data)}
    gltf.blob += data
    (tmp_path / "a.glb").write_bytes(gltf.glb())
    with pytest.raises(CadFileError, match="Draco") as caught:
        cad.read(tmp_path / "a.glb")
    assert str(caught.value).isprintable()


def test_without_its_library_a_draco_file_says_so(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "DracoPy", None)
    gltf = Gltf()
    gltf.node(mesh=gltf.mesh(*box(), extensions={"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}}))
    for accessor in gltf.document["accessors"]:
        del accessor["bufferView"]
    (tmp_path / "a.glb").write_bytes(gltf.glb())
    with pytest.raises(CadFileError, match=r"a.glb is compressed with Draco .* is not installed: .* without compression"):
        cad.read(tmp_path / "a.glb")


def test_a_file_that_also_holds_its_numbers_needs_no_draco(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "DracoPy", None)
    gltf = Gltf()
    gltf.node(mesh=gltf.mesh(*box(), extensions={"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}}))
    (tmp_path / "a.glb").write_bytes(gltf.glb())
    assert cad.read(tmp_path / "a.glb").triangle_count == 12
