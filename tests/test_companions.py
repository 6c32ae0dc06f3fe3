"""The files that a model names, and what a small model may cost: read beside it only, regular, bounded; parts are counted."""

import json
import os
import resource
import sys
import threading
import zipfile
from dataclasses import replace

import numpy as np
import pytest

from addon.errors import CadFileError, OutputError
from addon.scene import cad, user_files
from addon.scene.cad import companions, threemf
from addon.studies import outputs

FACE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl blue\nf 1 2 3\n"
BLUE = "newmtl blue\nKd 0 0 1\n"
posix = pytest.mark.skipif(sys.platform == "win32", reason="named pipes and devices as POSIX has them")


def within(seconds, call):
    """The result or error of `call`, which must be there in time."""
    found = []

    def run():
        try:
            found.append(call())
        except Exception as error:
            found.append(error)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    thread.join(seconds)
    assert found, f"not done in {seconds} s"
    return found[0]


@pytest.fixture
def obj(tmp_path):
    """Read an OBJ in box/ that names this library; box/ beside elsewhere/."""
    (tmp_path / "box").mkdir()
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "blue.mtl").write_text(BLUE)

    def read(name):
        path = tmp_path / "box" / "x.obj"
        path.write_bytes(b"mtllib " + (name if isinstance(name, bytes) else name.encode()) + b"\n" + FACE.encode())
        return within(20.0, lambda: cad.read(path))

    return read


def is_blue(model):
    return [m.base_color for m in model.materials] == [(0.0, 0.0, 1.0, 1.0)]


WRITTEN = (
    "blue.mtl", '"blue.mtl"', "sub/blue.mtl", "sub\\blue.mtl", "./blue.mtl",
    "C:\\Users\\me\\blue.mtl", "/home/me/blue.mtl", "BLUE.MTL", "../blue.mtl",
)  # fmt: skip


@pytest.mark.parametrize("name", WRITTEN)
def test_a_material_file_is_found_beside_the_model_whatever_path_its_writer_had(obj, tmp_path, name):
    place = tmp_path / "box" / ("sub/blue.mtl" if "sub" in name else "blue.mtl")
    place.parent.mkdir(exist_ok=True)
    place.write_text(BLUE)
    model = obj(name)
    assert is_blue(model)
    assert not any("material" in line for line in model.warnings)


@pytest.mark.parametrize("name", ["../elsewhere/blue.mtl", "ABSOLUTE", "sub/../../elsewhere/blue.mtl", "..\\elsewhere\\blue.mtl"])
def test_a_material_file_elsewhere_is_not_opened(obj, tmp_path, monkeypatch, name):
    read = []
    monkeypatch.setattr("addon.scene.cad.obj.read_mtl", lambda path, losses: read.append(path) or {})
    model = obj(str(tmp_path / "elsewhere" / "blue.mtl") if name == "ABSOLUTE" else name)
    assert not read
    assert any("blue.mtl" in line and "Put it beside x.obj" in line for line in model.warnings)


@posix
def test_devices_and_pipes_in_a_models_name_are_not_opened(obj, tmp_path):
    os.mkfifo(tmp_path / "box" / "pipe.mtl")
    os.symlink("/dev/zero", tmp_path / "box" / "zero.mtl")
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for name, words in (("pipe.mtl", "a named pipe"), ("zero.mtl", "a device"), ("/dev/zero", "is missing"), (".", "is missing")):
        (line,) = [line for line in obj(name).warnings if "material" in line]
        assert words in line
        assert "parts are grey" in line
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss < before + (64 << 10)


def test_a_material_file_of_any_size_costs_no_more_than_is_allowed(obj, tmp_path, monkeypatch):
    monkeypatch.setattr("addon.scene.cad.mtl.MOST_MATERIALS", 1000)
    (tmp_path / "box" / "blue.mtl").write_text(BLUE + "#" * 1000)
    assert any("larger than" in line for line in obj("blue.mtl").warnings)


@pytest.mark.parametrize("name", [b"m" * 10000, b"\xff\xfe.mtl", b"\x1b[31mred.mtl", b"a\rb.mtl"])
def test_a_name_of_any_bytes_is_a_warning_of_one_plain_line(obj, name):
    (line,) = [line for line in obj(name).warnings if "material" in line]
    assert line.isprintable()
    assert len(line) < 300


def test_textures_and_material_files_of_a_model_are_inputs_that_no_result_replaces(obj, tmp_path):
    box = tmp_path / "box"
    (box / "blue.mtl").write_text(BLUE + "map_Kd -s 1 1 x_color.png\nmap_Bump x normal.png\n")
    for name in ("x_color.png", "x normal.png", "free.png"):
        (box / name).write_bytes(b"the user's")
    with user_files.run_of_inputs():
        obj("blue.mtl")
        for name in ("x.obj", "blue.mtl", "x_color.png", "x normal.png"):
            with pytest.raises(OutputError, match="is an input of this run"):
                outputs.write_bytes(box / name, b"lost")
        outputs.write_bytes(box / "free.png", b"result")


# ---- glTF


def gltf(path, uri, images=()):
    data = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4").tobytes()
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": len(data)}],
        "buffers": [{"byteLength": len(data), "uri": uri}],
        "images": [{"uri": name} for name in images],
    }
    path.write_text(json.dumps(document))
    return data


FOUND = (("a.bin", "a.bin"), ("my%20box.bin", "my box.bin"), ("sub/a.bin", "sub/a.bin"), ("../a.bin", "a.bin"))


@pytest.mark.parametrize(("uri", "file"), FOUND)
def test_a_buffer_beside_a_gltf_is_read(tmp_path, uri, file):
    data = gltf(tmp_path / "x.gltf", uri)
    (tmp_path / file).parent.mkdir(exist_ok=True)
    (tmp_path / file).write_bytes(data)
    assert cad.read(tmp_path / "x.gltf").triangle_count == 1


