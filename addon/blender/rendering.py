"""Asking Blender to render with our engine, and getting the outcome itself, not only the file.

A picture for the command line or a script goes through `bpy.ops.render.render`, as F12 does: same dependency graph (render visibility,
render subdivision), same engine, same compositor, same writing. So the results agree bit by bit.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import bpy

from ..errors import Cancelled, OutputError, SceneError, UserError
from ..pipeline.job import Job
from ..scene.plain_text import shown_name
from ..studies import stopping
from ..studies.run import Outcome
from .render_wish import ENGINE, NO_CAMERA, RenderWish, active, isometric

NOT_CALLED = "Blender did not call the engine: is the view layer switched off for rendering?"
NO_FILES = "The compositor's File Output nodes write nothing here: {}. Only F12 and animations run them."
NO_BORDER = "The render border is left out: commands and scripts make whole pictures."
LONGEST_PATH = 1000
"""Bytes of a path that Blender takes whole (it cuts at 1024)."""


def render(scene: bpy.types.Scene, wish: RenderWish, write_to: Path | None = None) -> Outcome:
    """Render `scene` once as `wish` says, blocking; with `write_to` Blender also writes the picture there, as it writes an F12.

    The scene's engine and output settings are put back afterwards. Raises `UserError` (of whatever kind the engine met).
    """
    _through_the_engine(scene, wish, write_to)
    if wish.outcome is None:
        raise wish.error or Cancelled(NOT_CALLED)
    return wish.outcome


def read(scene: bpy.types.Scene, wish: RenderWish) -> Job:
    """What `render` would draw, without drawing it: the scene as a render sees it. Raises `UserError`."""
    asked = replace(wish, reads_only=True)
    _through_the_engine(scene, asked, None)
    if asked.job is None:
        raise asked.error or Cancelled(NOT_CALLED)
    return asked.job


def _through_the_engine(scene: bpy.types.Scene, wish: RenderWish, write_to: Path | None) -> None:
    """Have Blender call the engine with `wish` active."""
    if scene.camera is None and wish.camera is None:
        wish.camera, wish.warnings = isometric, (*wish.warnings, NO_CAMERA)
    nodes = file_output_nodes(scene)
    if nodes and scene.render.use_compositing:
        wish.warnings = (*wish.warnings, NO_FILES.format(", ".join(shown_name(node.name) for node in nodes)))
    if scene.render.use_border:
        wish.warnings = (*wish.warnings, NO_BORDER)
    with _borrowed(scene, wish.size, write_to), _moment(scene, wish), active(wish):
        try:
            with stopping.held():
                bpy.ops.render.render(write_still=write_to is not None, scene=scene.name)
        except RuntimeError as error:
            raise wish.error or _unwritten(wish, write_to, str(error)) from error


def _unwritten(wish: RenderWish, path: Path | None, message: str) -> UserError:
    """What Blender's error means when the engine had none: drawn, but not written; or not drawn."""
    if path is None or wish.outcome is None:
        return SceneError(_one_line(message))
    return OutputError(f"Blender could not write the picture ({_one_line(message)}): choose another folder, or make room.")


def blender_path(path: Path) -> str:
    """The path in the words of Blender's output path, where since 4.5 braces stand for variables. Raises `OutputError` if it has none."""
    text, folder = str(path), shown_name(str(path.parent))
    if bpy.app.version >= (4, 5, 0):
        text = text.replace("{", "{{").replace("}", "}}")
    try:
        if len(text.encode()) <= LONGEST_PATH:
            return text
    except UnicodeEncodeError:
        raise OutputError(f"{folder} is no name that Blender can write to: choose a folder in plain letters.") from None
    raise OutputError(f"{folder} is longer than Blender can write to: choose a folder with a shorter path.")


def _one_line(message: str) -> str:
    return " ".join(message.removeprefix("Error: ").split())


KEPT = (
    "engine",
    "filepath",
    "use_sequencer",
    "use_multiview",
    "use_border",
    "use_file_extension",
    "use_overwrite",
    "use_placeholder",
    "resolution_x",
    "resolution_y",
    "resolution_percentage",
)
KEPT_OF_FORMAT = ("media_type", "file_format", "color_mode", "color_depth")


