"""PLY as people's tools write it: text and binary, mixed polygons, edges, strips, colours; and damaged in every way, in a line each."""

import struct
import time

import numpy as np
import pytest

from addon.errors import CadFileError
from addon.scene import cad
from addon.scene.cad.ply_elements import TYPES, ply_elements

SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
FORMATS = ("ascii", "binary_little_endian", "binary_big_endian")
CODES = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "f4": "f", "f8": "d"}


def ply(form, elements):
    """A file of (name, properties, rows); a property is 'float x' or 'list uchar int vertex_indices', a row one value or list for each."""
    head, body, order = f"ply\nformat {form} 1.0\ncomment made here\n", [], ">" if "big" in form else "<"
    for name, properties, rows in elements:
        head += f"element {name} {len(rows)}\n" + "".join(f"property {p}\n" for p in properties)
        for row in rows:
            words = []
            for p, value in zip(properties, row, strict=True):
                kinds = p.split()
                items = [(kinds[1], len(value)), *((kinds[2], v) for v in value)] if kinds[0] == "list" else [(kinds[0], value)]
                words += [str(v) if form == "ascii" else struct.pack(order + CODES[TYPES[kind]], v) for kind, v in items]
            body.append((" ".join(words) + "\n").encode() if form == "ascii" else b"".join(words))
    return (head + "end_header\n").encode() + b"".join(body)


def vertices(points, more=(), rows=None):
    extra = [()] * len(points) if rows is None else rows
    return "vertex", ["float x", "double y", "float z", *more], [(*p, *r) for p, r in zip(points, extra, strict=True)]


def faces(*polygons, more=(), rows=None, name="vertex_indices"):
    extra = [()] * len(polygons) if rows is None else rows
    return "face", [f"list uchar int {name}", *more], [(list(p), *r) for p, r in zip(polygons, extra, strict=True)]


