"""The files that a model names: found beside it or below, whatever path its writer had; regular, and of bounded size. No bpy.

Writers leave absolute paths of another machine, backslashes and other cases of letters; so the bare name beside the model counts too.
What lies elsewhere is not read: a model is anybody's, and must not choose what of this disk is opened.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable
from pathlib import Path, PurePosixPath
from urllib.parse import unquote

from ...errors import CadFileError
from ..plain_text import shown_name
from ..user_files import note, read_bytes

MOST_MATERIALS = 64 << 20
MOST_BUFFER = 2 << 30


def companion(document: Path, name: str, any_case: bool = True) -> Path | None:
    """The file that `document` calls `name`: in its folder or below, else the bare name beside it, with `any_case` also written in another
    case, as where disks do not tell cases apart; None when there is none."""
    parts = PurePosixPath(name.strip().strip('"').replace("\\", "/")).parts
    try:
        inside = document.parent.joinpath(*parts) if _is_inside(parts) else None
        found = [path for path in (inside, document.parent / parts[-1] if parts else None) if path is not None and path.exists()]
        if found or not (parts and any_case):
            return found[0] if found else None
        return min((path for path in document.parent.iterdir() if _alike(path.name) == _alike(parts[-1])), default=None)
    except (OSError, ValueError):  # no file can have this name
        return None


def _alike(name: str) -> str:
    """What names have in common that some disks take for one: cases of letters, and letters with their marks apart (macOS)."""
    return unicodedata.normalize("NFC", name).casefold()


def _is_inside(parts: tuple[str, ...]) -> bool:
    return bool(parts) and not any(part in ("/", "..") or ":" in part for part in parts)


class Buffers:
    """The files of a glTF document: its buffers are read; its images, which Blender reads, are noted as inputs."""

    def __init__(self, document: Path, header: dict) -> None:
        self._document = document
        self._buffers = {uri for buffer in header.get("buffers", ()) if isinstance(uri := buffer.get("uri"), str)}
        note_all(document, (uri for image in header.get("images", ()) if isinstance(uri := image.get("uri"), str)))

    def __getitem__(self, uri: str) -> bytes:
        return self.get(uri)

    def get(self, uri: str) -> bytes:
        """The bytes of a buffer. Raises `CadFileError`, one line that says what to do."""
        if uri not in self._buffers:
            raise FileNotFoundError(uri)
        path, name = companion(self._document, unquote(uri)), shown_name(unquote(uri))
        if path is None:
            raise CadFileError(f"{name} is missing: put it beside {self._document.name}.")
        try:
            return read_bytes(path, MOST_BUFFER)
        except OSError as error:
            raise CadFileError(f"{name}, which {self._document.name} needs, cannot be read ({error.strerror}).") from error


def note_all(document: Path, names: Iterable[str]) -> None:
    """Count the files of these names that `document` has as inputs."""
    for name in names:
        path = companion(document, unquote(name), any_case=False) if not name.startswith("data:") else None
        if path is not None:
            note(path)
