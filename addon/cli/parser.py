"""The command line's words: one parser for `blender --command cad_shadow` and `python -m addon`. No bpy; nothing is done here."""

from __future__ import annotations

import argparse
import re

from .commands import COMMANDS
from .shared_arguments import NO_BATCH


def build_parser(prog: str = "cad_shadow") -> argparse.ArgumentParser:
    """The whole parser; `parse_args` gives a namespace with `command`, and one `option_NAME` per option of the method that was given."""
    parser = argparse.ArgumentParser(prog=prog, description="Anti-aliased shadow previews of CAD models, and their error.")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for row in COMMANDS.values():
        command = commands.add_parser(row.name, help=row.help, description=row.description)
        command.set_defaults(**NO_BATCH, preset=None)
        row.add_arguments(command)
    return parser


def view_mistake(args: argparse.Namespace) -> str | None:
    """What is wrong with the arguments about the view together, whatever is looked at; None when nothing is."""
    if args.near is not None and args.far is not None and args.near >= args.far:
        return f"--near {args.near:g} must be smaller than --far {args.far:g}"
    if args.ortho and args.view is None and args.eye is None:
        return "--ortho belongs to --view or --eye"
    if args.ortho and args.fov_y is not None and args.eye is None:
        return "--ortho has no --fov-y: leave one of them out"
    if args.target is not None and args.eye is None:
        return "--target belongs to --eye X,Y,Z"
    if args.eye is not None and args.eye == args.target:
        return "--eye and --target are the same point: move one of them"
    given = vars(args)
    if given.get("option_eta") is not None and given.get("option_warp_parameter") is not None:
        return "--eta and --warp-parameter set the same thing: give one of them"
    return None


def joined(argv: list[str]) -> list[str]:
    """Arguments with `--eye -1,2,3` joined to `--eye=-1,2,3`: argparse would take the value for an option."""
    out: list[str] = []
    for argument in argv:
        if out and re.match(r"-[\d.]", argument) and re.fullmatch(r"--[a-z-]+", out[-1]):
            out[-1] += "=" + argument
        else:
            out.append(argument)
    return out
