"""Being asked to stop: Ctrl-C, the end of a farm's patience (SIGTERM), a closed terminal. What is done stays done and is reported. No bpy.

The first time a flag is raised, that pictures ask for between their stages and runs between their inputs: what a signal raises would land
in whatever runs just then, in a handler of Blender's too, which prints it and goes on. The second time `KeyboardInterrupt` is raised.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

NAMES = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
STOPPED = "Not done: the run was stopped."

_asked: list[int] = []
_holds: list[None] = []


def is_asked() -> bool:
    """Whether the run that lasts was asked to stop."""
    return bool(_asked)


def check() -> None:
    """Raise `KeyboardInterrupt` when it was."""
    if _asked:
        raise KeyboardInterrupt


@contextmanager
def held() -> Iterator[None]:
    """While this lasts nothing is raised; it is at the end."""
    _holds.append(None)
    try:
        yield
    finally:
        _holds.pop()
    check()


@contextmanager
def heeded(is_worker: bool = False) -> Iterator[None]:
    """While this lasts signals stop the run. A worker leaves Ctrl-C, which reaches every process at a terminal, to the one it works for."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    known = [getattr(signal, name) for name in NAMES if hasattr(signal, name)]
    heard = [number for number in known if signal.getsignal(number) != signal.SIG_IGN]  # nohup has its reasons
    before = {number: signal.signal(number, signal.SIG_IGN if is_worker and number == signal.SIGINT else _take) for number in heard}
    try:
        yield
    finally:
        _asked.clear()
        for number, handler in before.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)  # None: one that is not Python's


def _take(number: int, _frame: object) -> None:
    _asked.append(number)
    if len(_asked) > 1 and not _holds:
        raise KeyboardInterrupt
