"""What an option is. The options themselves: `options.py`, `impostor_options.py`. No bpy."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Any, Literal

from ..maths.domains import Interval, OneOf, domain_of
from .groups import Settings

Kind = Literal["choice", "number", "count", "switch", "numbers", "color"]


@dataclass(frozen=True, slots=True)
class Option:
    """One thing the user can set.

    `name` is the property's name, the key in a settings file and, with dashes, the flag of the command line. `targets` are the
    (group, field) pairs of `Settings` it feeds; what they may hold is written there. `soft` the limits of a slider. `items` identifier,
    label and explanation per choice. `unit` is 'm', '' or 'texel'. `start` is where an optional number starts when switched on.
    """

    name: str
    targets: tuple[tuple[str, str], ...]
    kind: Kind
    label: str
    text: str
    soft: tuple[float, float] | None = None
    items: tuple[tuple[str, str, str], ...] = ()
    unit: str = ""
    start: float | tuple[float, ...] | None = None

    @property
    def width(self) -> int:
        """How many numbers a colour has."""
        colour = self.start if self.is_optional else self.default
        return len(colour) if isinstance(colour, tuple) else 0

    @property
    def default(self) -> Any:
        """The dataclass's default (None when the value is optional and not given)."""
        group, field = self.targets[0]
        return getattr(getattr(Settings(), group), field)

    @property
    def low(self) -> float:
        """The least number that the setting may be."""
        return self._domain.low if isinstance(self._domain, Interval) else -inf

    @property
    def high(self) -> float:
        """The greatest."""
        return self._domain.high if isinstance(self._domain, Interval) else inf

    @property
    def _domain(self) -> Interval | OneOf | None:
        return _domain_of(*self.targets[0])

    @property
    def is_optional(self) -> bool:
        """True when leaving it out means 'automatic'."""
        return self.start is not None

    @property
    def flag(self) -> str:
        """Its spelling on the command line."""
        return "--" + self.name.replace("_", "-")


def choice(name: str, group: str, field: str, label: str, text: str, words: tuple[tuple[str, str], ...]) -> Option:
    """An option with the fixed choices of its setting, `words` (label, explanation) in their order."""
    domain = _domain_of(group, field)
    assert isinstance(domain, OneOf), f"{group}.{field} has no fixed choices"
    items = tuple((str(i), word, meaning) for i, (word, meaning) in zip(domain.values, words, strict=True))
    return Option(name, ((group, field),), "choice", label, text, items=items)


def words_of(table: dict[str, Any]) -> tuple[tuple[str, str], ...]:
    """Label and explanation of every row of a table."""
    return tuple((row.label, row.text) for row in table.values())


def _domain_of(group: str, field: str) -> Interval | OneOf | None:
    return domain_of(type(getattr(Settings(), group)), field)
