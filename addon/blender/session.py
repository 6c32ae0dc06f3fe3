"""What lives as long as the add-on is enabled: the last outcome and advice (for panels and export), the GL worker, the readers' caches."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
import numpy as np
from bpy.app.handlers import persistent

from ..errors import UserError
from ..studies.run import Outcome, libraries_ready, stop_worker
from . import sources
from .changes import stamp_of

if TYPE_CHECKING:
    from ..pipeline.frame import ImpostorReport

LOAD_AFTER_S = 1.0

_outcomes: list[tuple[Outcome, tuple]] = []
_impostors: list[tuple[tuple[ImpostorReport, ...], np.ndarray]] = []
_advice: list[dict[str, object]] = []
_warnings: list[str] = []


def remember(outcome: Outcome, scene: bpy.types.Scene) -> None:
    """Keep `outcome` as the last one, made of Blender's `scene` as it is; callable from any thread."""
    _outcomes[:] = [(outcome, stamp_of(scene))]
    remember_impostors(outcome)


def remember_impostors(outcome: Outcome) -> None:
    """Keep what became of the impostors in a picture, also in one of a live view, and what is said of it; callable from any thread."""
    _impostors[:] = [(outcome.frame.impostors, outcome.job.scene.origin_ws)]
    _warnings[:] = dict.fromkeys((*outcome.job.warnings, *outcome.frame.warnings))


def clear_impostors() -> None:
    """There is no picture any more whose impostors could be told of."""
    _impostors.clear()
    _warnings.clear()


def warnings() -> tuple[str, ...]:
    """What is to be said of the last picture, a live view's included: what it leaves out."""
    return tuple(_warnings)


def impostors() -> tuple[ImpostorReport, ...]:
    """The impostors of the last picture, a live view's included."""
    return _impostors[0][0] if _impostors else ()


def impostor_origin() -> np.ndarray:
    """(3,) the true place of the origin that those impostors are relative to."""
    return _impostors[0][1] if _impostors else np.zeros(3)


def last() -> Outcome | None:
    """The last outcome, or None when nothing was rendered since the file was opened."""
    return _outcomes[0][0] if _outcomes else None


def is_last_current(scene: bpy.types.Scene) -> bool:
    """Whether the last outcome is of this scene, its light and its settings as they are now. (The view may be another one.)"""
    if not _outcomes:
        return False
    outcome, stamp = _outcomes[0]
    try:
        return stamp == stamp_of(scene) and outcome.job.settings == sources.settings_of(scene)
    except UserError:  # settings that no picture can be made with
        return False


def remember_advice(report: dict[str, object]) -> None:
    """Keep the last advice, as `advice_report` makes it."""
    _advice[:] = [report]


def last_advice() -> dict[str, object] | None:
    """The last advice, or None when none was asked for since the file was opened."""
    return _advice[0] if _advice else None


@persistent
def clear(*_unused: object) -> None:
    """Another file was opened: drop the last outcome, whose images may be large, and what was read of the old file."""
    _outcomes.clear()
    clear_impostors()
    _advice.clear()
    sources.clear_readers()


def _load_libraries() -> None:
    libraries_ready()


def register() -> None:
    """Listen for other files being opened; where there is a window, soon begin to import what renders, so that no click waits for it."""
    bpy.app.handlers.load_post.append(clear)
    if not bpy.app.background:
        bpy.app.timers.register(_load_libraries, first_interval=LOAD_AFTER_S, persistent=True)


def unregister() -> None:
    """Stop the worker thread, free its GL objects, drop all that was kept."""
    bpy.app.handlers.load_post.remove(clear)
    if bpy.app.timers.is_registered(_load_libraries):
        bpy.app.timers.unregister(_load_libraries)
    clear()
    stop_worker()