def area(model):
    (mesh,) = model.meshes
    a, b, c = (mesh.positions[mesh.triangles[:, k]].astype(float) for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


def read(path, data):
    path.write_bytes(data)
    return cad.read(path)


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize(
    "polygons", [[(0, 1, 2), (0, 2, 3)], [(0, 1, 2, 3)], [(0, 1, 2), (0, 1, 2, 3)][1:], [(0, 1, 2), (2, 3, 0), (0, 1)]]
)
def test_polygons_of_every_form(tmp_path, form, polygons):
    assert area(read(tmp_path / "a.ply", ply(form, [vertices(SQUARE), faces(*polygons)]))) == pytest.approx(1.0)


@pytest.mark.parametrize("form", FORMATS)
def test_mixed_polygons_edges_and_foreign_elements_do_not_disturb_each_other(tmp_path, form):
    points = [*SQUARE, (2, 0, 0), (2, 1, 0), (3, 0.5, 0)]
    elements = [
        ("camera", ["float fov", "list ushort double path"], [(45.0, [1.0, 2.0, 3.0])]),
        vertices(points, ["short id"], [(i,) for i in range(7)]),
        ("edge", ["int vertex1", "int vertex2"], [(0, 1), (1, 2)]),
        faces(
            (0, 1, 2, 3),
            (1, 4, 5),
            (1, 5, 2),
            (1, 4, 6, 5, 2),
            more=["uchar flags", "list uchar float uv"],
            rows=[(1, [0.5] * n) for n in (8, 0, 3, 1)],
        ),
        ("note", ["int code"], [(7,), (8,)]),
    ]
    model = read(tmp_path / "a.ply", ply(form, elements))
    assert area(model) == pytest.approx(1.0 + 0.5 + 0.5 + 1.5)
    (line,) = [w for w in model.warnings if "not drawn" in w]
    assert "camera (1), note (2)" in line


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("strips", [[[0, 1, 3, 2]], [[0, 1, 3, -1, 1, 2, 3]], [[0, 1, 3], [1, 2, 3]], [[], [0, 1], [0, 1, 3, 2, -1], [-1]]])
def test_strips_of_triangles_are_all_turned_the_same_way(tmp_path, form, strips):
    model = read(tmp_path / "a.ply", ply(form, [vertices(SQUARE), ("tristrips", ["list int int vertex_indices"], [(s,) for s in strips])]))
    assert area(model) == pytest.approx(1.0)
    (mesh,) = model.meshes
    a, b, c = (mesh.positions[mesh.triangles[:, k]] for k in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0).all()


@pytest.mark.parametrize("form", FORMATS)
def test_colours_of_faces_and_vertices(tmp_path, form):
    red, blue = (255, 0, 0), (0, 0, 255)
    kinds = ["uchar red", "uchar green", "uchar blue"]
    two = faces((0, 1, 2), (0, 2, 3), more=kinds, rows=[red, blue])
    model = read(tmp_path / "a.ply", ply(form, [vertices(SQUARE), two]))
    assert sorted(m.base_color for m in model.materials) == [(0, 0, 1, 1), (1, 0, 0, 1)]
    own = vertices(SQUARE, ["ushort red", "ushort green", "ushort blue", "ushort alpha"], [(65535, 0, 0, 65535)] * 4)
    model = read(tmp_path / "b.ply", ply(form, [own, faces((0, 1, 2, 3))]))
    assert np.allclose([m.base_color for m in model.materials], [(1, 0, 0, 1)])


@pytest.mark.parametrize("form", FORMATS)
def test_normals_are_kept(tmp_path, form):
    own = vertices(SQUARE, ["float nx", "float ny", "float nz"], [(0.6, 0.0, 0.8)] * 4)
    (mesh,) = read(tmp_path / "a.ply", ply(form, [own, faces((0, 1, 2, 3), name="vertex_index")])).meshes
    assert np.allclose(mesh.normals, [(0.6, 0.0, 0.8)] * 4)


@pytest.mark.parametrize("form", FORMATS)
def test_what_is_read_is_what_was_written(form, rng):
    """Every type, lists of random lengths, of any number of lists in an element."""
    kinds = list(dict.fromkeys(TYPES))
    rows = []
    for _ in range(50):
        lists = [[int(v) for v in rng.integers(0, 100, rng.integers(0, 6))] for _ in range(2)]
        rows.append((*(int(rng.integers(0, 100)) for _ in kinds), lists[0], 3, lists[1]))
    names = [f"{kind} {kind}_value" for kind in kinds]
    data = ply(form, [("thing", [*names, "list uchar short a", "int between", "list uint double b"], rows), ("end", ["int x"], [(7,)])])
    columns = ply_elements(data)["thing"]
    for i, kind in enumerate(kinds):
        assert columns[f"{kind}_value"].tolist() == [row[i] for row in rows], kind
    for name, place in (("a", -3), ("b", -1)):
        assert columns[name].sizes.tolist() == [len(row[place]) for row in rows]
        assert columns[name].values.tolist() == [v for row in rows for v in row[place]]
    assert columns["between"].tolist() == [3] * 50
    assert ply_elements(data)["end"]["x"].tolist() == [7]


@pytest.mark.parametrize("line_end", ["\n", "\r\n", "\r"])
def test_headers_of_every_line_end(tmp_path, line_end):
    head, body = ply("binary_little_endian", [vertices(SQUARE), faces((0, 1, 2, 3))]).split(b"end_header\n", 1)
    data = head.replace(b"\n", line_end.encode()) + b"end_header" + line_end.encode() + body
    if line_end != "\r":  # files of lone carriage returns are not taken for PLY
        assert area(read(tmp_path / "a.ply", data)) == pytest.approx(1.0)
    assert ply_elements(data)["face"]["vertex_indices"].values.tolist() == [0, 1, 2, 3]


@pytest.mark.parametrize("form", FORMATS)
def test_indices_that_name_no_vertex_cost_their_face(tmp_path, form):
    model = read(tmp_path / "a.ply", ply(form, [vertices(SQUARE), faces((0, 1, 2), (0, 2, 9), (0, -1, 3), (0, 3, 1000, 2))]))
    assert area(model) == pytest.approx(0.5)
    assert any("faces" in w for w in model.warnings)


@pytest.mark.parametrize("form", FORMATS)
def test_files_cut_anywhere_and_counts_of_any_size_are_refused_quickly(tmp_path, form):
    whole = ply(form, [vertices(SQUARE), faces((0, 1, 2), (0, 1, 2, 3))])
    path, start = tmp_path / "a.ply", whole.index(b"end_header")
    begin = time.perf_counter()
    for cut in range(20, len(whole) - 1):
        path.write_bytes(whole[:cut])
        try:
            cad.read(path)
        except CadFileError as error:
            assert str(error).isprintable()
        else:
            assert form == "ascii" and cut > start, "text may end within its last number"
    for old, new in (
        (b"vertex 4", b"vertex 9223372036854775807"),
        (b"face 2", b"face 4294967296"),
        (b"face 2", b"face -1"),
        (b"vertex 4", b"vertex x"),
    ):
        path.write_bytes(whole.replace(old, new))
        with pytest.raises(CadFileError):
            cad.read(path)
    assert time.perf_counter() - begin < 20.0


@pytest.mark.parametrize("count", [-3, 2**31 - 1])
def test_lists_of_impossible_lengths_are_refused(tmp_path, count):
    head = ply("binary_little_endian", [vertices(SQUARE), faces((0, 1, 2, 3))]).replace(b"list uchar int", b"list int int")
    data = head[: -4 * 4 - 1] + struct.pack("<5i", count, 0, 1, 2, 3)
    with pytest.raises(CadFileError, match="list of"):
        read(tmp_path / "a.ply", data)
    text = ply("ascii", [vertices(SQUARE), faces((0, 1, 2, 3))]).replace(b"\n4 0 1", f"\n{count} 0 1".encode())
    with pytest.raises(CadFileError, match="list of"):
        read(tmp_path / "b.ply", text)


def test_a_million_mixed_faces_take_seconds(tmp_path):
    count = 250_000
    row3, row4 = struct.pack("<B3i", 3, 0, 1, 2), struct.pack("<B4i", 4, 0, 1, 2, 3)
    head, body = ply("binary_little_endian", [vertices(SQUARE), faces((0, 1, 2))]).split(b"end_header\n")
    data = head.replace(b"face 1", f"face {2 * count}".encode()) + b"end_header\n" + body[:64] + (row3 + row4) * count
    begin = time.perf_counter()
    columns = ply_elements(data)["face"]["vertex_indices"]
    assert len(columns.values) == 7 * count
    assert time.perf_counter() - begin < 10.0
