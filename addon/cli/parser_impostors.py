"""The command line's words for impostors; the others are in `parser.py`. No bpy."""

from __future__ import annotations

import argparse

from .argument_types import finite
from .parser_batch import positive


def add_objects(parser: argparse.ArgumentParser) -> None:
    """What is captured."""
    parser.add_argument_group("impostors").add_argument(
        "--object",
        dest="objects",
        action="append",
        metavar="NAME",
        help="an object, an assembly's empty or a collection; may be given several times; patterns (pump*) make one impostor of each match "
        "(default: what is marked in the .blend, else all as one)",
    )


def add_capture(parser: argparse.ArgumentParser, formats: tuple[str, ...]) -> None:
    """What is written of a capture."""
    group = parser.add_argument_group("output")
    group.add_argument(
        "--format", choices=formats, default="png", help="images: 8-bit colour and 16-bit depth (png), exact values (exr), all in one (npz)"
    )
    group.add_argument("--unlit", action="store_true", help="bare colours of the surfaces, to be relit with the normals")
    group.add_argument("--plane", action="store_true", help="also a .blend with a plane whose material shows the impostor, at its place")


def add_path(parser: argparse.ArgumentParser) -> None:
    """Where the camera goes."""
    group = parser.add_argument_group("path")
    group.add_argument("--from-frame", type=int, metavar="A", help="first frame of the scene's animation")
    group.add_argument("--to-frame", type=int, metavar="B", help="last frame of the scene's animation")
    group.add_argument("--orbit", type=finite, metavar="DEG", help="turn the camera by so many degrees about the impostors' vertical axis")
    group.add_argument("--steps", type=positive, metavar="N", help="steps of the orbit (default: one per degree)")
    group.add_argument("--pictures", action="store_true", help="also the picture of every frame, drawn with impostors")


def path_mistake(args: argparse.Namespace) -> str | None:
    """What is wrong with a path's arguments together; None when it is clear where the camera goes."""
    frames = (args.from_frame, args.to_frame)
    if (args.orbit is None) == (frames == (None, None)):
        return "say where the camera goes: --orbit DEG [--steps N], or --from-frame A --to-frame B"
    if args.orbit is not None:
        return None if 0.0 < abs(args.orbit) <= 3600.0 else "--orbit takes up to 3600 degrees, not 0"
    if None in frames:
        return "--from-frame and --to-frame belong together"
    if args.steps is not None:
        return "--steps belongs to --orbit"
    return None if frames[0] <= frames[1] else "the last frame comes before the first"
