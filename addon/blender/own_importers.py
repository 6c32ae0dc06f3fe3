"""Files that Blender's own importers read (`CadFormat.importers`), through the same doors as those that this program reads.

They run in Blender itself, without the limits of `scene/reading`.
"""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np

from ..errors import CadFileError
from ..scene.cad.formats import BY_SUFFIX
from ..scene.cad.sniff import checked_path
from ..scene.plain_text import shown, shown_name


def is_for_blender(path: Path) -> bool:
    """Whether this is a file that Blender's own importers read."""
    row = BY_SUFFIX.get(path.suffix.lower())
    return row is not None and bool(row.importers)


def imported(
    path: Path, parent: bpy.types.Collection, units: str | None = None, up: str | None = None
) -> tuple[bpy.types.Collection, tuple[str, ...]]:
    """The objects of a file in a new collection under `parent`, and what the user should know. What is selected and active stays so.

    Raises `CadFileError`, one line that says what to do; then nothing has been made.
    """
    file = checked_path(path, BY_SUFFIX)
    operator = _operator(file)
    before, layer = set(bpy.data.objects), bpy.context.view_layer
    selected, active = [ob for ob in layer.objects if ob.select_get()], layer.objects.active
    _run(operator, file)
    made = [ob for ob in bpy.data.objects if ob not in before]
    if not any(ob.type == "MESH" and len(ob.data.polygons) for ob in made):
        bpy.data.batch_remove(made)
        raise CadFileError(f"{shown_name(file.name)} holds no face to draw: export it with surfaces or a mesh.")
    collection = bpy.data.collections.new(file.stem)
    parent.children.link(collection)
    for ob in made:
        for other in ob.users_collection:
            other.objects.unlink(ob)
        collection.objects.link(ob)
    layer.update()
    for ob in layer.objects:
        ob.select_set(ob in selected)
    layer.objects.active = active
    warned = f"{shown_name(file.name)}: Blender's own importer takes the unit and the up axis from the file; those chosen are not used."
    return collection, (warned,) if units or up else ()


def _operator(file: Path) -> bpy.types.bpy_struct:
    """The first of the format's importers that this Blender has."""
    row = BY_SUFFIX[file.suffix.lower()]
    for name in row.importers:
        room, _, own = name.partition(".")
        operator = getattr(getattr(bpy.ops, room), own)
        try:
            operator.get_rna_type()
        except KeyError:
            continue
        return operator
    raise CadFileError(
        f"{shown_name(file.name)} is a {row.name} file, and Blender {bpy.app.version_string} has no importer for {row.name} here: "
        f"enable its add-on in the preferences, or export the file as glTF or STEP."
    )


def _run(operator: bpy.types.bpy_struct, file: Path) -> None:
    try:
        operator(filepath=str(file.absolute()))
    except (RuntimeError, UnicodeEncodeError) as error:
        reason = shown(" ".join(str(error).removeprefix("Error: ").split()))[:200]
        raise CadFileError(f"{shown_name(file.name)} cannot be read by Blender's own importer ({reason}): export it again.") from error


def bounds(collection: bpy.types.Collection) -> np.ndarray:
    """(2, 3) axis-aligned bounds of the meshes of a collection, metres."""
    boxes = [np.array(ob.matrix_world) @ _corners(ob) for ob in collection.all_objects if ob.type == "MESH" and len(ob.data.vertices)]
    points = np.concatenate([box[:3] for box in boxes], axis=1)
    return np.stack([points.min(axis=1), points.max(axis=1)])


def _corners(ob: bpy.types.Object) -> np.ndarray:
    """(4, 8) of the object's own box."""
    return np.vstack([np.array(ob.bound_box).T, np.ones(8)])
