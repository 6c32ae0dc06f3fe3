"""The architecture, held by tests: imports only point down, libraries stay in their rooms, files and functions stay small.

`python tests/test_layers.py` prints the counts.
"""

import ast
import subprocess
import sys
from collections import defaultdict
from dataclasses import dataclass
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
ADDON = ROOT / "addon"

# The floors of every folder, from the ground up. What stands on one imports only what stands below it; not what stands beside it.
# "*": all files of the folder that are not named.
FLOORS = {
    "addon": "errors images < maths < scene settings < pipeline < studies < blender < operators api cli < __init__ < __main__",
    "addon/api": "view < impostors sun_hours < __init__",
    "addon/blender": "animation support < cad_materials changes clip_range face_values lettering own_images own_importers preferences"
    " redraw registering render_wish snapshot sun_turning textures translations view_border"
    " < cad_import section_properties sun_hours sun_properties"
    " < inputs presets light_kind properties rendering reprojection"
    " < image_editor sources < impostors live_scene session < panels viewport < engine hud < __init__",
    "addon/blender/hud": "canvas < * < __init__",
    "addon/blender/impostors": "marks plane < chosen < __init__",
    "addon/blender/panels": "chosen compatible layer_passes words < placing impostors < settings < quality < advice < __init__",
    "addon/blender/presets": "__init__",
    "addon/blender/snapshot": "cameras complaints light_links node_maths pictures random_numbers vertex_colors visibility < nodes varied"
    " < meshes shaders < lights materials world < instances < marks < reader < __init__",
    "addon/cli": "argument_types command exit_codes settings_file batch < rivals"
    " shared_arguments sun_arguments < commands < parser run < inputs < main"
    " < blender_command < __init__",
    "addon/cli/batch": "items progress < stamp workers < sheet < __init__",
    "addon/cli/commands": "* < impostor_path < __init__",
    "addon/images": "cryptomatte exr lettering png srgb < color_bar contact_sheet whole < heatmap < passes scale_bar < __init__",
    "addon/maths": "domains low_discrepancy tables < directions light_shapes sky spaces partitioning < light_set warping < choices < sun"
    " < view < frusta nearest relief < depth_projection shadow < anchored_camera error < __init__",
    "addon/maths/error": "comparison measure warped_map < aliasing precision < seams < theory < __init__",
    "addon/maths/relief": "picture settings views warp < ahead beta frame outline < edges life < error < carry < __init__",
    "addon/maths/shadow": "light_space fit_view partitions projection spacing warps < crop cut faces lookup slices strength < lamps"
    " suited_cut < fit < light_set_plan < __init__",
    "addon/maths/partitioning": "row splits < * < __init__",
    "addon/maths/warping": "formulas < row < * < __init__",
    "addon/operators": "row ticking sun_object < background place_sun animate_sun < * < impostor_export impostor_report < __init__",
    "addon/pipeline": "frame gl reach_choice < geometry < detail < passes < device < impostors < job < many_lights reach overlay"
    " render_passes see_through < light_batches sky < stages < summing < shading < renderer < timing < bake bare_passes"
    " reach_tasks remote < __init__",
    "addon/pipeline/detail": "bodies choice distance < collapse < child kept < making < drawn < __init__",
    "addon/pipeline/geometry": "closed clusters culling octahedral pools ranges surface_links < draw_list packing < parts < store"
    " < __init__",
    "addon/pipeline/gl": "allocation machine < gl_raw < context depth_buffer programs readback < __init__",
    "addon/pipeline/impostors": "baked records texels < costs tiles < capture < ahead draw predictions < views < life < shadows < __init__",
    "addon/pipeline/passes": "fill large_casters large_surfaces light_sums < surface < gbuffer large_receivers log_map outline"
    " shadow_defines < nsm peeling sky_light < shadow < caps edges panes reach_sums < shade < samples < __init__",
    "addon/pipeline/render_passes": "row < * < __init__",
    "addon/pipeline/remote": "words < renderer child < __init__",
    "addon/scene": "child_python light_choice looks memory mesh_prep plain_text user_files < records < cad_model default_view ground"
    " local_origin mesh_pieces < asked_view cad platform_deck section < reading < __init__",
    "addon/scene/cad": "decimals ears < colors companions draco losses meshopt meshopt_filters obj_lines polygons raw step_text units"
    " < text_numbers < cad_format collada_document gltf_document mtl ply_elements step_structure < gltf_look step_shapes"
    " < gltf_primitives < * < assemble iges sniff step < formats < __init__",
    "addon/scene/reading": "limits wire < process child < apart < __init__",
    "addon/scene/platform_deck": "shapes < parts < layout < __init__",
    "addon/scene/section": "clip closed < caps < cut < __init__",
    "addon/settings": "lighting shadowing sky stage < groups < option versions words < impostor_options light_options sky_options"
    " stage_options < options < combinations looks < __init__",
    "addon/settings/shadowing": "row < * < __init__",
    "addon/studies": "diagnostics legends map_outlines pending report scratch staged stopping terminal < run < advice error_graph"
    " light_view outputs truth < impostors surface_samples < sun < __init__",
    "addon/studies/advice": "candidates goal sampled_frame < shadow_tests < search < report < __init__",
    "addon/studies/impostors": "asked files states < path < __init__",
    "addon/studies/sun": "days moments < hours pictures < __init__",
    "addon/studies/truth": "backends triangles < tracer < footprint < compare < __init__ < against",
}
MOST_ROOMS = 14  # at the top of addon/, shaders/ among them
MAX_FILE_LINES = 400
MAX_FUNCTION_LINES = 60

