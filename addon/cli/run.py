"""The commands that need a scene: each input is opened, rendered through Blender, written, reported. One input's failure stops no other."""

from __future__ import annotations

import argparse
import traceback
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path

from ..blender import presets
from ..blender.inputs import activated, open_deck, open_input
from ..blender.properties import settings_from
from ..blender.render_wish import RenderWish
from ..errors import UserError
from ..scene.asked_view import Lens, camera_maker, light_maker, names_of
from ..scene.reading import limits
from ..scene.user_files import Key, Noted, run_of_inputs
from ..settings.groups import Settings
from ..studies import stopping
from ..studies.outputs import recorded, write_json
from ..studies.report import failed_report
from ..studies.terminal import complain
from .batch.items import Item
from .batch.stamp import companions_of, request_digest, stamp_of, stamped
from .batch.workers import Answer
from .commands import COMMANDS
from .settings_file import chosen_settings, idle_options
from .shared_arguments import limits_of


def answers_here(items: list[Item], args: argparse.Namespace) -> Iterator[tuple[Item, Answer]]:
    """Every item with its report and a line that sums it up, in order, made in this process, until it is asked to stop."""
    for item in items:
        yield item, one(item, args)
        stopping.check()


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
    limits.choose(limits_of(args))
    with limits.held_to(limits.chosen()) if args.worker and item.is_blend else nullcontext():
        scene, warnings = open_deck(args.deck) if item.source is None else open_input(item.source, args.units, args.up_axis)
    scene = activated(scene, args.scene)
    stopping.check()
    if args.preset is not None:
        presets.apply(scene, args.preset)
    settings.append(chosen_settings(settings_from(scene.cad_shadow), args))
    if args.crease_angle is not None:
        scene.cad_shadow.crease_angle = args.crease_angle
    report, line = COMMANDS[args.command].work(scene, wish_for(item.name, args, settings[0], warnings), item.stem, args)
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


def wish_for(name: str, args: argparse.Namespace, settings: Settings, warnings: tuple[str, ...]) -> RenderWish:
    """What the engine is asked for: view and light as the command line says, else as the scene says."""
    half_fov = None if args.fov_y is None else args.fov_y / 2.0
    camera = camera_maker(args.camera, args.view, args.eye, args.target, args.up, half_fov, args.ortho)
    light = light_maker(args.light, args.light_direction)
    complaints = (*warnings, *idle_options(settings, args))
    lens, is_drawing = Lens(None if args.ortho else half_fov, args.near, args.far), args.view is not None
    moment = {"frame": args.frame, "view_layer": args.view_layer, "more_lights": names_of(args.light)[1:]}
    return RenderWish(name, (), camera, light, settings, lens, args.size, complaints, is_drawing, **moment)
