"""The commands that need a scene: each input is opened, rendered through Blender, written, reported. One input's failure stops no other."""

from __future__ import annotations

import argparse
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import bpy

from .. import register, unregister
from ..blender import presets
from ..blender.inputs import open_deck, open_input
from ..blender.properties import settings_from
from ..blender.rendering import Request, render
from ..errors import UserError
from ..images.png import encode_png
from ..images.whole import check_picture
from ..scene.asked_view import Lens, camera_maker, light_maker
from ..settings.groups import PASSES, Settings
from ..studies import stopping
from ..studies.light_view import SIZE as LIGHT_VIEW_SIZE
from ..studies.light_view import light_picture
from ..studies.outputs import recorded, write_bytes, write_json, write_npz, write_pass, written
from ..studies.report import failed_report
from ..studies.run import Outcome, renderer
from ..studies.terminal import complain
from ..studies.truth.against import against_truth, sentence
from ..studies.truth.compare import COMPARED_PASSES
from ..studies.user_files import Key, Noted, run_of_inputs
from .batch.items import Item
from .batch.stamp import companions_of, request_digest, stamp_of, stamped
from .batch.workers import Answer
from .commands.advise import advise_command
from .commands.bench import Course, run, text_table
from .commands.impostors import impostor_command, path_command
from .commands.sun_study import sun_study_command
from .main import chosen_settings, idle_options


def answers_here(items: list[Item], args: argparse.Namespace) -> Iterator[tuple[Item, Answer]]:
    """Every item with its report and a line that sums it up, in order, made in this process, until it is asked to stop."""
    with registered():
        for item in items:
            yield item, one(item, args)
            stopping.check()


@contextmanager
def registered() -> Iterator[None]:
    """The add-on attached to Blender while this lasts, unless it is already enabled."""
    if hasattr(bpy.types.Scene, "cad_shadow"):
        yield
        return
    register()
    try:
        yield
    finally:
        unregister()


def one(item: Item, args: argparse.Namespace) -> Answer:
    """The report of one input, and a line that sums it up; a failure is a report too."""
    settings: list[Settings] = []
    try:
        with run_of_inputs() as noted, recorded(item.name) as files:
            return _made(item, args, settings, noted, files)
    except KeyboardInterrupt:
        message = stopping.STOPPED
    except UserError as error:
        message = stopping.STOPPED if stopping.is_asked() else str(error)
    except MemoryError:
        message = "It needs more memory than there is: choose a smaller picture, or split the model."
    except OSError as error:
        message = f"{error.filename or item.name} cannot be read or written ({error.strerror or error})."
    except Exception as error:  # a defect of ours must not cost the inputs that follow
        complain(traceback.format_exc().rstrip())
        message = f"{type(error).__name__}: {error}: please report this."
    return failed_report(item.name, settings[0] if settings else None, message), ""


def _made(item: Item, args: argparse.Namespace, settings: list[Settings], noted: dict[Key, Noted], files: list[Path]) -> Answer:
    """Open, render, write, report; `settings` gets those that are used as soon as they are known."""
    stamp = _stamp(item, args)
    scene, warnings = open_deck(args.deck) if item.source is None else open_input(item.source, args.units, args.up_axis)
    stopping.check()
    if args.preset is not None:
        presets.apply(scene, args.preset)
    settings.append(chosen_settings(settings_from(scene.cad_shadow), args))
    if args.crease_angle is not None:
        scene.cad_shadow.crease_angle = args.crease_angle
    report, line = COMMANDS[args.command](scene, request_for(item.name, args, settings[0], warnings), item.stem, args)
    if stamp is None:
        return report, line
    return _stamped(report, {**stamp, "companions": companions_of(item, noted)}, files, item, args), line


def _stamp(item: Item, args: argparse.Namespace) -> dict[str, object] | None:
    """What a batch's report notes of what it is made from; None outside a batch, and where there is no such input."""
    try:
        is_stamped = args.is_batch and (item.source is None or Path(item.source).is_file())
        return stamp_of(item, request_digest(args)) if is_stamped else None
    except OSError:  # opening it says why
        return None


def _stamped(
    report: dict[str, object], stamp: dict[str, object], files: list[Path], item: Item, args: argparse.Namespace
) -> dict[str, object]:
    """In a batch the report, in its file too, also says what it was made from and what was written."""
    folder, own = Path(args.output or "."), item.report_path.absolute()
    inside = [path for path in dict.fromkeys(files) if path.is_relative_to(folder.absolute()) and path != own]
    report = stamped(report, stamp, inside, folder)
    if own in files:
        write_json(item.report_path, report)
    return report


