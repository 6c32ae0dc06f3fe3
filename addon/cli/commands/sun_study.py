"""`sun-study`: the picture of each input at several times of a day, on one sheet; each rendered through Blender as any other picture."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np

from ...images.whole import check_picture
from ...scene.asked_view import LightMaker
from ...studies.outputs import write_json, written
from ...studies.run import Outcome
from ...studies.sun.moments import DEFAULT_STEPS, Moment, moments
from ..argument_types import positive
from ..command import Command
from ..shared_arguments import SECTIONS, add_batch, add_inputs, add_method, add_reporting, add_view
from ..sun_arguments import add_place, sky

if TYPE_CHECKING:
    import bpy

    from ...blender.render_wish import RenderWish


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """A sky, and everything about a picture but its light."""
    add_sun(parser)
    add_inputs(parser)
    add_reporting(parser)
    add_view(parser, has_light_direction=False)
    add_method(parser, *SECTIONS)
    add_batch(parser)


def add_sun(parser: argparse.ArgumentParser) -> None:
    """Place, day and hours of a sun study."""
    group = parser.add_argument_group("sun")
    add_place(group, ("first picture (default: sunrise)", "last picture (default: sunset)"))
    group.add_argument(
        "--steps", type=positive, default=DEFAULT_STEPS, metavar="N", help=f"pictures, evenly spaced (default {DEFAULT_STEPS})"
    )
    group.add_argument("--columns", type=positive, metavar="N", help="pictures per row; 1 row with N = steps (default: about square)")
    group.add_argument("--pictures", action="store_true", help="also every picture by itself")


def sun_study(scene: bpy.types.Scene, wish: RenderWish, stem: Path, args: argparse.Namespace) -> tuple[dict[str, object], str]:
    """Render every moment, write the sheet and the report: that of the highest sun, and the moments with the share of what is seen lit."""
    from ..batch.sheet import read_picture, write_sheet

    clock, place = sky(args)
    day = moments(clock, place, args.start, args.end, args.steps)
    pictures, rows, reports = [], [], []
    with _folder(stem, args.pictures) as start:
        for i, now in enumerate(day):
            path = start.with_name(f"{start.name}_sun_{i + 1:03d}_{now.time.replace(':', '')}.png")
            outcome = _render(scene, wish, now, path)
            pictures.append(read_picture(path))
            rows.append({**now.as_dict(), "lit_share": lit_share(outcome, now)})
            reports.append(outcome.report)
    sheet = stem.with_name(f"{stem.name}_sun_study.png")
    write_sheet(sheet, pictures, [now.caption for now in day], args.columns)
    highest = max(range(len(day)), key=lambda i: day[i].elevation_rad)
    study = {
        "latitude": args.latitude,
        "longitude": args.longitude,
        "date": args.date.isoformat(),
        "utc_offset": clock.utc_offset_h,
        "north_offset": args.north_offset,
        "moments": rows,
    }
    report = {**reports[highest], "sun_study": study}
    write_json(stem.with_name(f"{stem.name}_report.json"), report)
    return report, f"{len(day)} pictures, {day[0].time} to {day[-1].time} (UTC{clock.utc_offset_h:+g}), wrote {sheet}"


@contextmanager
def _folder(stem: Path, is_kept: bool) -> Iterator[Path]:
    """What the single pictures' paths start with: beside the sheet, or in a folder that goes away."""
    if is_kept:
        yield stem
        return
    with TemporaryDirectory(prefix="cad-shadow-") as folder:
        yield Path(folder, stem.name)


def _render(scene: bpy.types.Scene, wish: RenderWish, now: Moment, path: Path) -> Outcome:
    from ...blender.rendering import render

    asked = replace(wish, light=_sun(wish.light, now), settings=now.settings(wish.settings))
    with written(path, check_picture) as temporary:
        return render(scene, asked, temporary)


def _sun(maker: LightMaker | None, now: Moment) -> LightMaker:
    """The moment's sun in the colour of the light asked for, else of the scene's."""
    from ...blender.snapshot import choose_light

    return lambda scene, camera: now.light(maker(scene, camera) if maker else choose_light(scene.lights))


def lit_share(outcome: Outcome, now: Moment) -> float | None:
    """How much of the surfaces in view the sun reaches, 0…1; None when nothing is in view."""
    passes = outcome.frame.passes
    seen = np.isfinite(passes["depth"])
    if not seen.any():
        return None
    return float(passes["shadow"][seen].mean()) if now.is_up else 0.0


ROW = Command(
    "sun-study",
    place=40,
    help="the shadows of a day",
    description="Render each input under the sun of several times of a day, on one sheet.",
    add_arguments=add_arguments,
    work=sun_study,
)
