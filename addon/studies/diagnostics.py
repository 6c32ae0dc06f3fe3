"""What someone who helps needs to know of a machine: versions, OpenGL, preferences, settings, last errors. Plain text, no paths. No bpy."""

from __future__ import annotations

import logging
import platform
import re
import sys
from collections import deque
from collections.abc import Mapping
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version

import numpy as np

from ..pipeline.gl.machine import chosen, described
from ..scene.plain_text import shown_lines
from ..scene.reading import limits
from ..settings.groups import Settings

LOGGER = logging.getLogger(__package__.removesuffix(".studies"))
LIBRARIES = ("moderngl", "glcontext", "trimesh", "fast-simplification", "cascadio", "DracoPy")
KEPT = 20
_PATH = re.compile(r"(?:[A-Za-z]:)?(?:[\\/]+[^\\/\s:'\"]+){2,}|~[\\/]\S+")


class _Recent(logging.Handler):
    """Keeps the last lines that were logged."""

    def __init__(self) -> None:
        super().__init__(logging.INFO)
        self.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(message)s", "%H:%M:%S"))
        self.lines: deque[str] = deque(maxlen=KEPT)

    def emit(self, record: logging.LogRecord) -> None:
        """Keep it."""
        self.lines.append(self.format(record))


_recent = _Recent()


def register() -> None:
    """Keep what is logged from here on. Nothing more is printed: the root logger decides, as everywhere."""
    LOGGER.setLevel(logging.INFO)
    LOGGER.addHandler(_recent)


def unregister() -> None:
    """Keep nothing any more."""
    LOGGER.removeHandler(_recent)
    LOGGER.setLevel(logging.NOTSET)
    _recent.lines.clear()


def diagnostics(
    host: Mapping[str, object], settings: Settings, report: Mapping[str, object] | None = None, with_paths: bool = False
) -> str:
    """The text: what Blender says of itself (`host`), this machine, the settings other than the defaults, the last report, the last errors.

    Paths are written as `<path>` unless `with_paths`: they hold names.
    """
    blocks = {
        "Blender": host,
        "Python": {"version": sys.version.split()[0], "system": platform.platform(), "numpy": np.__version__, **_libraries()},
        "OpenGL": described() or {"context": "none was made in this process yet"},
        "Preferences": {**asdict(chosen()), **{f"import_{name}": value for name, value in asdict(limits.chosen()).items()}},
        "Settings other than the defaults": _changed(settings),
        "Last picture": _last(report),
    }
    lines = ["CAD Shadow Preview: diagnostics"]
    for title, facts in blocks.items():
        lines += ["", title, *(f"  {name}: {value}" for name, value in facts.items())]
    lines += ["", "Last errors", *("  " + line for one in _recent.lines for line in one.splitlines())]
    text = shown_lines("\n".join(lines)) + "\n"
    return text if with_paths else _PATH.sub("<path>", text)


def _libraries() -> dict[str, str]:
    found = {}
    for name in LIBRARIES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "missing"
    return found


def _changed(settings: Settings) -> dict[str, object]:
    defaults = Settings().as_dict()
    return {
        f"{group}.{name}": value
        for group, values in settings.as_dict().items()
        if isinstance(values, dict)
        for name, value in values.items()
        if value != defaults[group][name]
    }


def _last(report: Mapping[str, object] | None) -> dict[str, object]:
    """Size, times and warnings of the last report; object names and places are left out."""
    if report is None:
        return {"report": "none yet"}
    kept = {name: report[name] for name in ("size", "triangles", "timing_ms", "measured") if name in report}
    return {**kept, "warnings": len(report.get("warnings", ())), "errors": len(report.get("errors", ()))}
