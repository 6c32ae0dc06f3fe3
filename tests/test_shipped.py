"""Every format is read with the libraries that users have: those of the extension's wheels and numpy, no others that lie about here."""

import importlib.util
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import ROOT
from tests.test_companions import gltf, package
from tests.test_ply import SQUARE, faces, ply, vertices

READ = """
import sys
from addon.scene import cad as cad_files
for path in sys.argv[1:]:
    print(cad_files.read(path).triangle_count)
left = {"scipy", "networkx", "PIL", "lxml", "shapely"} & set(sys.modules)
assert not left, left
"""
TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def shipped() -> list[str]:
    """The names in requirements/wheels.in, and numpy, which Blender has."""
    lines = (ROOT / "requirements" / "wheels.in").read_text().splitlines()
    return ["numpy", *(re.split("[=<>]", line)[0].replace("-", "_") for line in lines if line and not line.startswith("#"))]


@pytest.fixture(scope="module")
def only_shipped(tmp_path_factory):
    """Run Python with these libraries alone; gives what it prints."""
    room = tmp_path_factory.mktemp("libraries")
    for name in shipped():
        spec = importlib.util.find_spec(name)
        if spec is None:
            pytest.skip(f"the environment is older than its lock: {name} is not there")
        place = Path(spec.origin)
        own = place.parent if place.name == "__init__.py" else place
        for one in (own, own.with_name(f"{name}.libs")):
            if one.exists():
                (room / one.name).symlink_to(one)

    def run(*paths):
        command = [sys.executable, "-S", "-c", READ, *map(str, paths)]
        environment = {"PYTHONPATH": f"{room}:{ROOT}", "PATH": ""}
        done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, done.stderr
        return done.stdout.split()

    return run


@pytest.mark.skipif(sys.platform == "win32", reason="libraries are linked")
def test_every_format_is_read_with_what_the_extension_brings(only_shipped, tmp_path):
    files = {
        "a.obj": TRIANGLE,
        "a.off": "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        "a.stl": "solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid t\n",
    }
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    for form in ("ascii", "binary_little_endian"):
        elements = [vertices(SQUARE), faces((0, 1, 2, 3)), ("edge", ["int vertex1", "int vertex2"], [(0, 1)])]
        (tmp_path / f"{form}.ply").write_bytes(ply(form, elements))
    record = np.zeros(2, [("normal", "<3f4"), ("points", "<9f4"), ("rest", "<u2")])
    record["points"] = [[0, 0, 0, 1, 0, 0, 0, 1, 0], [0, 0, 1, 1, 0, 1, 0, 1, 1]]
    (tmp_path / "binary.stl").write_bytes(bytes(80) + np.uint32(2).tobytes() + record.tobytes())
    (tmp_path / "a.bin").write_bytes(gltf(tmp_path / "a.gltf", "a.bin", ["picture.png"]))
    package(tmp_path / "a.3mf", {100: [1, 1]})
    assert zipfile.is_zipfile(tmp_path / "a.3mf")
    expected = {"a.obj": 1, "a.off": 1, "a.stl": 1, "ascii.ply": 2, "binary_little_endian.ply": 2, "binary.stl": 2, "a.gltf": 1, "a.3mf": 2}
    assert only_shipped(*(tmp_path / name for name in expected)) == [str(count) for count in expected.values()]
