"""The command line: its words are in `cli_options.py`; here they are turned into work and an exit code.

0: all done. 1: some input failed, the others are done, the report says which and why. 2: the command line was not understood.
"""

from __future__ import annotations

import argparse
import os
import sys
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

from .cli_batch import run_inputs, run_worker
from .cli_impostor_options import path_mistake
from .cli_options import build_parser, joined, view_mistake
from .combinations import idle, named
from .errors import SettingsError, UserError
from .options import with_options
from .outputs import json_text, write_json
from .pipeline.settings import Settings

DONE, FAILED, MISUSED = 0, 1, 2
BENCH_TRIANGLES = 1_000_000


def main(argv: list[str]) -> int:
    """Run one command; gives the exit code."""
    parser = build_parser()
    try:
        args = parser.parse_args(joined(argv))
        args.from_file = read_settings(args.settings)
    except SystemExit as stop:
        return int(stop.code or 0)
    except UserError as error:
        print(f"cad_shadow: {error}", file=sys.stderr)
        return MISUSED
    if args.command == "theory":
        return theory_command(args)
    if args.command == "bench" and not args.inputs and args.deck is None:
        args.deck = BENCH_TRIANGLES
    if not args.inputs and args.deck is None:
        args.deck = args.example
    if not args.inputs and args.deck is None:
        print(
            f"cad_shadow {args.command}: no INPUT given; name a .blend or CAD file, or ask for the example with --deck 100000",
            file=sys.stderr,
        )
        return MISUSED
    mistake = path_mistake(args) if args.command == "impostor-path" else None
    if mistake is not None:
        print(f"cad_shadow {args.command}: {mistake}", file=sys.stderr)
        return MISUSED
    args.argv = argv
    with chatter_silenced() as out:
        if args.worker:
            run_worker(args, out)
            return DONE
        return finish(args, run_inputs(args), out)


def read_settings(path: str | None) -> dict[str, object]:
    """A settings file: options by name at the top, or tables named like the report's `settings`. Raises `SettingsError`."""
    if path is None:
        return {}
    try:
        content = tomllib.loads(Path(path).read_text(encoding="utf-8"))
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
    from .maths.theory import text_report, theory

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
        print(f"cad_shadow theory: {error}", file=sys.stderr)
        return MISUSED
    except UserError as error:
        print(f"cad_shadow theory: {error}", file=sys.stderr)
        return FAILED
    for line in () if args.quiet else idle_options(settings, args):
        print(f"cad_shadow theory: {line}", file=sys.stderr)
    if args.json:
        print(json_text(result))
    elif not args.quiet:
        print(text_report(result, args.fov_y / 2.0, settings.warp, settings.partition))
    return DONE


def finish(args: argparse.Namespace, reports: list[dict[str, object]], out: TextIO) -> int:
    """Write and print the reports; the exit code says whether every input was done."""
    whole = reports[0] if len(reports) == 1 else reports
    failed = any(report["errors"] for report in reports)
    if args.report:
        try:
            write_json(Path(args.report), whole)
        except UserError as error:
            print(f"cad_shadow: {error}", file=sys.stderr)
            failed = True
    if args.json:
        print(json_text(whole), file=out, flush=True)
    return FAILED if failed else DONE


@contextmanager
def chatter_silenced() -> Iterator[TextIO]:
    """Blender prints to the process's standard output from C. While this lasts that goes nowhere; what is yielded is the real one."""
    sys.stdout.flush()
    real = os.dup(1)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 1)
        with os.fdopen(os.dup(real), "w", encoding="utf-8") as out:
            yield out
    finally:
        sys.stdout.flush()
        os.dup2(real, 1)
        os.close(real)
        os.close(nowhere)
