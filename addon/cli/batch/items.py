"""From what the user names (files, folders, patterns) to a list of inputs, each with a place of its own for its results."""

from __future__ import annotations

import argparse
import glob
import os
import unicodedata
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from ...scene.cad.formats import SUFFIXES as CAD_SUFFIXES
from ...studies.scratch import PREFIX

SUFFIXES = frozenset((".blend", *CAD_SUFFIXES))
NAMELESS = "input"


@dataclass(frozen=True, slots=True)
class Item:
    """One input. `source` its path (None: the procedural deck), `name` as reports show it, `stem` what all its files' paths start with."""

    source: str | None
    name: str
    stem: Path

    @property
    def is_blend(self) -> bool:
        """Whether it is a file of Blender's own."""
        return self.source is not None and self.source.lower().endswith(".blend")

    @property
    def report_path(self) -> Path:
        """Where its report lies."""
        return self.stem.with_name(f"{self.stem.name}_report.json")


def items_of(args: argparse.Namespace) -> list[Item]:
    """Every input of a command line, in order; the deck last."""
    folder = Path(args.output or ".")
    found = expanded(args.inputs, args.recursive)
    deck = [] if args.deck is None else [Path(f"deck_{args.deck}")]
    stems = unique_stems([*(below for _, below in found), *deck])
    items = [Item(path, path, folder / stem) for (path, _), stem in zip(found, stems, strict=False)]
    return items + [Item(None, f"deck:{args.deck}", folder / stems[-1]) for _ in deck]


def expanded(inputs: list[str], recursive: bool = False) -> list[tuple[str, Path]]:
    """(path, path below the folder it was found in) of every file that `inputs` name, each once, those of a folder or pattern sorted.

    A folder stands for the CAD and .blend files in it, with `recursive` also below it; a pattern (*, ?, [a-z], ** for any folders) for what
    it matches. What names nothing stays as it is, so that opening it says why.
    """
    found: dict[str, Path] = {}
    for text in inputs:
        for path, below in _named(text, recursive) or [(text, Path(Path(text).name or NAMELESS))]:
            found.setdefault(path, below)
    return list(found.items())


def _named(text: str, recursive: bool) -> list[tuple[str, Path]]:
    """What a name stands for beside itself; nothing where it is a file, stands for nothing, or cannot be looked into."""
    path = Path(text)
    try:
        if text and path.is_dir():
            return [(str(p), p.relative_to(path)) for p in _inside(path, recursive)]
        if not text or path.exists() or not glob.has_magic(text):
            return []
        start = Path(*_plain_parts(path))
        matches = (Path(match) for match in sorted(glob.glob(text, recursive=True)))
        return [(str(p), p.relative_to(start)) for p in matches if _is_input(p)]
    except (OSError, ValueError):  # opening it says why
        return []


def _inside(folder: Path, recursive: bool) -> list[Path]:
    """The inputs in a folder, sorted; folders below it that cannot be looked into count as inputs, so that they are missed."""
    found, closed = [], []
    for place, below, names in os.walk(folder, onerror=lambda error: closed.append(Path(error.filename))):
        found += [path for path in (Path(place, name) for name in names) if _is_input(path)]
        below[:] = [name for name in below if recursive and not name.startswith(PREFIX)]
    return sorted([*found, *(path for path in closed if path != folder)])


def _is_input(path: Path) -> bool:
    return path.suffix.lower() in SUFFIXES and os.path.isfile(path) and not path.name.startswith(".")


def _plain_parts(pattern: Path) -> list[str]:
    """The leading folders of a pattern that are not patterns themselves."""
    parts: list[str] = []
    for part in pattern.parts[:-1]:
        if glob.has_magic(part):
            break
        parts.append(part)
    return parts


def unique_stems(below: list[Path]) -> list[Path]:
    """A path without suffix for each, folders kept; with the suffix where two differ only there; numbered where even that is not enough.

    Two that differ in the case or the composition of letters only are one file on Windows and macOS, and so count as the same.
    """
    plain = [_bare(path) for path in below]
    count = Counter(map(_alike, plain))
    stems = [p if count[_alike(p)] == 1 else path.with_name(path.name.replace(".", "_")) for p, path in zip(plain, below, strict=True)]
    wanted_by_others, taken = Counter(map(_alike, stems)), set()
    for i, stem in enumerate(stems):
        number, wanted = 1, stem
        while _alike(wanted) in taken or (number > 1 and _alike(wanted) in wanted_by_others):
            number += 1
            wanted = stem.with_name(f"{stem.name}_{number}")
        taken.add(_alike(wanted))
        stems[i] = wanted
    return stems


def _bare(path: Path) -> Path:
    """Without suffix; a name that is all suffix ('..stl') without its dots."""
    name = path.name.removesuffix(path.suffix)
    return path.with_name(name if name.strip(".") else path.name.strip(".") or NAMELESS)


def _alike(path: Path) -> str:
    """What paths have in common that some disk takes for one."""
    return unicodedata.normalize("NFC", unicodedata.normalize("NFD", path.as_posix()).casefold())