def request_for(name: str, args: argparse.Namespace, settings: Settings, warnings: tuple[str, ...]) -> Request:
    """What the engine is asked for: view and light as the command line says, else as the scene says."""
    half_fov = None if args.fov_y is None else args.fov_y / 2.0
    camera = camera_maker(args.camera, args.view, args.eye, args.target, args.up, half_fov)
    light = light_maker(args.light, args.light_direction)
    complaints = (*warnings, *idle_options(settings, args))
    lens, is_drawing = Lens(half_fov, args.near, args.far), args.view is not None
    return Request(name, (), camera, light, settings, lens, args.size, complaints, is_drawing)


def preview(scene: bpy.types.Scene, request: Request, stem: Path, args: argparse.Namespace) -> tuple[dict[str, object], str]:
    """Render and write the passes and the report."""
    wanted = args.passes or (tuple(p for p in PASSES if p != "texel") if args.format == "npz" else ("combined",))
    request.passes = wanted
    written_files = []
    if args.format != "npz" and "combined" in wanted:
        path = stem.with_name(f"{stem.name}_combined.{args.format}")
        with written(path, check_picture) as temporary:
            outcome = render(scene, request, temporary)
        written_files.append(path.name)
    else:
        outcome = render(scene, request)
    written_files += write_data(outcome, stem, wanted, args.format)
    if args.light_view:
        path = stem.with_name(f"{stem.name}_light_view.png")
        write_bytes(path, encode_png(light_picture(outcome.job, outcome.frame.plan, LIGHT_VIEW_SIZE)))
        written_files.append(path.name)
    write_json(stem.with_name(f"{stem.name}_report.json"), outcome.report)
    return outcome.report, f"{outcome.report['timing_ms']['total'] / 1e3:.2f} s, wrote {', '.join(written_files)} to {stem.parent}"


def write_data(outcome: Outcome, stem: Path, wanted: tuple[str, ...], kind: str) -> list[str]:
    """Write what is not the combined picture; gives the files' names."""
    if kind == "npz":
        path = stem.with_name(f"{stem.name}.npz")
        write_npz(path, outcome, wanted)
        return [path.name]
    paths = {name: stem.with_name(f"{stem.name}_{name}.{kind}") for name in wanted if name != "combined"}
    for name, path in paths.items():
        write_pass(path, name, outcome)
    return [path.name for path in paths.values()]


def analyse(scene: bpy.types.Scene, request: Request, stem: Path, args: argparse.Namespace) -> tuple[dict[str, object], str]:
    """Render without a picture; the report is written where --output or --report say."""
    outcome = render(scene, request)
    if args.output:
        write_json(stem.with_name(f"{stem.name}_report.json"), outcome.report)
    return outcome.report, summary(outcome.report)


def summary(report: dict[str, object]) -> str:
    """The report in a line."""
    measured = report["measured"]
    if not measured or measured["m_max"] is None:
        return "nothing measured: no lit surface in view"
    share = 100.0 * measured["share_above_1"]
    return (
        f"m median {measured['m_median']:.3g}, 95 % {measured['m_p95']:.3g}, max {measured['m_max']:.3g}; {share:.1f} % of pixels above 1"
    )


def compare_command(scene: bpy.types.Scene, request: Request, stem: Path, args: argparse.Namespace) -> tuple[dict[str, object], str]:
    """Render, trace rays through the same pixel centres, count the differences."""
    request.passes = COMPARED_PASSES
    outcome = render(scene, request)
    difference = against_truth(outcome)
    write_bytes(stem.with_name(f"{stem.name}_difference.png"), encode_png(difference))
    write_json(stem.with_name(f"{stem.name}_report.json"), outcome.report)
    return outcome.report, sentence(outcome.report["truth"])


def bench_command(scene: bpy.types.Scene, request: Request, stem: Path, args: argparse.Namespace) -> tuple[dict[str, object], str]:
    """Time frames of a moving camera; one camera sample a pixel unless asked otherwise, as in a live view."""
    if "option_samples" not in args:
        request.settings = request.settings.replaced(shading={"samples": 1})
    outcome = render(scene, request)
    job = outcome.job
    result = run(
        Course(job.scene, job.camera, job.light, job.settings, job.size, args.frames),
        scene,
        args.rivals,
        renderer(),
        lambda line: None if args.quiet else complain(line),
    )
    report = {**outcome.report, "bench": result}
    if args.output:
        write_json(stem.with_name(f"{stem.name}_bench.json"), report)
    return report, text_table(result)


COMMANDS = {
    "advise": advise_command, "bench": bench_command, "preview": preview, "analyse": analyse, "compare": compare_command,
    "sun-study": sun_study_command, "impostor": impostor_command, "impostor-path": path_command,
}
