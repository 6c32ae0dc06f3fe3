"""What was done before: each report of a batch notes what it was made from, and `--resume` skips what would come out the same.

An input counts as unchanged when size and time of modification are as noted, or, with another time, when its content is. Its companions
belong to it: files of the same name (.mtl, .bin), those that the model named and that were read, the libraries that a .blend links.
"""

from __future__ import annotations

import argparse
import hashlib
import json
from pathlib import Path

from ...scene.user_files import Key, Noted, read_bytes
from ...studies.report import extension_version
from .items import Item

KEY = "batch"
MOST_REPORT = 256 << 20
COMPANIONS = (".mtl", ".bin")
# what does not change the result of one input
NOT_ASKED = frozenset(
    ("inputs", "deck", "example", "output", "report", "quiet", "json", "settings")
    + ("resume", "jobs", "recursive", "contact_sheet", "worker", "argv", "is_batch", "is_apart")
)


def request_digest(args: argparse.Namespace) -> str:
    """16 hex digits that name everything asked for beside the input: command, view, light, method (with the content of the settings file
    and of the preset), output format, and the version of this extension."""
    asked = {name: value for name, value in vars(args).items() if name not in NOT_ASKED}
    text = json.dumps([asked, _preset(args), extension_version()], sort_keys=True, default=str)
    return hashlib.blake2b(text.encode(), digest_size=8).hexdigest()


def _preset(args: argparse.Namespace) -> str | None:
    """What the preset asked for holds; None without one."""
    if getattr(args, "preset", None) is None:
        return None
    from ...blender.presets import content  # imports Blender, which knows where a user's presets lie

    return content(args.preset)


def input_files(source: str) -> list[Path]:
    """The input and its companions."""
    path = Path(source)
    return [path, *(p for p in (path.with_suffix(suffix) for suffix in COMPANIONS) if p.is_file() and p != path)]


def stamp_of(item: Item, digest: str) -> dict[str, object]:
    """What this item is made from now; raises `OSError` when the input cannot be read."""
    return {"request": digest, "inputs": [] if item.source is None else [_file_stamp(path) for path in input_files(item.source)]}


def _file_stamp(path: Path) -> dict[str, object]:
    state = path.stat()
    return {"name": path.name, "size": state.st_size, "mtime_ns": state.st_mtime_ns, "sha256": _sha256(path)}


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def companions_of(item: Item, noted: dict[Key, Noted]) -> list[dict[str, object]]:
    """What else was read for this item, with its state; those that cannot be read any more are left to the next run to find changed."""
    own = [] if item.source is None else [path.absolute() for path in input_files(item.source)]
    read = [one.path.absolute() for one in noted.values() if one.is_read and one.path.absolute() not in own]
    return [{**_file_stamp(path), "path": str(path)} for path in read if path.is_file()]


def stamped(report: dict[str, object], stamp: dict[str, object], files: list[Path], folder: Path) -> dict[str, object]:
    """The report with its stamp: what it was made from, and the files made, with their sizes."""
    made = [{"name": path.relative_to(folder.absolute()).as_posix(), "size": path.stat().st_size} for path in files]
    return {**report, KEY: {**stamp, "files": made}}


def done_before(item: Item, digest: str, folder: Path) -> dict[str, object] | None:
    """The report of an earlier run that would come out the same and whose files are all there; None when there is work to do."""
    try:
        report = json.loads(read_bytes(item.report_path, MOST_REPORT, is_own=True))
        stamp = report[KEY]
        is_same = (
            not report["errors"]
            and stamp["request"] == digest
            and all((folder / made["name"]).stat().st_size == made["size"] for made in stamp["files"])
            and _inputs_unchanged(item, stamp["inputs"])
            and all(_is_unchanged(Path(entry["path"]), entry) for entry in stamp.get("companions", ()))
        )
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return report if is_same else None


def _inputs_unchanged(item: Item, noted: list[dict[str, object]]) -> bool:
    paths = [] if item.source is None else input_files(item.source)
    return [path.name for path in paths] == [entry["name"] for entry in noted] and all(map(_is_unchanged, paths, noted))


def _is_unchanged(path: Path, noted: dict[str, object]) -> bool:
    state = path.stat()
    if state.st_size != noted["size"]:
        return False
    return state.st_mtime_ns == noted["mtime_ns"] or _sha256(path) == noted["sha256"]


def picture_of(report: dict[str, object], folder: Path) -> Path | None:
    """The file that shows an item best: its first picture; None where it has none."""
    names = [made["name"] for made in report.get(KEY, {}).get("files", ())]
    pictures = [name for name in names if Path(name).suffix in (".png", ".exr", ".npz")]
    return folder / pictures[0] if pictures else None
