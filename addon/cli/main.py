"""The command line: its words are in `parser.py`; here they are turned into work and an exit code.

0: all done. 1: some input failed, the others are done, the report says which and why. 2: the command line was not understood.
"""

from __future__ import annotations

import argparse
import os
import sys
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TextIO

from ..errors import SettingsError, UserError
from ..settings.combinations import idle, named
from ..settings.groups import Settings
from ..settings.options import with_options
from ..studies.outputs import check_target, json_text, recorded, run_of_results, write_json
from ..studies.stopping import heeded
from ..studies.terminal import Closed, complain, flushed, make_ready, told
from ..studies.user_files import read_bytes, run_of_inputs
from .inputs import claim_results, report_mistake, run_inputs, run_worker
from .parser import build_parser, joined
from .parser_impostors import path_mistake

DONE, FAILED, MISUSED = 0, 1, 2
BENCH_TRIANGLES = 1_000_000
MOST_SETTINGS = 1 << 20


def main(argv: list[str]) -> int:
    """Run one command; gives the exit code."""
    make_ready()
    try:
        with run_of_inputs(), run_of_results():
            code = _run(argv)
    except KeyboardInterrupt:
        complain("cad_shadow: stopped.")
        code = FAILED
    return code if flushed() else max(code, FAILED)


def _run(argv: list[str]) -> int:
    try:
        args = build_parser().parse_args(joined(argv))
        args.from_file = read_settings(args.settings)
        if args.report:
            check_target(Path(args.report))
    except SystemExit as stop:
        return int(stop.code or 0)
    except UserError as error:
        complain(f"cad_shadow: {error}")
        return MISUSED
    if args.command == "theory":
        return theory_command(args)
    if args.command == "bench" and not args.inputs and args.deck is None:
        args.deck = BENCH_TRIANGLES
    if not args.inputs and args.deck is None:
        args.deck = args.example
    args.argv = argv
    mistake = _mistake(args)
    if mistake is not None:
        complain(f"cad_shadow {args.command}: {mistake}")
        return MISUSED
    with chatter_silenced() as out, heeded(args.worker):
        if args.worker:
            run_worker(args, out)
            return DONE
        return finish(args, run_inputs(args), out)


def _mistake(args: argparse.Namespace) -> str | None:
    """What is wrong with arguments together, in words."""
    if not args.inputs and args.deck is None:
        return "no INPUT given; name a .blend or CAD file, or ask for the example with --deck 100000"
    if args.command == "impostor-path" and (mistake := path_mistake(args)):
        return mistake
    return report_mistake(args)


def read_settings(path: str | None) -> dict[str, object]:
    """A settings file: options by name at the top, or tables named like the report's `settings`. Raises `SettingsError`."""
    if path is None:
        return {}
    try:
        content = tomllib.loads(read_bytes(Path(path), MOST_SETTINGS).decode())
        overlaid(Settings(), content)
    except OSError as error:
        raise SettingsError(f"Settings file {path} cannot be read ({error.strerror}): check the path.") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise SettingsError(f"Settings file {path} is not TOML: {error}.") from error
    except (TypeError, AttributeError) as error:
        raise SettingsError(f"Settings file {path} has a table or key that is not a setting: {error}.") from error
    return content


def overlaid(settings: Settings, content: dict[str, object]) -> Settings:
    """`settings` with the tables and then the options of a settings file put in place."""
    tables = {
        name: {key: tuple(v) if isinstance(v, list) else v for key, v in value.items()}
        for name, value in content.items()
        if isinstance(value, dict)
    }
    values = {name.replace("-", "_"): value for name, value in content.items() if not isinstance(value, dict)}
    return with_options(settings.replaced(**tables), values)


def chosen_settings(base: Settings, args: argparse.Namespace) -> Settings:
    """The scene's settings, over them the settings file's, over them the command line's. Raises `SettingsError`."""
    given = _options_of(args)
    if given.get("bias") is not None and "bias_strategy" not in given:
        given["bias_strategy"] = "constant"
    return with_options(overlaid(base, args.from_file), given)


def idle_options(settings: Settings, args: argparse.Namespace) -> tuple[str, ...]:
    """A line for each option of the settings file or the command line that changes nothing in `settings`."""
    return idle(dict.fromkeys((*named(args.from_file), *_options_of(args))), settings)


def _options_of(args: argparse.Namespace) -> dict[str, object]:
    return {name.removeprefix("option_"): value for name, value in vars(args).items() if name.startswith("option_")}


def theory_command(args: argparse.Namespace) -> int:
    """`theory`: needs neither Blender nor OpenGL."""
    from ..maths.error.theory import text_report, theory

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


def finish(args: argparse.Namespace, reports: list[dict[str, object]], out: TextIO) -> int:
    """Write and print the reports; the exit code says whether every input was done."""
    whole = reports[0] if len(reports) == 1 else reports
    failed = any(report["errors"] for report in reports)
    if args.report:
        try:
            claim_results(args, reports)
            with recorded(reports[0]["input"] if len(reports) == 1 else "all inputs together"):
                write_json(Path(args.report), whole)
        except UserError as error:
            complain(f"cad_shadow: {error}")
            failed = True
    if args.json and not told(out, json_text(whole)):
        failed = True
    return FAILED if failed else DONE


@contextmanager
def chatter_silenced() -> Iterator[TextIO]:
    """Blender prints to the process's standard output from C. While this lasts that goes nowhere; what is yielded is the real one."""
    flushed()
    real = os.dup(1)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    out = sys.stdout if isinstance(sys.stdout, Closed) else os.fdopen(os.dup(real), "w", encoding="utf-8")
    try:
        os.dup2(nowhere, 1)
        yield out
    finally:
        with suppress(OSError):  # what nobody could get has been complained about
            out.close()
        flushed()
        os.dup2(real, 1)
        os.close(real)
        os.close(nowhere)
