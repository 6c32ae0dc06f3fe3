"""Damaged files of every format, read as Blender reads them, in a process of its own within limits; for docs/reliability.md:

    python -m benchmarks.attack [--each 1200] [--seed 1]     rows to benchmarks/results/attack.json; 20 minutes
    python -m benchmarks.attack --folder HOSTILE             what becomes of every file there
    python -m benchmarks.attack --write                      docs/reliability.md anew from the rows that are there

A file is a small valid one of `benchmarks.attack_seeds`, damaged one to eight times: bytes changed, cut off, doubled, lines and numbers put
in each other's places. Whatever comes, the process that asks must live, and get a sound model or one line that says what to do.
"""

from __future__ import annotations

import argparse
import json
import random
import re
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from addon.errors import CadFileError
from addon.scene.cad import SUFFIXES
from addon.scene.cad_model import CadModel
from addon.scene.reading.apart import Reading
from addon.scene.reading.limits import Limits
from benchmarks.attack_seeds import Seed, seeds

RESULTS = Path(__file__).resolve().parent / "results" / "attack.json"
LIMITS = Limits(seconds=20, memory_mib=2048)
NUMBERS = (
    b"0",
    b"-1",
    b"1",
    b"2147483647",
    b"4294967296",
    b"-2147483649",
    b"1e308",
    b"-1e308",
    b"1e-320",
    b"nan",
    b"inf",
    b"999999999999",
    b"",
)
WORDS = (
    b"",
    b"\0",
    b"\xff",
    b"\xed\xa0\x80",
    b"'",
    b'"',
    b"(",
    b")",
    b"{",
    b"}",
    b"[",
    b"]",
    b"$",
    b"*",
    b"\n",
    b"\r",
    b"\x1b[31m",
    b"../",
    b"%00",
)
KINDS = ("read", "refused", "crash contained", "hang contained", "memory contained", "unsound model", "not one line", "traceback")
BAD = KINDS[5:]


def damaged(data: bytes, rng: random.Random) -> bytes:
    """The bytes after one piece of damage."""
    return rng.choice((_bytes_changed, _number_changed, _word_put, _cut, _lines_moved, _piece_moved))(data, rng)


def _bytes_changed(data: bytes, rng: random.Random) -> bytes:
    out = bytearray(data)
    for _ in range(rng.randint(1, 4)):
        if out:
            out[rng.randrange(len(out))] = rng.choice((rng.randrange(256), 0, 255, out[rng.randrange(len(out))] ^ (1 << rng.randrange(8))))
    return bytes(out)


def _number_changed(data: bytes, rng: random.Random) -> bytes:
    found = list(re.finditer(rb"-?\d+(\.\d*)?([eE][-+]?\d+)?", data))
    if not found:
        return _bytes_changed(data, rng)
    one = rng.choice(found)
    return data[: one.start()] + rng.choice((*NUMBERS, rng.choice(found)[0])) + data[one.end() :]


def _word_put(data: bytes, rng: random.Random) -> bytes:
    at = rng.randint(0, len(data))
    return data[:at] + rng.choice(WORDS) * rng.choice((1, 1, 1, 100)) + data[at + rng.choice((0, 1, 4)) :]


def _cut(data: bytes, rng: random.Random) -> bytes:
    return data[: rng.randint(0, len(data))]


def _lines_moved(data: bytes, rng: random.Random) -> bytes:
    lines = data.split(b"\n")
    a, b = rng.randrange(len(lines)), rng.randrange(len(lines))
    how = rng.randrange(3)
    if how == 0:
        lines[a], lines[b] = lines[b], lines[a]
    elif how == 1:
        del lines[a]
    else:
        lines[a:a] = [lines[b]] * rng.choice((1, 1, 50))
    return b"\n".join(lines)


def _piece_moved(data: bytes, rng: random.Random) -> bytes:
    a, length, b = rng.randint(0, len(data)), rng.randint(1, 64), rng.randint(0, len(data))
    piece = data[a : a + length]
    return data[:b] + piece + data[b + rng.choice((0, length)) :]


def mutants(seed: Seed, count: int, name: str) -> Iterator[bytes]:
    """So many damaged files, the same ones for a name on every machine. Of what is packed three in four are damaged within."""
    for number in range(count):
        rng = random.Random(f"{name} {number}")
        is_within = seed.inner is not None and rng.random() < 0.75
        result = seed.inner if is_within else seed.data
        for _ in range(rng.choice((1, 1, 2, 3, 8))):
            result = damaged(result, rng)
        yield seed.packed(result) if is_within else result


