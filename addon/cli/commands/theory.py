"""`theory`: what the texts predict, without a scene."""

from __future__ import annotations

import argparse
import sys
from math import radians
from pathlib import Path

from ...errors import SettingsError, UserError
from ...settings.groups import Settings
from ...studies.outputs import json_text, write_json
from ...studies.terminal import complain, printed
from ..argument_types import between, degrees_between, finite, size
from ..command import Command
from ..exit_codes import DONE, FAILED, MISUSED
from ..settings_file import chosen_settings, idle_options
from ..shared_arguments import add_method, add_reporting


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """A view in numbers, and what the texts have something to say about."""
    view = parser.add_argument_group("view")
    view.add_argument("--near", type=finite, required=True, metavar="N", help="near distance")
    view.add_argument("--far", type=finite, required=True, metavar="F", help="far distance")
    view.add_argument(
        "--fov-y", type=degrees_between(0.0, 180.0), default=radians(60.0), metavar="DEG", help="vertical field of view (default 60)"
    )
    view.add_argument(
        "--gamma",
        type=degrees_between(-1e-9, 90.0 + 1e-9),
        default=radians(90.0),
        metavar="DEG",
        help="angle between light and view direction (default 90)",
    )
    view.add_argument("--size", type=size, metavar="WxH", help="picture size; with --map-size the resolution terms are included")
    view.add_argument("--curve", choices=("z",), help="add the error along the view, m_x(z) and m_z(z)")
    view.add_argument("--points", type=between(2, 100_000, is_whole=True), default=65, metavar="N", help="points of the curve (default 65)")
    add_reporting(parser, folder=False)
    add_method(parser, "warp", "partition", "map")


def theory_command(args: argparse.Namespace) -> int:
    """`theory`: needs neither Blender nor OpenGL."""
    from ...maths.error.theory import text_report, theory

    try:
        settings = chosen_settings(Settings(), args)
        map_size = args.option_map_size if "option_map_size" in args else None
        result = theory(
            args.near,
            args.far,
            args.fov_y / 2.0,
            args.gamma,
            settings.warp,
            settings.partition,
            map_size,
            args.size,
            args.points if args.curve else None,
        )
        if args.report:
            write_json(Path(args.report), result)
    except SettingsError as error:
        complain(f"cad_shadow theory: {error}")
        return MISUSED
    except UserError as error:
        complain(f"cad_shadow theory: {error}")
        return FAILED
    for line in () if args.quiet else idle_options(settings, args):
        complain(f"cad_shadow theory: {line}")
    if args.json:
        return DONE if printed(sys.stdout, json_text(result)) else FAILED
    if not args.quiet and not printed(sys.stdout, text_report(result, args.fov_y / 2.0, settings.warp, settings.partition)):
        return FAILED
    return DONE


ROW = Command(
    "theory",
    place=90,
    help="what the texts predict, without a scene",
    description="Warp parameter, splits, M_x, M_z, S.",
    add_arguments=add_arguments,
    alone=theory_command,
)
