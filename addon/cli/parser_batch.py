"""The command line's words for batches, presets and sun studies; the others are in `parser.py`. No bpy."""

from __future__ import annotations

import argparse
from datetime import date

from ..studies.sun.moments import DEFAULT_STEPS, clock_hours
from .argument_types import between

NO_BATCH = {"recursive": False, "resume": False, "jobs": 1, "contact_sheet": False, "worker": False}


def positive(text: str) -> int:
    """A whole number from 1."""
    if int(text) < 1:
        raise ValueError(text)
    return int(text)


positive.__name__ = "whole number from 1"


def add_batch(parser: argparse.ArgumentParser, makes_pictures: bool = True) -> None:
    """Many inputs in one run."""
    parser.set_defaults(**NO_BATCH)
    group = parser.add_argument_group("batch")
    group.add_argument("--recursive", action="store_true", help="folders stand for all CAD and .blend files below them, not only in them")
    group.add_argument(
        "--resume", action="store_true", help="skip inputs that an earlier run did with these options, unchanged since, results still there"
    )
    group.add_argument(
        "--jobs", type=positive, metavar="N", help="work on N inputs at once, in processes of their own; a crash costs only its input"
    )
    if makes_pictures:
        group.add_argument("--contact-sheet", action="store_true", help="also contact_sheet.png: all inputs' pictures, small, side by side")
    group.add_argument("--worker", action="store_true", help=argparse.SUPPRESS)


def add_preset(parser: argparse.ArgumentParser) -> None:
    """A preset below all other options of the method."""
    parser.add_argument_group("preset").add_argument(
        "--preset",
        metavar="NAME",
        help="start from a preset, not from the scene's settings: fast, balanced, sharp, oil-platform, single-part, reference, or yours",
    )


def add_sun(parser: argparse.ArgumentParser) -> None:
    """Place, day and hours of a sun study."""
    group = parser.add_argument_group("sun")
    group.add_argument(
        "--latitude", type=between(-90, 90), required=True, metavar="DEG", help="degrees north of the equator, negative southwards"
    )
    group.add_argument(
        "--longitude", type=between(-180, 180), required=True, metavar="DEG", help="degrees east of Greenwich, negative westwards"
    )
    group.add_argument("--date", type=date.fromisoformat, required=True, metavar="YYYY-MM-DD", help="the day")
    group.add_argument("--from", dest="start", type=clock_hours, metavar="HH:MM", help="first picture (default: sunrise)")
    group.add_argument("--to", dest="end", type=clock_hours, metavar="HH:MM", help="last picture (default: sunset)")
    group.add_argument(
        "--steps", type=positive, default=DEFAULT_STEPS, metavar="N", help=f"pictures, evenly spaced (default {DEFAULT_STEPS})"
    )
    group.add_argument(
        "--utc-offset",
        type=between(-24, 24),
        metavar="HOURS",
        help="hours the clock is ahead of universal time (default: the longitude's time zone, without summer time)",
    )
    group.add_argument(
        "--north-offset",
        type=between(-360, 360),
        default=0.0,
        metavar="DEG",
        help="from +Y to north, clockwise seen from above (default 0)",
    )
    group.add_argument("--columns", type=positive, metavar="N", help="pictures per row; 1 row with N = steps (default: about square)")
    group.add_argument("--pictures", action="store_true", help="also every picture by itself")
