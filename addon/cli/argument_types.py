"""What the command line takes for a number, a size, a colour: parsers that refuse what cannot be meant. No bpy; nothing is done here."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable
from math import inf, isfinite, radians

from ..errors import UserError
from ..pipeline.job import MAX_PIXELS
from ..settings.option import Option
from ..settings.options import FROM_SCENE

TINY = 5e-324
LEAST_PIXELS = 4
"""Blender renders no picture that is smaller on a side."""


def vector(text: str) -> tuple[float, float, float]:
    """X,Y,Z."""
    values = tuple(float(part) for part in text.split(","))
    if len(values) != 3 or not all(map(isfinite, values)):
        raise ValueError(text)
    return values


def direction(text: str) -> tuple[float, float, float]:
    """X,Y,Z, not all 0."""
    values = vector(text)
    if not any(values):
        raise argparse.ArgumentTypeError(f"{text} is no direction: give X,Y,Z, for example -1,-1,2")
    return values


def size(text: str) -> tuple[int, int]:
    """WxH in pixels."""
    match = re.fullmatch(r"(\d+)[x×X](\d+)", text)
    if not match or not all(int(n) for n in match.groups()):
        raise ValueError(text)
    return int(match[1]), int(match[2])


def picture_size(text: str) -> tuple[int, int]:
    """WxH in pixels of a picture that can be made."""
    values = size(text)
    if not all(LEAST_PIXELS <= n <= MAX_PIXELS for n in values):
        raise argparse.ArgumentTypeError(f"{text}: each side must lie between {LEAST_PIXELS} and {MAX_PIXELS} pixels")
    return values


picture_size.__name__ = "size"


def positive(text: str) -> int:
    """A whole number from 1."""
    if int(text) < 1:
        raise ValueError(text)
    return int(text)


positive.__name__ = "whole number from 1"


def degrees_between(low: float, high: float) -> Callable[[str], float]:
    """A parser of degrees in the open interval, to radians."""

    def angle(text: str) -> float:
        if not low < float(text) < high:
            raise argparse.ArgumentTypeError(f"{text} does not lie between {low:g} and {high:g} degrees")
        return radians(float(text))

    return angle


def between(low: float, high: float, is_whole: bool = False) -> Callable[[str], float]:
    """A parser of finite numbers in the closed interval."""

    def number(text: str) -> float:
        value = int(text) if is_whole else float(text)
        if not (low <= value <= high and isfinite(value)):
            raise argparse.ArgumentTypeError(f"{text} {_wanted(low, high)}")
        return value

    number.__name__ = "whole number" if is_whole else "number"
    return number


def _wanted(low: float, high: float) -> str:
    if low == TINY:
        return "is not a number above 0"
    if high < inf:
        return f"does not lie between {low:g} and {high:g}"
    return f"is not a number from {low:g} on" if low > -inf else "is not a finite number"


finite = between(-inf, inf)
positive_number = between(TINY, inf)


def checked_by(check: Callable[[str], object], name: str) -> Callable[[str], str]:
    """A parser of words that `check` knows; its `UserError` is the complaint."""

    def word(text: str) -> str:
        try:
            check(text)
        except UserError as error:
            raise argparse.ArgumentTypeError(str(error)) from None
        return text

    word.__name__ = name
    return word


def pass_list(known: tuple[str, ...]) -> Callable[[str], tuple[str, ...]]:
    """A parser of comma-separated passes."""

    def passes(text: str) -> tuple[str, ...]:
        names = tuple(name.strip() for name in text.split(","))
        unknown = [name for name in names if name not in known]
        if unknown:
            raise argparse.ArgumentTypeError(f"unknown pass '{unknown[0]}': choose from {','.join(known)}")
        return tuple(dict.fromkeys(names))

    return passes


def numbers_of(option: Option) -> Callable[[str], tuple[float, ...]]:
    """A parser of the option's numbers, as many as it has (a list of any length where it takes one), each in its range."""
    one = between(option.low, option.high)

    def numbers(text: str) -> tuple[float, ...] | None:
        if option.kind == "color" and option.is_optional and text == FROM_SCENE:
            return None
        values = tuple(one(part) for part in text.split(","))
        if option.kind == "color" and len(values) != option.width:
            raise argparse.ArgumentTypeError(f"{text} has {len(values)} numbers, not {option.width}")
        return values

    return numbers


def number_of(option: Option) -> Callable[[str], float]:
    """A parser of the option's number that checks its range. How large a map may be is for the machine to say."""
    return between(option.low, inf if option.name == "map_size" else option.high, option.kind == "count")


def ground_word(text: str) -> str | float:
    """`auto`, `off`, or a height in metres."""
    if text in ("auto", "off"):
        return text
    try:
        return finite(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is neither auto, off, nor a height in metres") from None


def section_plane(text: str) -> tuple[float, ...]:
    """Six numbers: a point of a plane and its normal."""
    values = tuple(finite(part) for part in text.split(","))
    if len(values) != 6:
        raise argparse.ArgumentTypeError(f"{text} has {len(values)} numbers, not 6: X,Y,Z of a point and X,Y,Z of the normal")
    if not any(values[3:]):
        raise argparse.ArgumentTypeError(f"{text}: the normal is zero")
    return values
