"""`cad_shadow.import_cad`: File > Import > CAD, and CAD files dropped into the viewport or the outliner."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import bpy
import numpy as np
from bpy_extras.io_utils import ImportHelper
from mathutils import Matrix

from ..blender import clip_range
from ..blender.cad_import import to_blender
from ..blender.own_importers import bounds, imported, is_for_blender
from ..errors import UserError
from ..scene.cad.formats import BY_SUFFIX, FORMATS, SUFFIXES, said
from ..scene.cad.sniff import checked_path
from ..scene.cad.units import METRES_PER_UNIT, UPS
from ..scene.cad_model import CadModel
from ..scene.reading.apart import Reading
from ..scene.reading.limits import chosen
from ..scene.reading.process import prepare, shutdown
from .row import OperatorRow
from .ticking import Ticking, refused, say, takes_operators

POLL_S = 0.1
MENU_TEXT = "CAD model (.step, .glb, …)"
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
_OTHERWISE = ", ".join(f"{row.name}: {UNIT_TITLES[row.unit].lower()}" for row in FORMATS.values() if row.unit != "m")
_UNITLESS = said([row.name for row in FORMATS.values() if not row.fixes_unit], " and ")
_Y_UP = said([row.name for row in FORMATS.values() if row.up == "Y"], " and ")
# Made here: Blender evaluates a class's annotations where a generator does not see the names of this module.
UNITS = [
    ("AUTO", "As the File Says", f"What the file says, else metres ({_OTHERWISE})"),
    *((name, UNIT_TITLES[name], f"1 unit in the file is {size:g} m") for name, size in METRES_PER_UNIT.items()),
]


class CAD_SHADOW_OT_import_cad(Ticking, ImportHelper, bpy.types.Operator):
    """Import CAD files with part names, colours and shared meshes"""

    bl_description = f"Import CAD files ({said()}) with part names, colours and shared meshes"
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
        description=f"The unit of the numbers in the file. {_UNITLESS} do not say theirs",
        items=UNITS,
    )
    up: bpy.props.EnumProperty(
        name="Up",
        default="AUTO",
        description="The axis of the file that becomes Blender's Z",
        items=[
            ("AUTO", "Automatic", f"Y for {_Y_UP}, Z for all other formats"),
            *((axis, axis, f"{axis} of the file points up") for axis in UPS),
        ],
    )
    scale: bpy.props.FloatProperty(
        name="Scale",
        description="Makes the model so many times as large; its parts get this as their scale",
        default=1.0,
        min=1e-6,
        max=1e6,
    )
    place: bpy.props.EnumProperty(
        name="Into",
        default="ACTIVE",
        description="Where the collection that every file gets is put",
        items=[
            ("ACTIVE", "Active Collection", "Into the collection that is active in the outliner"),
            ("SCENE", "Scene Collection", "At the top of the outliner"),
        ],
    )
    fits_view: bpy.props.BoolProperty(
        name="Fit View", description="Move the 3D viewports so that all of the model is in sight; their direction stays", default=True
    )
    replaces_cube: bpy.props.BoolProperty(
        name="Remove Cube",
        description="The untouched cube that Blender begins a new file with: it would stand in the middle of the model",
        options={"SKIP_SAVE"},
    )

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """The file browser; for dropped files only the options. Offers to remove the start-up cube where there is one."""
        self.replaces_cube = startup_cube(context.scene) is not None
        self._is_asked_in_a_window = True
        prepare(chosen())  # while the user chooses
        return self.invoke_popup(context) if self.directory and self.files else ImportHelper.invoke(self, context, event)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Read every file, then make the objects of those that could be read; nothing is made of the others.

        Chosen in a window, the files are read while Blender goes on; a script waits.
        """
        self._todo, self._models, self._reading = self._paths(), [], None
        if all(path.is_dir() for path in self._todo):
            self.report({"ERROR"}, "No file is chosen: click on one or more CAD files first.")
            return {"CANCELLED"}
        if getattr(self, "_is_asked_in_a_window", False) and takes_operators(context.window):
            return self.begin(context)
        while (result := self.tick(context, POLL_S)) is None:
            pass
        return result

    def tick(self, context: bpy.types.Context, wait_s: float = 0.0) -> set[str] | None:
        """Look after the file that is being read, begin the next one, or make the objects."""
        if self._reading is None and not self._todo:
            return self._made(context)
        try:
            if self._reading is None and is_for_blender(self._todo[0]):
                self._models.append(checked_path(self._todo.pop(0), BY_SUFFIX))
                return None
            if self._reading is None:
                self._reading = Reading(self._todo.pop(0), *self._overrides())
            say(context, f"{self._reading.progress[1]} · Esc stops")
            self._models.append(self._reading.result(wait_s))
        except TimeoutError:
            return None
        except UserError as error:
            refused(self, error)
        self._reading = None
        return None

    def give_up(self, context: bpy.types.Context) -> None:
        """Nothing is made of what was read, or the file browser was closed."""
        shutdown()
        if getattr(self, "_todo", None) is None:
            return
        if self._reading is not None:
            self._reading.cancel()
        self.report({"INFO"}, "The import was stopped: nothing was imported.")

    def _made(self, context: bpy.types.Context) -> set[str]:
        """The objects of all that was read."""
        shutdown()
        cube = startup_cube(context.scene) if self.replaces_cube else None
        parent = context.scene.collection if self.place == "SCENE" else context.collection
        made = [one for model in self._models if (one := self._placed(model, parent)) is not None]
        if not made:
            return {"CANCELLED"}
        if cube is not None:
            bpy.data.objects.remove(cube)
        collections = [collection for collection, _, _ in made]
        first = next((ob for collection in collections for ob in collection.all_objects if ob.data is not None), None)
        context.view_layer.objects.active = first or context.view_layer.objects.active
        _show(context, [box * self.scale for _, box, _ in made], collections, fit=self.fits_view)
        self.report({"INFO"}, "Imported " + "; ".join(line for _, _, line in made))
        return {"FINISHED"}

    def _placed(self, model: CadModel | Path, parent: bpy.types.Collection) -> tuple[bpy.types.Collection, np.ndarray, str] | None:
        """The objects of a file, their bounds and a line about them; None where Blender's own importer, which reads it only now, fails."""
        if isinstance(model, CadModel):
            collection, warnings, box, line = to_blender(model, parent), model.warnings, model.bounds(), _summary(model)
        else:
            try:
                collection, warnings = imported(model, parent, *self._overrides())
            except UserError as error:
                refused(self, error)
                return None
            box = bounds(collection)
            line = f"{collection.name}: {len(collection.all_objects):,} objects, {_size(box)} m"
        for warning in warnings:
            self.report({"WARNING"}, warning)
        _scale(collection, self.scale)
        return collection, box, line

    def _overrides(self) -> tuple[str | None, str | None]:
        """The unit and the up axis that were chosen."""
        return None if self.units == "AUTO" else self.units, None if self.up == "AUTO" else self.up

    def _paths(self) -> list[Path]:
        chosen = [Path(self.directory) / f.name for f in self.files if f.name]
        return chosen or [Path(self.filepath)]


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


