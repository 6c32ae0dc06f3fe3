"""The architecture, held by tests: imports only point down, bpy and OpenGL stay in their rooms, files and functions stay small."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
ADDON = ROOT / "addon"

# From the bottom up. A module may import from its own layer and from those below. What is not named is a face of Blender.
LAYERS = {"errors": 0, "plain_text": 0, "user_files": 0, "maths": 1, "images": 1, "pipeline": 2, "shaders": 2}
LAYERS |= {"snapshot": 3, "cad_files": 3, "cad_model": 3}
FACES = 4
MAX_FILE_LINES = 400
MAX_FUNCTION_LINES = 60

SOURCES = sorted(path for path in ADDON.rglob("*.py") if "__pycache__" not in path.parts)


def module_name(path: Path) -> str:
    """addon/maths/view.py → addon.maths.view; a package's __init__.py → the package."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imported_modules(path: Path) -> list[tuple[str, int]]:
    """Absolute names of all that a file imports anywhere in it, with the line."""
    package = module_name(path).split(".")
    if path.name != "__init__.py":
        package = package[:-1]
    found = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found += [(alias.name, node.lineno) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            base = base + (node.module.split(".") if node.module else [])
            found += [(".".join([*base, alias.name]), node.lineno) for alias in node.names]
    return found


def layer(module: str) -> int | None:
    """The layer of a module of the add-on; None for what is not of the add-on."""
    parts = module.split(".")
    if parts[0] != "addon":
        return None
    return LAYERS.get(parts[1], FACES) if len(parts) > 1 else FACES


@pytest.mark.parametrize("path", SOURCES, ids=module_name)
def test_imports_point_down(path):
    own = layer(module_name(path))
    up = [f"line {line}: {name}" for name, line in imported_modules(path) if (layer(name) or 0) > own]
    assert not up, f"{module_name(path)} imports from a layer above its own: {up}"


@pytest.mark.parametrize("path", SOURCES, ids=module_name)
def test_each_library_stays_in_its_room(path):
    own = layer(module_name(path))
    roots = {name.split(".")[0] for name, _ in imported_modules(path)}
    blender = roots & {"bpy", "bpy_extras", "mathutils", "gpu", "gpu_extras", "blf", "bmesh", "addon_utils", "bl_ui", "rna_prop_ui"}
    assert not (blender and own < LAYERS["snapshot"]), f"{sorted(blender)} below snapshot"
    assert not (roots & {"moderngl", "glcontext"} and own != LAYERS["pipeline"]), "OpenGL outside the pipeline"
    assert not (roots - {"numpy", "addon"} - sys.stdlib_module_names and own <= LAYERS["maths"]), "maths needs numpy only"
    assert not roots & {"scipy", "networkx", "rtree"}, "neither Blender nor the package has it"


@pytest.mark.parametrize("path", SOURCES, ids=module_name)
def test_imports_are_relative_and_paths_untouched(path):
    source = path.read_text(encoding="utf-8")
    tree = ast.parse(source)
    absolute = [n for n in ast.walk(tree) if isinstance(n, ast.ImportFrom) and not n.level and n.module.split(".")[0] == "addon"]
    absolute += [n for n in ast.walk(tree) if isinstance(n, ast.Import) and any(a.name.split(".")[0] == "addon" for a in n.names)]
    assert not absolute, f"line {absolute[0].lineno}: inside Blender the package has another name"
    assert "sys.path" not in source, "extensions may not edit sys.path"


@pytest.mark.parametrize("path", SOURCES, ids=module_name)
def test_files_and_functions_stay_small(path):
    source = path.read_text(encoding="utf-8")
    assert len(source.splitlines()) <= MAX_FILE_LINES
    functions = [n for n in ast.walk(ast.parse(source)) if isinstance(n, ast.FunctionDef | ast.AsyncFunctionDef)]
    long = {n.name: n.end_lineno - n.lineno + 1 for n in functions if n.end_lineno - n.lineno >= MAX_FUNCTION_LINES}
    assert not long, f"longer than {MAX_FUNCTION_LINES} lines: {long}"


IMPORT_WITHOUT_BLENDER = """
import importlib, pkgutil, sys

class NoBlender:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {"bpy", "mathutils", "gpu", "bmesh", "addon_utils"}:
            raise ImportError(f"{name} is not here")

sys.meta_path.insert(0, NoBlender())
import addon
for room in ("maths", "pipeline"):
    package = importlib.import_module(f"addon.{room}")
    for module in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
        importlib.import_module(module.name)
        print(module.name)
"""


def test_maths_and_pipeline_import_without_blender():
    done = subprocess.run([sys.executable, "-c", IMPORT_WITHOUT_BLENDER], cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert {"addon.maths.view", "addon.scene.records"} <= set(done.stdout.split())
