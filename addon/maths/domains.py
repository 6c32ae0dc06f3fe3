"""What the fields of a choice may hold: written once, in the field's metadata, and read by the check and by the options of `settings`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import Field, dataclass, field, fields
from functools import cache
from math import inf
from numbers import Integral, Real
from typing import Any, ClassVar, Protocol

import numpy as np

from ..errors import SettingsError

DOMAIN = "domain"
"""The key of a field's metadata."""


class DataclassInstance(Protocol):
    """Any record of fields."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]


@dataclass(frozen=True, slots=True)
class Interval:
    """Numbers from `low` to `high`, both included; infinity is one of them only where `has_infinity`. `words`: what an error calls it."""

    words: str
    low: float
    high: float = inf
    has_infinity: bool = False

    def complaint(self, value: float) -> str | None:
        """Why a value is refused; None when it is not."""
        if self.low <= value <= self.high and (self.has_infinity or abs(value) < inf):
            return None
        between = f"lie between {_shown(self.low)} and {_shown(self.high)}"
        above = f"be {'' if self.has_infinity else 'finite and '}at least {_shown(self.low)}"
        return f"{self.words} must {above if self.high == inf else between}, not {value}."


@dataclass(frozen=True, slots=True)
class OneOf:
    """One of `values`. `words`: what an error calls it."""

    words: str
    values: tuple

    def complaint(self, value: object) -> str | None:
        """Why a value is refused; None when it is not."""
        if value in self.values:
            return None
        return f"{self.words} is '{value}': choose one of {', '.join(map(str, self.values))}."


def within(default: object, words: str, low: float, high: float = inf, has_infinity: bool = False) -> Any:
    """A dataclass field of numbers from `low` to `high`."""
    return field(default=default, metadata={DOMAIN: Interval(words, low, high, has_infinity)})


def one_of(default: object, words: str, values: tuple) -> Any:
    """A dataclass field that holds one of `values`."""
    return field(default=default, metadata={DOMAIN: OneOf(words, values)})


def same_as(kind: type[DataclassInstance], name: str, **other: object) -> Any:
    """A dataclass field as `name` of another dataclass: its domain and, unless given, its default."""
    one = kind.__dataclass_fields__[name]
    return field(default=other.get("default", one.default), metadata=one.metadata)


def domain_of(kind: type[DataclassInstance], name: str) -> Interval | OneOf | None:
    """What field `name` of a dataclass may hold; None where its type says all."""
    return kind.__dataclass_fields__[name].metadata.get(DOMAIN)


def require(condition: bool, message: str) -> None:
    """Raise `SettingsError(message)` unless the condition holds; write it so that NaN fails."""
    if not condition:
        raise SettingsError(message)


def require_choice(name: str, value: str, allowed: tuple[str, ...]) -> None:
    """Raise `SettingsError` unless `value` is one of `allowed`."""
    complaint = OneOf(name, allowed).complaint(value)
    require(complaint is None, complaint or "")


def require_fields(choice: DataclassInstance) -> None:
    """Raise `SettingsError` unless each field of a dataclass holds what its annotation and its domain say; None passes where it may be."""
    _require_types(choice)
    for one in fields(choice):
        domain, value = one.metadata.get(DOMAIN), getattr(choice, one.name)
        if domain is not None and value is not None:
            complaints = map(domain.complaint, value if isinstance(value, tuple) else (value,))
            complaint = next(filter(None, complaints), None)
            require(complaint is None, complaint or "")


_KINDS: dict[str, tuple[str, Callable[[object], bool]]] = {
    "str": ("text", lambda value: isinstance(value, str)),
    "bool": ("true or false", lambda value: isinstance(value, bool | np.bool_)),
    "int": ("a whole number", lambda value: isinstance(value, Integral) and not isinstance(value, bool)),
    "float": ("a number", lambda value: isinstance(value, Real) and not isinstance(value, bool)),
}


def _require_types(choice: DataclassInstance) -> None:
    """Text, switches, numbers and tuples of them are what they are annotated as: a settings file may put anything there."""
    for name, is_optional, kind, count in _annotated(type(choice)):
        value = getattr(choice, name)
        if value is None and is_optional:
            continue
        words, fits = _KINDS[kind]
        if count is None:
            require(fits(value), f"{name} is {value!r}, not {words}.")
        else:
            many = "numbers" if count is ... else f"{count} numbers"
            require(isinstance(value, tuple) and count in (..., len(value)) and all(map(fits, value)), f"{name} is {value!r}, not {many}.")


@cache
def _annotated(kind: type[DataclassInstance]) -> tuple[tuple[str, bool, str, object], ...]:
    """(name, may be None, type, how many of a tuple) of the fields of plain types: '...' any number, None no tuple."""
    found = []
    for one in fields(kind):
        text = str(one.type).removesuffix(" | None")
        inside = text.removeprefix("tuple[").removesuffix("]").split(", ")
        count = None if text == inside[0] else ... if inside[-1] == "..." else len(inside)
        found.append((one.name, text != one.type, inside[0], count))
    return tuple(one for one in found if one[2] in _KINDS)


def _shown(limit: float) -> str:
    """A limit as a person writes it: a whole number with all its digits."""
    return str(limit) if isinstance(limit, int) else f"{limit:g}"