BLENDER = {"bpy", "bpy_extras", "mathutils", "gpu", "gpu_extras", "blf", "imbuf", "bmesh", "addon_utils", "bl_ui", "rna_prop_ui"}
WITH_BLENDER = {"blender", "operators", "api", "cli", "__init__", "__main__"}
BLENDERS_BVH = "addon/studies/truth/backends.py"  # asks for mathutils only where embreex is not there
NUMPY_ONLY = {"errors", "images", "maths", "settings"}


@dataclass(frozen=True, eq=False)
class Source:
    """A file: its text, its syntax tree, the files of the add-on that it imports with the line, and the libraries."""

    path: str
    text: str
    tree: ast.Module
    arrows: tuple[tuple[str, int], ...]
    libraries: frozenset[str]

    @property
    def room(self) -> str:
        """The entry of addon/ that it belongs to."""
        return entry("addon", self.path)


@cache
def sources() -> dict[str, Source]:
    """Every file of the add-on by its path, read once."""
    paths = sorted(path for path in ADDON.rglob("*.py") if path.parent.name != "cad_shadow_preview")
    modules = {module_name(path): path.relative_to(ROOT).as_posix() for path in paths}
    return {modules[module_name(path)]: read(path, modules) for path in paths}


def module_name(path: Path) -> str:
    """addon/maths/view.py → addon.maths.view; a package's __init__.py → the package."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def read(path: Path, modules: dict[str, str]) -> Source:
    """Parse a file; its imports are those anywhere in it, also for typing and within functions."""
    text = path.read_text(encoding="utf-8")
    tree = ast.parse(text)
    package = module_name(path).split(".")
    package = package if path.name == "__init__.py" else package[:-1]
    arrows, libraries = [], set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            libraries |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and not node.level:
            libraries.add(node.module.split(".")[0])
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(package[: len(package) - node.level + 1] + (node.module.split(".") if node.module else []))
            arrows += [(modules.get(f"{base}.{alias.name}") or modules[base], node.lineno) for alias in node.names]
    return Source(path.relative_to(ROOT).as_posix(), text, tree, tuple(arrows), frozenset(libraries))


def entry(folder: str, path: str) -> str:
    """What of `folder` a path below it belongs to: a file (without .py) or a folder."""
    return path.removeprefix(folder + "/").split("/")[0].removesuffix(".py")


def floors(folder: str) -> dict[str, int]:
    """The floor of each name in the table of a folder."""
    return {name: floor for floor, names in enumerate(FLOORS[folder].split(" < ")) for name in names.split()}


def parting(source: str, target: str) -> tuple[str, str, str]:
    """The folder below which two paths part, and what of it each belongs to: there their floors are compared."""
    folder = source.rpartition("/")[0]
    while not target.startswith(folder + "/"):
        folder = folder.rpartition("/")[0]
    return folder, entry(folder, source), entry(folder, target)


def arrows_up() -> list[str]:
    """The imports that do not point down."""
    found = []
    for source in sources().values():
        for target, line in source.arrows:
            folder, own, other = parting(source.path, target)
            at = floors(folder)
            if not at.get(other, at.get("*", 0)) < at.get(own, at.get("*", 0)):
                found.append(f"{source.path}:{line} imports {target}: in {folder} {own} does not stand above {other}")
    return found


def circles() -> list[str]:
    """A circle of files, and one of the entries of any folder, where there is one."""
    graphs: dict[str, dict[str, set[str]]] = defaultdict(lambda: defaultdict(set))
    for source in sources().values():
        for target, _ in source.arrows:
            folder, own, other = parting(source.path, target)
            graphs["files"][source.path].add(target)
            graphs[folder][own].add(other)
    found = []
    for name, graph in graphs.items():
        try:
            TopologicalSorter(graph).prepare()
        except CycleError as error:
            found.append(f"{name}: {' <- '.join(error.args[1])}")
    return found


def counts() -> dict[str, int]:
    """What the size of the house is judged by. `floors`: the longest chain of imports between rooms."""
    rooms: dict[str, set[str]] = defaultdict(set)
    for source in sources().values():
        rooms[source.room] |= {entry("addon", target) for target, _ in source.arrows} - {source.room}
    height: dict[str, int] = {}
    if not circles():
        for room in TopologicalSorter(rooms).static_order():
            height[room] = 1 + max((height[below] for below in rooms[room]), default=0)
    return {
        "files": len(sources()),
        "entries at the top": len({entry("addon", p.relative_to(ROOT).as_posix()) for p in ADDON.iterdir() if p.name != "__pycache__"}),
        "floors": max(height.values(), default=0),
        "arrows between rooms": sum(map(len, rooms.values())),
        "arrows up or sideways": len(arrows_up()),
        "circles": len(circles()),
    }


def test_the_table_names_every_file_and_nothing_else():
    there = defaultdict(set)
    for path in sources():
        folder = path.rpartition("/")[0]
        while folder:
            there[folder].add(entry(folder, path))
            folder = folder.rpartition("/")[0]
    assert set(there) == set(FLOORS), "a folder without floors, or floors without a folder"
    unknown = [f"{folder}/{name}" for folder, names in there.items() if "*" not in floors(folder) for name in names - set(floors(folder))]
    gone = [f"{folder}/{name}" for folder, names in there.items() for name in set(floors(folder)) - names - {"*"}]
    assert not unknown, "not in the table"
    assert not gone, "in the table, but not there"


def test_imports_point_down():
    print(counts())
    up = arrows_up()
    assert not up, "\n".join(up)


def test_there_is_no_circle():
    assert not circles()


def test_the_top_stays_small():
    assert counts()["entries at the top"] <= MOST_ROOMS


def test_each_library_stays_in_its_room():
    for source in sources().values():
        libraries, where = source.libraries, source.path
        may = source.room in WITH_BLENDER or where == BLENDERS_BVH
        assert may or not libraries & BLENDER, f"{where}: {sorted(libraries & BLENDER)} below blender"
        assert source.room == "pipeline" or not libraries & {"moderngl", "glcontext"}, f"{where}: OpenGL outside the pipeline"
        others = libraries - {"numpy"} - sys.stdlib_module_names
        assert source.room not in NUMPY_ONLY or not others, f"{where}: {sorted(others)}, where numpy must do"
        assert not libraries & {"scipy", "networkx", "rtree"}, f"{where}: neither Blender nor the package has it"


def test_imports_are_relative_and_paths_untouched():
    for source in sources().values():
        assert "addon" not in source.libraries, f"{source.path}: inside Blender the package has another name"
        assert "sys.path" not in source.text, f"{source.path}: extensions may not edit sys.path"


def test_no_two_classes_have_one_name():
    places = defaultdict(list)
    for source in sources().values():
        for node in source.tree.body:
            if isinstance(node, ast.ClassDef):
                places[node.name].append(source.path)
    assert not {name: paths for name, paths in places.items() if len(paths) > 1}


def test_files_and_functions_stay_small():
    for source in sources().values():
        assert len(source.text.splitlines()) <= MAX_FILE_LINES, source.path
        functions = [n for n in ast.walk(source.tree) if isinstance(n, ast.FunctionDef | ast.AsyncFunctionDef)]
        long = {n.name: n.end_lineno - n.lineno + 1 for n in functions if n.end_lineno - n.lineno >= MAX_FUNCTION_LINES}
        assert not long, f"{source.path}: longer than {MAX_FUNCTION_LINES} lines: {long}"


IMPORT_WITHOUT_BLENDER = """
import importlib, pkgutil, sys

class NoBlender:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {"bpy", "mathutils", "gpu", "bmesh", "addon_utils"}:
            raise ImportError(f"{name} is not here")

sys.meta_path.insert(0, NoBlender())
import addon
for room in ("errors", "images", "maths", "scene", "settings", "pipeline", "studies"):
    package = importlib.import_module(f"addon.{room}")
    print(package.__name__)
    for module in pkgutil.walk_packages(getattr(package, "__path__", []), package.__name__ + "."):
        importlib.import_module(module.name)
        print(module.name)
"""


def test_all_below_blender_imports_without_it():
    done = subprocess.run([sys.executable, "-c", IMPORT_WITHOUT_BLENDER], cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    below = {module_name(ROOT / path) for path, source in sources().items() if source.room not in WITH_BLENDER}
    assert below == set(done.stdout.split())


if __name__ == "__main__":
    print("\n".join(f"{name}: {count}" for name, count in counts().items()))
    print("\n".join([*arrows_up(), *circles()]))
