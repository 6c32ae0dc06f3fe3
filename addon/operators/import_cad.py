"""`cad_shadow.import_cad`: File > Import > CAD, and CAD files dropped into the viewport or the outliner."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
from bpy_extras.io_utils import ImportHelper
from mathutils import Matrix

from ..blender import clip_range
from ..blender.cad_import import to_blender
from ..errors import UserError
from ..scene import cad
from ..scene.cad.sniff import SUFFIXES
from ..scene.cad.units import METRES_PER_UNIT, UPS
from ..scene.cad_model import CadModel

UNIT_TITLES = {
    "m": "Metres",
    "cm": "Centimetres",
    "mm": "Millimetres",
    "um": "Micrometres",
    "km": "Kilometres",
    "in": "Inches",
    "ft": "Feet",
    "yd": "Yards",
}
# Made here: Blender evaluates a class's annotations where a generator does not see the names of this module.
UNITS = [
    ("AUTO", "As the File Says", "What the file says, else metres (3MF: millimetres)"),
    *((name, UNIT_TITLES[name], f"1 unit in the file is {size:g} m") for name, size in METRES_PER_UNIT.items()),
]


class CAD_SHADOW_OT_import_cad(ImportHelper, bpy.types.Operator):
    """Import CAD files (STEP, glTF, STL, OBJ, PLY, OFF, 3MF) with part names, colours and shared meshes"""

    bl_idname = "cad_shadow.import_cad"
    bl_label = "Import CAD"
    bl_options = {"REGISTER", "UNDO"}

    filename_ext = ""
    filter_glob: bpy.props.StringProperty(default=";".join(f"*{s}" for s in SUFFIXES), options={"HIDDEN"})
    directory: bpy.props.StringProperty(subtype="DIR_PATH", options={"SKIP_SAVE", "HIDDEN"})
    files: bpy.props.CollectionProperty(type=bpy.types.OperatorFileListElement, options={"SKIP_SAVE", "HIDDEN"})
    units: bpy.props.EnumProperty(
        name="Unit",
        default="AUTO",
        description="The unit of the numbers in the file. STL, OBJ, PLY and OFF do not say theirs",
        items=UNITS,
    )
    up: bpy.props.EnumProperty(
        name="Up",
        default="AUTO",
        description="The axis of the file that becomes Blender's Z",
        items=[
            ("AUTO", "Automatic", "Y for glTF and OBJ, Z for all other formats"),
            *((axis, axis, f"{axis} of the file points up") for axis in UPS),
        ],
    )
    replaces_cube: bpy.props.BoolProperty(
        name="Remove Cube",
        description="The untouched cube that Blender begins a new file with: it would stand in the middle of the model",
        options={"SKIP_SAVE"},
    )

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """The file browser; for dropped files only the options. Offers to remove the start-up cube where there is one."""
        self.replaces_cube = startup_cube(context.scene) is not None
        return self.invoke_popup(context) if self.directory and self.files else ImportHelper.invoke(self, context, event)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Read every file, then make the objects of those that could be read; nothing is made of the others."""
        paths = self._paths()
        if all(path.is_dir() for path in paths):
            self.report({"ERROR"}, "No file is chosen: click on one or more CAD files first.")
            return {"CANCELLED"}
        progress = context.window_manager
        progress.progress_begin(0, 2 * len(paths))
        try:
            models = []
            for i, path in enumerate(paths):
                progress.progress_update(i)
                models += self._read(path)
            made = []
            for i, model in enumerate(models):
                progress.progress_update(len(paths) + i)
                made.append(to_blender(model, context.collection))
        finally:
            progress.progress_end()
        if not made:
            return {"CANCELLED"}
        cube = startup_cube(context.scene) if self.replaces_cube else None
        if cube is not None:
            bpy.data.objects.remove(cube)
        _select(context, made)
        _show(context, [model.bounds() for model in models])
        self.report({"INFO"}, "Imported " + "; ".join(_summary(m) for m in models))
        return {"FINISHED"}

    def _paths(self) -> list[Path]:
        chosen = [Path(self.directory) / f.name for f in self.files if f.name]
        return chosen or [Path(self.filepath)]

    def _read(self, path: Path) -> list[CadModel]:
        try:
            model = cad.read(path, None if self.units == "AUTO" else self.units, None if self.up == "AUTO" else self.up)
        except UserError as error:
            self.report({"ERROR"}, str(error))
            return []
        for warning in model.warnings:
            self.report({"WARNING"}, warning)
        return [model]


