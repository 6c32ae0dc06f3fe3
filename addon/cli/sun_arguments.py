"""Where on Earth and when: the arguments of the commands that follow the sun. No bpy."""

from __future__ import annotations

import argparse
from datetime import date
from math import radians

from ..maths.sun import Clock, Place, nautical_offset_h
from ..studies.sun.moments import clock_hours
from .argument_types import between


def add_place(group: argparse._ArgumentGroup, ends: tuple[str, str]) -> None:
    """Place, day, hours and clock; `ends` say what the first and the last hour are."""
    group.add_argument(
        "--latitude", type=between(-90, 90), required=True, metavar="DEG", help="degrees north of the equator, negative southwards"
    )
    group.add_argument(
        "--longitude", type=between(-180, 180), required=True, metavar="DEG", help="degrees east of Greenwich, negative westwards"
    )
    group.add_argument("--date", type=date.fromisoformat, required=True, metavar="YYYY-MM-DD", help="the day")
    group.add_argument("--from", dest="start", type=clock_hours, metavar="HH:MM", help=ends[0])
    group.add_argument("--to", dest="end", type=clock_hours, metavar="HH:MM", help=ends[1])
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


def sky(args: argparse.Namespace) -> tuple[Clock, Place]:
    """The clock and the place asked for; raises `SettingsError`."""
    place = Place(radians(args.latitude), radians(args.longitude), radians(args.north_offset))
    return Clock(args.date, nautical_offset_h(place.longitude_rad) if args.utc_offset is None else args.utc_offset), place
