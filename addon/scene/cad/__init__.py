"""CAD files to `CadModel`: parts, shared meshes, colours, units. No bpy; the one place where CAD files are opened.

The readers are our own, each says why; STEP is made triangles of by cascadio (OpenCASCADE).
Everything is parsed before this returns, so a caller that fails here has not touched the user's scene.
"""

from __future__ import annotations

import logging
from pathlib import Path

from ...errors import CadFileError, CadMemoryError
from ..cad_model import CadModel
from ..plain_text import shown
from .assemble import assemble
from .cad_format import CadFormat
from .formats import BY_SUFFIX, SUFFIXES
from .raw import RawFile
from .sniff import checked_path
from .units import METRES_PER_UNIT, UPS

__all__ = ["BY_SUFFIX", "METRES_PER_UNIT", "SUFFIXES", "UPS", "read"]

log = logging.getLogger(__name__)


def read(path: str | Path, units: str | None = None, up: str | None = None) -> CadModel:
    """Read a CAD file into metres and Z up.

    `units` ('mm', 'in', 'metre', …) and `up` ('Y', 'Z', '-Z', …) override what the file or its format says. A guess is a line in
    `warnings`. Raises `CadFileError`, one line that says what to do, when the file is missing, unreadable, of another type, or has no face.
    """
    file = checked_path(path, BY_SUFFIX)
    kind = BY_SUFFIX[file.suffix.lower()]
    try:
        return assemble(_raw(file, kind), file, kind, units, up)
    except MemoryError:
        pass  # what was held is free again before anything is said
    raise CadMemoryError(f"{shown(file.name)} needs more memory than there is: split it, or close other programs.")


def _raw(file: Path, kind: CadFormat) -> RawFile:
    """What its format's reader gives; raises `CadFileError` and `MemoryError`."""
    try:
        return kind.read(file)
    except CadFileError as error:
        raise CadFileError(shown(str(error))) from error
    except UnicodeEncodeError as error:  # of what readers in other languages are given, the path alone can be no text
        raise CadFileError(f"{shown(file.name)} lies under a name that its reader cannot take: rename it in plain letters.") from error
    except MemoryError:
        raise
    except Exception as error:  # a parser of a foreign format may fail in any way on damaged bytes
        log.debug("reading %s failed", file, exc_info=True)
        raise CadFileError(f"{file.name} cannot be read ({_reason(error)}): it may be damaged. Export it again.") from error


def _reason(error: Exception) -> str:
    text = shown(" ".join(str(error).split()))
    return f"{type(error).__name__}: {text[:120]}" if text else type(error).__name__
