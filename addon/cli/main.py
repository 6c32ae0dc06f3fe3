"""The command line: its words are in `parser.py`; here they are turned into work and an exit code.

0: all done. 1: some input failed, the others are done, the report says which and why. 2: the command line was not understood.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from typing import TextIO

from ..errors import UserError
from ..scene.user_files import run_of_inputs
from ..studies.outputs import check_target, json_text, recorded, run_of_results, write_json
from ..studies.stopping import heeded
from ..studies.terminal import Closed, complain, flushed, make_ready, printed
from .command import Command
from .commands import COMMANDS
from .exit_codes import DONE, FAILED, MISUSED
from .inputs import Attached, claim_results, report_mistake, run_inputs, run_worker
from .parser import build_parser, joined, view_mistake
from .settings_file import read_settings


def main(argv: list[str], attached: Attached = nullcontext, is_apart: bool = False) -> int:
    """Run one command; gives the exit code. `attached()`: the add-on enabled while it lasts; nothing to do where it is enabled already.

    `is_apart`: .blend files are opened in a process of their own within the limits for reading, not in this one.
    """
    make_ready()
    try:
        with run_of_inputs(), run_of_results():
            code = _run(argv, attached, is_apart)
    except KeyboardInterrupt:
        complain("cad_shadow: stopped.")
        code = FAILED
    return code if flushed() else max(code, FAILED)


def _run(argv: list[str], attached: Attached, is_apart: bool) -> int:
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
    command = COMMANDS[args.command]
    if command.alone is not None:
        return command.alone(args)
    if not args.inputs and args.deck is None:
        args.deck = args.example
    args.argv, args.is_apart = argv, is_apart
    mistake = _mistake(args, command)
    if mistake is not None:
        complain(f"cad_shadow {args.command}: {mistake}")
        return MISUSED
    with chatter_silenced() as out, heeded(args.worker):
        if args.worker:
            run_worker(args, out, attached)
            return DONE
        return finish(args, run_inputs(args, attached), out)


def _mistake(args: argparse.Namespace, command: Command) -> str | None:
    """What is wrong with arguments together, in words."""
    if not args.inputs and args.deck is None:
        return "no INPUT given; name a .blend or CAD file, or ask for the example with --deck 100000"
    return command.mistake(args) or view_mistake(args) or report_mistake(args)


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
    if args.json and not printed(out, json_text(whole)):
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
