"""The table of file formats: each module of a reader is in it, each suffix has one reader, and bytes are known for what they are."""

import struct

import pytest

from addon.errors import CadFileError
from addon.scene import cad
from addon.scene.cad.formats import BY_SUFFIX, FORMATS, SUFFIXES, said
from addon.scene.cad.sniff import sniff
from addon.scene.cad.units import METRES_PER_UNIT, UPS
from tests.conftest import ROOT

FACET = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
STARTS = {
    b"glTF\x02\0\0\0": ".glb",
    b'{"asset": {"version": "2.0"}}': ".gltf",
    b'\xef\xbb\xbf\n {\n "v 1": 2}': ".gltf",
    b"PK\x03\x04\x14\0": ".3mf",
    b"ISO-10303-21;\nHEADER;\n": ".step",
    b"\r\nISO-10303-21;\no and v at\nv the beginning of a line\n": ".step",
    b"made by hand".ljust(72) + b"S      1\n1H,,1H;": ".iges",
    b"ply\r\nformat ascii 1.0\n": ".ply",
    b"OFF\n3 1 0\n": ".off",
    b"# o of mine\n\n # v 2\nCOFF\n3 1 0\n": ".off",
    f"solid o\n{FACET}".encode(): ".stl",
    b"SOLID\nendsolid\n": ".stl",
    b"solid ".ljust(80) + struct.pack("<I", 1) + bytes(50): ".stl",
    b"OFF\nv 1 2 3".ljust(80) + struct.pack("<I", 2) + bytes(100): ".stl",
    b"v 0 0 0\nv 1 0 0\n": ".obj",
    b"# nothing yet\n# but comments": ".obj",
    b"\xef\xbb\xbf# made by hand\nmtllib a.mtl\n": ".obj",
}


def test_each_suffix_has_one_format():
    assert len(SUFFIXES) == sum(len(row.suffixes) for row in FORMATS.values())
    assert all(s == s.lower() and s.startswith(".") for s in SUFFIXES)
    assert {row.unit for row in FORMATS.values()} <= set(METRES_PER_UNIT) and {row.up for row in FORMATS.values()} <= set(UPS)


def test_every_module_with_a_reader_is_in_the_table():
    sources = {path.stem: path.read_text(encoding="utf-8") for path in (ROOT / "addon" / "scene" / "cad").glob("*.py")}
    assert {name for name, text in sources.items() if "\ndef read_" in text and "-> RawFile" in text} == {
        row.read.__module__.rpartition(".")[2] for row in FORMATS.values()
    }
    assert sum("\nROW = " in text for text in sources.values()) == len(FORMATS)


@pytest.mark.parametrize(("head", "suffix"), STARTS.items())
def test_bytes_are_known_for_what_they_are(head, suffix):
    assert sniff(head, len(head), BY_SUFFIX)[0] == suffix


@pytest.mark.parametrize("head", [b"\0\1\2", b"hello", b"v\0 1 2", b"solid and no more", b"ply of wood\n", b"[]", bytes(84)[:-1]])
def test_what_is_of_no_format_is_of_none(head):
    assert sniff(head, len(head), BY_SUFFIX) == ()


def test_a_wrong_name_is_told_the_right_one_and_either_spelling_is_right(tmp_path):
    for name in ("part.obj", "part.stp", "part.STEP"):
        (tmp_path / name).write_bytes(b"ISO-10303-21;\nHEADER;\n")
    with pytest.raises(CadFileError, match="is a STEP file under a wrong name: rename it to part.step"):
        cad.read(tmp_path / "part.obj")
    for name in ("part.stp", "part.STEP"):
        with pytest.raises(CadFileError, match="cannot be read as STEP"):
            cad.read(tmp_path / name)


def test_formats_are_listed_as_a_sentence_would():
    assert said(["STEP"], " and ") == "STEP" and said(["STEP", "STL"], " and ") == "STEP and STL"
    assert said(["STEP", "STL", "OBJ"], " and ") == "STEP, STL and OBJ"
