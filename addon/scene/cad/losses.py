"""What a reader leaves out, counted by kind and named, so that it is said in one line each."""

from __future__ import annotations

from ..plain_text import shown_name

MOST_NAMES = 3


class Losses:
    """Counts by kind with the names of those concerned. A kind is a noun with {s} where its plural has an s: 'line{s}'."""

    def __init__(self) -> None:
        self._counts: dict[str, int] = {}
        self._names: dict[str, dict[str, None]] = {}

    def add(self, kind: str, name: str = "", count: int = 1) -> None:
        """Note `count` of a kind; nothing for 0."""
        if count:
            self._counts[kind] = self._counts.get(kind, 0) + count
            names = self._names.setdefault(kind, {})
            if name and len(names) <= MOST_NAMES:
                names[name] = None

    def lines(self, file: str, what: str = "left out") -> list[str]:
        """One sentence for each kind: 'a.obj: 4 lines were left out (frame, axis).'"""
        return [
            f"{file}: {count:,} {kind.format(s='' if count == 1 else 's')} {'was' if count == 1 else 'were'} {what}{self._named(kind)}."
            for kind, count in self._counts.items()
        ]

    def _named(self, kind: str) -> str:
        names = [shown_name(name, 60) for name in self._names[kind]]
        return f" ({', '.join(names[:MOST_NAMES])}{', …' if len(names) > MOST_NAMES else ''})" if names else ""