@posix
def test_a_buffer_that_is_missing_elsewhere_a_pipe_or_too_large_is_one_line(tmp_path, monkeypatch):
    (tmp_path / "box").mkdir()
    path = tmp_path / "box" / "x.gltf"
    (tmp_path / "a.bin").write_bytes(gltf(path, "a.bin"))
    os.mkfifo(tmp_path / "box" / "pipe.bin")
    (tmp_path / "box" / "large.bin").write_bytes(bytes(2000))
    monkeypatch.setattr(companions, "MOST_BUFFER", 1000)
    cases = {
        "gone.bin": "gone.bin is missing: put it beside x.gltf",
        "../a.bin": "a.bin is missing: put it beside x.gltf",
        "pipe.bin": "it is a named pipe",
        "large.bin": "larger than",
        "file:///etc/passwd": "is missing",
        "/dev/zero": "is missing",
        "\x1b[31m.bin": r"\\x1b\[31m.bin is missing",
    }
    for uri, words in cases.items():
        gltf(path, uri)
        error = within(20.0, lambda: cad.read(path))
        assert isinstance(error, CadFileError), uri
        with pytest.raises(CadFileError, match=words):
            raise error
        assert str(error).isprintable()


def test_images_of_a_gltf_are_inputs_and_are_not_read(tmp_path, monkeypatch):
    data = gltf(tmp_path / "x.gltf", "a.bin", ["x_normal.png", "/dev/zero", "data:image/png;base64,AAAA"])
    (tmp_path / "a.bin").write_bytes(data)
    (tmp_path / "x_normal.png").write_bytes(b"the user's")
    read = []
    monkeypatch.setattr(companions, "read_bytes", lambda path, most: read.append(path.name) or data)
    with user_files.run_of_inputs():
        cad.read(tmp_path / "x.gltf")
        with pytest.raises(OutputError, match="is an input"):
            outputs.write_bytes(tmp_path / "x_normal.png", b"lost")
    assert read == ["a.bin"]


# ---- 3MF

MESH = (
    '<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/><vertex x="0" y="1" z="0"/></vertices>'
    '<triangles><triangle v1="0" v2="1" v3="2"/></triangles></mesh>'
)


def package(path, components, root="100", unit="millimeter"):
    """A 3MF whose objects hold these components by id; object 1 is a triangle."""
    objects = f'<object id="1">{MESH}</object>' + "".join(
        f'<object id="{key}"><components>{"".join(f"<component objectid={chr(34)}{c}{chr(34)}/>" for c in below)}</components></object>'
        for key, below in components.items()
    )
    model = (
        f'<model unit="{unit}" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources>{objects}</resources>'
        f'<build><item objectid="{root}"/></build></model>'
    )
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("3D/3dmodel.model", model)
    return path


def fan(levels, width):
    return {100 + i: [100 + i + 1 if i + 1 < levels else 1] * width for i in range(levels)}


@pytest.mark.parametrize(("levels", "width"), [(6, 10), (14, 3), (60, 2), (2, 5000)])
def test_components_that_multiply_are_refused_in_a_line(tmp_path, levels, width):
    path = package(tmp_path / "bomb.3mf", fan(levels, width))
    error = within(30.0, lambda: cad.read(path))
    assert isinstance(error, CadFileError)
    assert str(error) == f"bomb.3mf places more than {threemf.MAX_PARTS:,} parts: split it."


def test_components_that_multiply_a_little_are_drawn(tmp_path):
    model = cad.read(package(tmp_path / "box.3mf", fan(4, 5)))
    assert model.triangle_count == 5**4


ROUND = ({100: [1, 100]}, {100: [100] * 500 + [1]}, {100: [101, 101, 1], 101: [100, 100]}, {100: [102, 1] * 300})


@pytest.mark.parametrize("components", ROUND)
def test_objects_that_contain_themselves_or_nothing_are_left_out_with_one_line(tmp_path, components):
    model = within(20.0, lambda: cad.read(package(tmp_path / "round.3mf", components)))
    assert model.triangle_count >= 1
    lines = [line for line in model.warnings if "missing or contains itself" in line]
    assert len(lines) == 1


def test_what_a_file_says_stays_in_its_line(tmp_path):
    with pytest.raises(CadFileError) as caught:
        cad.read(package(tmp_path / "unit.3mf", fan(1, 1), unit="x&#10;cad_shadow: all is well&#10;"))
    assert str(caught.value).isprintable()
    model = cad.read(package(tmp_path / "id.3mf", {100: [1, "7&#10;forged line"]}))
    assert all(line.isprintable() for line in model.warnings)


# ---- more than there is


@pytest.mark.parametrize("stage", ["reading", "assembling"])
def test_a_model_beyond_the_memory_is_one_line_and_what_it_held_is_free(tmp_path, monkeypatch, stage):
    (tmp_path / "x.obj").write_text(FACE)
    held, alive = [], []

    class Large:
        def __del__(self):
            held.append("freed")

    def fail(*_arguments):
        large = Large()
        raise MemoryError(large)

    if stage == "reading":
        monkeypatch.setitem(cad.BY_SUFFIX, ".obj", replace(cad.BY_SUFFIX[".obj"], read=fail))
    else:
        monkeypatch.setattr(cad, "assemble", fail)
    with pytest.raises(CadFileError, match=r"x.obj needs more memory than there is: split it") as caught:
        cad.read(tmp_path / "x.obj")
    alive.append(caught.value.__cause__ or caught.value.__context__)
    assert alive == [None]
    assert held == ["freed"]
