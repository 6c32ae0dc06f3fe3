"""The zip as a user gets it: installed into an empty Blender that has nothing but what Blender brings, used, and gone without a trace."""

import importlib.metadata
import json
import os
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from tests.conftest import ROOT
from tools.build_package import ONLY_FOR_BENCHMARKS

TOUR = Path(__file__).with_name("package_tour.py")

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="builds and installs the package for Linux")


def blender_distributions() -> set[str]:
    """The distributions that bpy brings along, itself included: what Blender's own Python has."""
    wanted, found = ["bpy"], set()
    while wanted:
        name = wanted.pop()
        if name not in found:
            found.add(name)
            requires = [Requirement(line) for line in importlib.metadata.requires(name) or []]
            wanted += [need.name for need in requires if need.marker is None or need.marker.evaluate({"extra": ""})]
    return found


@pytest.fixture(scope="session")
def package(tmp_path_factory) -> Path:
    """The zip for Linux, built once."""
    if not (ROOT / ".venv" / "boot").is_dir():
        pytest.skip("needs pip in .venv/boot to fetch the wheels: run this as ./dev test")
    folder = tmp_path_factory.mktemp("package")
    command = [sys.executable, "-m", "tools.build_package", "--platform", "linux-x64", "--output", str(folder)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=280)
    assert done.returncode == 0, done.stderr
    return next(folder.glob("*.zip"))


@pytest.fixture(scope="session")
def bare_site(tmp_path_factory) -> Path:
    """A folder with links to what Blender brings and nothing else of this environment."""
    folder = tmp_path_factory.mktemp("site")
    for name in blender_distributions():
        distribution = importlib.metadata.distribution(name)
        for top in {file.parts[0] for file in distribution.files if file.parts[0] not in {"..", "__pycache__"}}:
            (folder / top).symlink_to(distribution.locate_file(top))
    return folder


@pytest.fixture(scope="session")
def tour(package, bare_site, tmp_path_factory) -> dict:
    """What package_tour.py tells; -S hides this environment's site-packages from it."""
    folder = tmp_path_factory.mktemp("user")
    inherited = {name: os.environ[name] for name in ("PATH", "HOME", "TMPDIR") if name in os.environ}
    environment = inherited | {"BLENDER_USER_RESOURCES": str(folder), "PYTHONPATH": str(bare_site)}
    command = [sys.executable, "-S", str(TOUR), str(package), str(folder)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=200)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Traceback" not in done.stderr, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def test_the_installed_package_renders_a_cube(tour):
    assert tour["picture"]["pixels"] == 96 * 64
    assert tour["picture"]["high"] - tour["picture"]["low"] > 0.1


def test_the_bundled_wheels_are_the_ones_used(tour):
    assert {name: file for name, file in tour["files"].items() if not file.startswith(tour["site"])} == {}


def test_the_package_adds_what_it_promises(tour):
    added = tour["added"]
    assert "CadShadowEngine" in added["classes"]
    assert "Scene.cad_shadow" in added["properties"]
    assert any(name.startswith("cad_shadow.") for name in added["operators"])
    assert added["commands"] == ["cad_shadow"]
    assert added["menu entries"]


def test_disabling_leaves_nothing_behind(tour):
    assert tour["left"] == {}


def test_the_package_holds_the_sources_and_no_build_products(package):
    with zipfile.ZipFile(package) as archive:
        packed = {name for name in archive.namelist() if name.startswith("addon/")}
        manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
    sources = {path.relative_to(ROOT).as_posix() for path in (ROOT / "addon").rglob("*") if path.is_file() and path.suffix != ".pyc"}
    assert packed == sources - set(ONLY_FOR_BENCHMARKS)
    assert manifest["platforms"] == ["linux-x64"]
    assert not [wheel for wheel in manifest["build"]["generated"]["wheels"] if "numpy" in wheel]


def test_every_wheel_is_there_for_both_supported_pythons(package):
    with zipfile.ZipFile(package) as archive:
        wheels = [Path(name).name for name in archive.namelist() if name.endswith(".whl")]
    distributions = {name.split("-")[0] for name in wheels}
    assert distributions == {"moderngl", "glcontext", "trimesh", "fast_simplification", "cascadio", "dracopy", "tqdm"}
    for distribution in distributions - {"trimesh", "tqdm"}:
        tags = {name.split("-")[2] for name in wheels if name.startswith(distribution)}
        assert "cp311" in tags
        assert tags & {"cp312", "cp313"}  # cp312-abi3 serves 3.13


def test_the_version_has_an_entry_in_the_changelog():
    version = tomllib.loads((ROOT / "blender_manifest.toml").read_text())["version"]
    assert f"## {version}\n" in (ROOT / "CHANGELOG.md").read_text()