def _scale(collection: bpy.types.Collection, factor: float) -> None:
    """Make what lies in the collection so many times as large, about the world's origin."""
    objects = set(collection.all_objects)
    for ob in objects:
        if factor != 1.0 and ob.parent not in objects:
            ob.matrix_basis = Matrix.Scale(factor, 4) @ ob.matrix_basis


def _show(context: bpy.types.Context, bounds: list[np.ndarray], made: list[bpy.types.Collection], *, fit: bool) -> None:
    """Turn no view, but let each 3D viewport of the window see that far and that near, and, to `fit`, move it to what was imported."""
    if context.window is None or bpy.app.background:
        return
    low, high = np.min([b[0] for b in bounds], axis=0), np.max([b[1] for b in bounds], axis=0)
    size = float(np.linalg.norm(high - low))
    with _only_selected(context, made):
        for area in context.window.screen.areas:
            if area.type == "VIEW_3D":
                clip_range.fit(context.window.screen, area.spaces.active, size)
                region = next(r for r in area.regions if r.type == "WINDOW")
                if fit:
                    with context.temp_override(area=area, region=region):
                        bpy.ops.view3d.view_selected()


@contextmanager
def _only_selected(context: bpy.types.Context, collections: list[bpy.types.Collection]) -> Iterator[None]:
    """While this lasts what lies in the collections is selected; then what was before."""
    before, objects = list(context.selected_objects), {ob for collection in collections for ob in collection.all_objects}
    for ob in context.view_layer.objects:
        ob.select_set(ob in objects)
    try:
        yield
    finally:
        for ob in context.view_layer.objects:
            ob.select_set(ob in before)


def _summary(model: CadModel) -> str:
    return (
        f"{model.name}: {model.part_count:,} parts, {model.triangle_count:,} triangles, "
        f"{_size(model.bounds())} m (unit {model.units}, {model.up} up)"
    )


def _size(box: np.ndarray) -> str:
    return " × ".join(f"{side:.4g}" for side in box[1] - box[0])


class CAD_SHADOW_FH_import_cad(bpy.types.FileHandler):
    """CAD files may be dropped"""

    bl_idname = "CAD_SHADOW_FH_import_cad"
    bl_label = "CAD Model: Parts, Colors, True Units"
    bl_import_operator = CAD_SHADOW_OT_import_cad.bl_idname
    bl_file_extensions = ";".join(SUFFIXES)

    @classmethod
    def poll_drop(cls, context: bpy.types.Context) -> bool:
        """Into the 3D viewport and the outliner."""
        return context.area is not None and context.area.type in {"VIEW_3D", "OUTLINER"}


def draw_menu(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """The entry in File > Import."""
    self.layout.operator(CAD_SHADOW_OT_import_cad.bl_idname, text=MENU_TEXT)


ROW = OperatorRow("import_cad", 410, (CAD_SHADOW_OT_import_cad, CAD_SHADOW_FH_import_cad), entries=(("TOPBAR_MT_file_import", draw_menu),))