def startup_cube(scene: bpy.types.Scene) -> bpy.types.Object | None:
    """The cube that Blender begins a new file with, if nobody has touched it: unsaved file, where it was, as it was."""
    cube = None if bpy.data.filepath else scene.objects.get("Cube")
    if cube is None or cube.type != "MESH" or len(cube.data.vertices) != 8 or cube.data.users > 1 or cube.children:
        return None
    corners = np.empty(24, np.float32)
    cube.data.vertices.foreach_get("co", corners)
    is_bare = cube.parent is None and not cube.modifiers and not cube.constraints and cube.animation_data is None
    is_there = is_bare and cube.matrix_basis == Matrix.Identity(4) and len(np.unique(corners.reshape(8, 3), axis=0)) == 8
    return cube if is_there and (np.abs(corners) == 1.0).all() else None


def _select(context: bpy.types.Context, collections: list[bpy.types.Collection]) -> None:
    for ob in context.selected_objects:
        ob.select_set(False)
    objects = [ob for collection in collections for ob in collection.all_objects]
    for ob in objects:
        ob.select_set(True)
    context.view_layer.objects.active = next((ob for ob in objects if ob.data is not None), None)


def _show(context: bpy.types.Context, bounds: list[np.ndarray]) -> None:
    """Turn no view, but move each 3D viewport of the window to what was imported, and let it see that far and that near."""
    if context.window is None or bpy.app.background:
        return
    low, high = np.min([b[0] for b in bounds], axis=0), np.max([b[1] for b in bounds], axis=0)
    size = float(np.linalg.norm(high - low))
    for area in context.window.screen.areas:
        if area.type == "VIEW_3D":
            clip_range.fit(context.window.screen, area.spaces.active, size)
            region = next(r for r in area.regions if r.type == "WINDOW")
            with context.temp_override(area=area, region=region):
                bpy.ops.view3d.view_selected()


def _summary(model: CadModel) -> str:
    size = model.bounds()[1] - model.bounds()[0]
    return (
        f"{model.name}: {model.part_count:,} parts, {model.triangle_count:,} triangles, "
        f"{size[0]:.4g} × {size[1]:.4g} × {size[2]:.4g} m (unit {model.units}, {model.up} up)"
    )


class CAD_SHADOW_FH_import_cad(bpy.types.FileHandler):
    """CAD files may be dropped"""

    bl_idname = "CAD_SHADOW_FH_import_cad"
    bl_label = "CAD (Shadow Preview)"
    bl_import_operator = CAD_SHADOW_OT_import_cad.bl_idname
    bl_file_extensions = ";".join(SUFFIXES)

    @classmethod
    def poll_drop(cls, context: bpy.types.Context) -> bool:
        """Into the 3D viewport and the outliner."""
        return context.area is not None and context.area.type in {"VIEW_3D", "OUTLINER"}


def draw_menu(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """The entry in File > Import."""
    self.layout.operator(CAD_SHADOW_OT_import_cad.bl_idname, text="CAD: STEP, glTF, STL, OBJ, PLY, OFF, 3MF")


_classes = (CAD_SHADOW_OT_import_cad, CAD_SHADOW_FH_import_cad)


def register() -> None:
    """Offer the operator, its menu entry and the drop."""
    for cls in _classes:
        bpy.utils.register_class(cls)
    bpy.types.TOPBAR_MT_file_import.append(draw_menu)


def unregister() -> None:
    """Remove them."""
    bpy.types.TOPBAR_MT_file_import.remove(draw_menu)
    for cls in reversed(_classes):
        bpy.utils.unregister_class(cls)
