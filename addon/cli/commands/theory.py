"""`theory`: what the texts predict, without a scene."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from ...errors import SettingsError, UserError
from ...settings.groups import Settings
from ...studies.outputs import json_text, write_json
from ...studies.terminal import complain, told
from ..exit_codes import DONE, FAILED, MISUSED
from ..settings_file import chosen_settings, idle_options


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
        return DONE if told(sys.stdout, json_text(result)) else FAILED
    if not args.quiet and not told(sys.stdout, text_report(result, args.fov_y / 2.0, settings.warp, settings.partition)):
        return FAILED
    return DONE