@contextmanager
def _borrowed(scene: bpy.types.Scene, size: tuple[int, int] | None, write_to: Path | None) -> Iterator[None]:
    """The scene with our engine, the size asked for and a camera for Blender to accept; all put back at the end."""
    render = scene.render
    stand_in = None
    with restored(render, KEPT), file_format(scene, write_to), _muted(file_output_nodes(scene)):
        render.engine, render.use_sequencer, render.use_multiview, render.use_border = ENGINE, False, False, False
        if size is not None:
            render.resolution_x, render.resolution_y, render.resolution_percentage = *size, 100
        if scene.camera is None:
            stand_in = bpy.data.objects.new("CAD Shadow stand-in", bpy.data.cameras.new("CAD Shadow stand-in"))
            scene.camera = stand_in
        if write_to is not None:
            render.filepath = blender_path(write_to)
            render.use_file_extension, render.use_overwrite, render.use_placeholder = False, True, False
        try:
            yield
        finally:
            if stand_in is not None:
                scene.camera = None
                bpy.data.cameras.remove(stand_in.data)


@contextmanager
def _moment(scene: bpy.types.Scene, wish: RenderWish) -> Iterator[None]:
    """The scene in the frame asked for, with the view layer asked for alone; both put back. Raises `SceneError` for an unknown layer."""
    layers = list(scene.view_layers)
    if wish.view_layer is not None and wish.view_layer not in scene.view_layers:
        names = ", ".join(f"'{layer.name}'" for layer in layers)
        raise SceneError(f"There is no view layer '{wish.view_layer}' in scene '{scene.name}': choose one of {names}.")
    kept, used = scene.frame_current, [layer.use for layer in layers]
    try:
        if wish.frame is not None and wish.frame != kept:
            scene.frame_set(wish.frame)
        for layer in layers if wish.view_layer is not None else ():
            layer.use = layer.name == wish.view_layer
        yield
    finally:
        for layer, use in zip(layers, used, strict=True):
            if layer.use != use:
                layer.use = use
        if scene.frame_current != kept:
            scene.frame_set(kept)


def file_output_nodes(scene: bpy.types.Scene) -> list[bpy.types.Node]:
    """The compositor's nodes that write files of their own wherever the .blend says, those inside groups too, unless muted already."""
    tree = getattr(scene, "compositing_node_group", None) or getattr(scene, "node_tree", None)
    trees, found = [tree] if tree is not None else [], []
    for tree in trees:  # grows as groups are met
        for node in tree.nodes:
            inside = getattr(node, "node_tree", None)
            if node.type == "OUTPUT_FILE" and not node.mute:
                found.append(node)
            elif inside is not None and inside not in trees:
                trees.append(inside)
    return found


@contextmanager
def _muted(nodes: list[bpy.types.Node]) -> Iterator[None]:
    """These nodes do nothing while this lasts."""
    for node in nodes:
        node.mute = True
    try:
        yield
    finally:
        for node in nodes:
            node.mute = False


@contextmanager
def restored(holder: bpy.types.bpy_struct, names: tuple[str, ...]) -> Iterator[None]:
    """The properties `names` of `holder` (those this Blender has) put back at the end, in that order."""
    kept = {name: getattr(holder, name) for name in names if hasattr(holder, name)}
    try:
        yield
    finally:
        for name, value in kept.items():
            setattr(holder, name, value)


@contextmanager
def file_format(scene: bpy.types.Scene, path: Path | None) -> Iterator[None]:
    """PNG or EXR for a file name; colour mode and depth stay the scene's where it already writes that format."""
    image = scene.render.image_settings
    wanted = {".png": "PNG", ".exr": "OPEN_EXR"}.get(path.suffix if path else "")
    with restored(image, KEPT_OF_FORMAT):
        if wanted and image.file_format != wanted:
            if hasattr(image, "media_type"):
                image.media_type = "IMAGE"
            image.file_format, image.color_mode = wanted, "RGBA"
            image.color_depth = "32" if wanted == "OPEN_EXR" else "8"
        yield


def animated(scene: bpy.types.Scene, wish: RenderWish, first: int, last: int) -> Iterator[tuple[float, Job]]:
    """(frame, job) of every frame of the animation as a render sees it. The scene's frame is put back."""
    kept = scene.frame_current
    try:
        for frame in range(first, last + 1):
            scene.frame_set(frame)
            yield frame, read(scene, replace(wish, frame=None))
    finally:
        scene.frame_set(kept)