def outcome(path: Path) -> tuple[str, str]:
    """One of `KINDS`, and what was said."""
    try:
        model = Reading(path, limits=LIMITS).result(LIMITS.seconds + 60.0)
    except CadFileError as error:
        return _kind_of(str(error)), str(error)
    except BaseException as error:  # what must not come
        return "traceback", f"{type(error).__name__}: {error}"
    fault = unsound(model)
    return ("unsound model", fault) if fault else ("read", "; ".join(model.warnings))


def _kind_of(line: str) -> str:
    if not line.isprintable() or len(line) > 1500:
        return "not one line"
    for words, kind in (("ended unexpectedly", KINDS[2]), ("was not read within", KINDS[3]), ("MiB of memory that reading", KINDS[4])):
        if words in line:
            return kind
    return "refused"


def unsound(model: CadModel) -> str:
    """What Blender could not take of a model; '' for a sound one."""
    for mesh in model.meshes:
        count, slots = len(mesh.positions), max(len(mesh.materials), 1)
        if not np.isfinite(mesh.positions).all():
            return "a position that is not finite"
        if len(mesh.triangles) and not 0 <= mesh.triangles.min() <= mesh.triangles.max() < count:
            return "a corner that is no vertex"
        if mesh.normals is not None and not (mesh.normals.shape == (count, 3) and np.isfinite(mesh.normals).all()):
            return "a normal that is not finite"
        if (
            mesh.triangle_slots is not None
            and len(mesh.triangles)
            and not 0 <= mesh.triangle_slots.min() <= mesh.triangle_slots.max() < slots
        ):
            return "a triangle of no material"
        if any(not 0 <= index < len(model.materials) for index in mesh.materials):
            return "a material that is none"
    for number, part in enumerate(model.parts):
        if not (part.parent < number and part.mesh < len(model.meshes) and np.isfinite(part.parent_from_part).all()):
            return "a part without a place"
    return next((f"{line!r} is no line" for line in model.warnings if not line.isprintable()), "")


def attack(suffix: str, source: Seed, count: int, seed: int, folder: Path, say: Callable[[str], None] = print) -> dict[str, object]:
    """A row: what became of so many damaged files of a format."""
    kinds, worst, since = Counter(), 0.0, time.monotonic()
    for number, mutant in enumerate(mutants(source, count, f"{suffix} {seed}")):
        path = folder / f"attacked{suffix}"
        path.write_bytes(mutant)
        began = time.monotonic()
        kind, words = outcome(path)
        worst = max(worst, time.monotonic() - began)
        kinds[kind] += 1
        if kind in BAD:
            say(f"{suffix} {seed} {number}: {kind}: {words}")
            path.rename(folder / f"{kind.replace(' ', '_')}_{number}{suffix}")
    return {"format": suffix, "files": count, "slowest_s": round(worst, 1), "all_s": round(time.monotonic() - since), **kinds}


def table(rows: list[dict[str, object]]) -> str:
    """What became of the files, as docs/reliability.md has it."""
    total = {"format": "all", **{key: sum(row.get(key, 0) for row in rows) for key in ("files", *KINDS)}}
    total["slowest_s"] = max(row["slowest_s"] for row in rows)
    heads = ("format", "files", *KINDS, "slowest_s")
    lines = ["| " + " | ".join(heads).replace("slowest_s", "slowest, s") + " |", "|" + "---|" * len(heads)]
    lines += [
        "| " + " | ".join(f"{row.get(head, 0):,}" if head not in ("format",) else row[head] for head in heads) + " |"
        for row in (*rows, total)
    ]
    return "\n".join(lines)


def main() -> None:
    """Attack, or write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--each", type=int, default=1200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", help="one suffix")
    parser.add_argument("--folder", type=Path)
    parser.add_argument("--write", action="store_true")
    choice = parser.parse_args()
    if choice.write:
        from benchmarks.reliability import write_page

        write_page()
        return
    if choice.folder is not None:
        for path in sorted(path for path in choice.folder.iterdir() if path.suffix in SUFFIXES):
            print(f"{path.name}: {': '.join(outcome(path))}", flush=True)
        return
    folder = Path(tempfile.mkdtemp(prefix="attack-"))
    print(f"what fails is kept in {folder}")
    rows = []
    for suffix, source in seeds().items():
        if choice.only in (None, suffix):
            rows.append(attack(suffix, source, choice.each, choice.seed, folder))
            print(json.dumps(rows[-1]), flush=True)
            (folder / f"attacked{suffix}").unlink(missing_ok=True)
    if choice.only is None:
        RESULTS.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
