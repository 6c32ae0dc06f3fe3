"""Running a command over its inputs: here or in worker processes, without what was done before, told as it goes."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TextIO

from ..errors import UserError
from ..scene.cad.formats import BY_SUFFIX
from ..scene.plain_text import shown, shown_name
from ..scene.reading.process import prepare
from ..scene.user_files import note
from ..studies import stopping
from ..studies.outputs import check_target, claim, recorded
from ..studies.report import failed_report
from ..studies.terminal import complain
from .batch.items import Item, items_of
from .batch.progress import Progress
from .batch.stamp import KEY, done_before, request_digest
from .batch.workers import Answer, answers, serve
from .shared_arguments import limits_of

LONGEST = 300
UNCHANGED = "done before, unchanged"
Attached = Callable[[], AbstractContextManager[None]]


def is_batch(args: argparse.Namespace, items: list[Item]) -> bool:
    """Whether reports note what they were made from, so that `--resume` knows next time."""
    return len(items) > 1 or args.resume or args.contact_sheet


def report_mistake(args: argparse.Namespace) -> str | None:
    """What is wrong with where --report goes, in words: over an input, or over what the run writes. Inputs are noted from here on."""
    items = items_of(args)
    for item in items:
        if item.source is not None:
            note(Path(item.source))
    if not args.report or args.worker:
        return None
    report = Path(args.report).absolute()
    try:
        check_target(report)
    except UserError as error:
        return f"--report: {error}"
    others = [item.report_path.absolute() for item in items] if len(items) > 1 else []
    if report in others:
        return f"--report {args.report} is where the report of one of the inputs goes: choose another name"
    return None


def claim_results(args: argparse.Namespace, reports: list[dict[str, object]]) -> None:
    """Note what worker processes have written as results of this run; raises `OutputError` where two inputs wrote the same file."""
    folder = Path(args.output or ".").absolute()
    for report in reports:
        for made in report.get(KEY, {}).get("files", ()):
            claim(folder / made["name"], report["input"])


def run_inputs(args: argparse.Namespace, attached: Attached) -> list[dict[str, object]]:
    """One report per input, in order. Says what happened; errors also with --quiet. An input that was not come to is a failed one.

    `attached` as in `main.main`.
    """
    items, folder = items_of(args), Path(args.output or ".")
    args.is_batch = is_batch(args, items)
    progress = Progress(len(items), sys.stderr, args.quiet)
    reports: dict[Item, dict[str, object]] = {}
    try:
        digest = request_digest(args) if args.resume else ""
        for item in items if args.resume else ():
            report = done_before(item, digest, folder)
            if report is not None:
                _keep_report(progress, reports, len(items), item, (report, UNCHANGED))
        todo = [item for item in items if item not in reports]
        for item, answer in _work(args, todo, attached):
            _keep_report(progress, reports, len(items), item, answer)
        stopping.check()
        if args.contact_sheet:
            _write_sheet(args, items, [reports[item] for item in items])
    except KeyboardInterrupt:
        progress.complain(f"cad_shadow: stopped; {len(reports)} of {len(items)} inputs were come to")
    finally:
        progress.close()
    return [reports.get(item) or failed_report(item.name, None, stopping.STOPPED) for item in items]


def _work(args: argparse.Namespace, todo: list[Item], attached: Attached) -> Iterator[tuple[Item, Answer]]:
    """The items done, each as its process can: with --jobs in several, a .blend in one of its own, which may crash or never end."""
    is_shared = args.jobs > 1 and len(todo) > 1
    apart = todo if is_shared else [item for item in todo if args.is_apart and item.is_blend]
    if apart:
        yield from answers(apart, args.argv, args.jobs)
    here = [item for item in todo if item not in apart]
    if here:
        if Path(here[0].source or "").suffix.lower() in BY_SUFFIX:
            prepare(limits_of(args))  # while Blender starts
        from .run import answers_here  # imports Blender, which talks

        with attached():
            yield from answers_here(here, args)


def _keep_report(progress: Progress, reports: dict[Item, dict[str, object]], total: int, item: Item, answer: Answer) -> None:
    """Keep an item's report and say how it went."""
    report, line = answer
    reports[item] = report
    for error in report["errors"]:
        progress.complain(f"cad_shadow: {shown_name(item.name, LONGEST)}: {shown(error)}")
    if not report["errors"]:
        progress.say(f"[{len(reports)}/{total}] {shown_name(item.name, LONGEST)}: {line}")
        for warning in report["warnings"] if line != UNCHANGED else ():
            progress.say(f"    {shown(warning)}")
    progress.advance()


def _write_sheet(args: argparse.Namespace, items: list[Item], reports: list[dict[str, object]]) -> None:
    """Write the contact sheet. A failure is an error of its own, noted in the last report."""
    from .batch.sheet import NAME, batch_sheet, write_sheet

    folder = Path(args.output or ".")
    try:
        with recorded("the contact sheet"):
            write_sheet(folder / NAME, *batch_sheet(reports, [item.stem.relative_to(folder).as_posix() for item in items], folder))
    except UserError as error:
        complain(f"cad_shadow: {error}")
        reports[-1]["errors"].append(str(error))


def run_worker(args: argparse.Namespace, out: TextIO, attached: Attached) -> None:
    """Be a worker of another process: inputs come on standard input."""
    from .run import one

    args.is_batch = is_batch(args, items_of(args))
    with attached():
        serve(lambda item: one(item, args), sys.stdin, out)
