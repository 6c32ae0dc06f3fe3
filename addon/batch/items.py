"""From what the user names (files, folders, patterns) to a list of inputs, each with a place of its own for its results."""

from __future__ import annotations

import argparse
import glob
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

SUFFIXES = frozenset((".blend", ".step", ".stp", ".stl", ".obj", ".ply", ".off", ".3mf", ".glb", ".gltf"))


@dataclass(frozen=True, slots=True)
class Item:
    """One input. `source` its path (None: the procedural deck), `name` as reports show it, `stem` what all its files' paths start with."""

    source: str | None
    name: str
    stem: Path

    @property
    def report_path(self) -> Path:
        """Where its report lies."""
        return self.stem.with_name(f"{self.stem.name}_report.json")


def items_of(args: argparse.Namespace) -> list[Item]:
    """Every input of a command line, in order; the deck last."""
    folder = Path(args.output or ".")
    found = expanded(args.inputs, args.recursive)
    stems = unique_stems([below for _, below in found])
    items = [Item(path, path, folder / stem) for (path, _), stem in zip(found, stems, strict=True)]
    if args.deck is not None:
        items.append(Item(None, f"deck:{args.deck}", folder / f"deck_{args.deck}"))
    return items


def expanded(inputs: list[str], recursive: bool = False) -> list[tuple[str, Path]]:
    """(path, path below the folder it was found in) of every file that `inputs` name, each once, those of a folder or pattern sorted.

    A folder stands for the CAD and .blend files in it, with `recursive` also below it; a pattern (*, ?, [a-z], ** for any folders) for what
    it matches. What names nothing stays as it is, so that opening it says why.
    """
    found: dict[str, Path] = {}
    for text in inputs:
        for path, below in _named(text, recursive) or [(text, Path(Path(text).name))]:
            found.setdefault(path, below)
    return list(found.items())


def _named(text: str, recursive: bool) -> list[tuple[str, Path]]:
    path = Path(text)
    if path.is_dir():
        inside = path.rglob("*") if recursive else path.iterdir()
        return [(str(p), p.relative_to(path)) for p in sorted(inside) if _is_input(p)]
    if path.exists() or not glob.has_magic(text):
        return []
    start = Path(*_plain_parts(path))
    matches = (Path(match) for match in sorted(glob.glob(text, recursive=True)))
    return [(str(p), p.relative_to(start)) for p in matches if _is_input(p)]


def _is_input(path: Path) -> bool:
    return path.suffix.lower() in SUFFIXES and path.is_file() and not path.name.startswith(".")


def _plain_parts(pattern: Path) -> list[str]:
    """The leading folders of a pattern that are not patterns themselves."""
    parts: list[str] = []
    for part in pattern.parts[:-1]:
        if glob.has_magic(part):
            break
        parts.append(part)
    return parts


def unique_stems(below: list[Path]) -> list[Path]:
    """A path without suffix for each, folders kept; with the suffix where two differ only there; numbered where even that is not enough."""
    plain = [path.with_suffix("") for path in below]
    count = Counter(plain)
    stems = [p if count[p] == 1 else path.with_name(path.name.replace(".", "_")) for p, path in zip(plain, below, strict=True)]
    taken: set[Path] = set()
    for i, stem in enumerate(stems):
        number, wanted = 1, stem
        while wanted in taken or (number > 1 and wanted in stems):
            number += 1
            wanted = stem.with_name(f"{stem.name}_{number}")
        taken.add(wanted)
        stems[i] = wanted
    return stems
