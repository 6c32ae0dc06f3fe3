"""Runs inside a windowed Blender: claims about the user interface, checked one after the other while the window lives on.

A step is a generator: each `yield seconds` gives the time back to Blender. Real mouse and keyboard events come from xdotool. Pictures are
taken from the X server (Blender's own `screen.screenshot` is black with software OpenGL). Results go to $OUT/result.json after each step.
A Blender that does not come back to its timers is ended, with every thread's Python stack in the log.
"""

import faulthandler
import json
import os
import subprocess
import sys
import time
import traceback
from collections.abc import Callable, Generator
from pathlib import Path

import bpy
import numpy as np

OUT = Path(os.environ["OUT"])
STEPS: list[Callable[[], Generator]] = []
HANG_S = float(os.environ.get("HANG_S", 120))


def step(function: Callable[[], Generator]) -> Callable[[], Generator]:
    """Mark a generator function as a step; its docstring is the claim."""
    STEPS.append(function)
    return function


def window() -> bpy.types.Window:
    """The first window."""
    return bpy.context.window_manager.windows[0]


def view() -> bpy.types.Area:
    """The largest 3D viewport of the first window."""
    return max((area for area in window().screen.areas if area.type == "VIEW_3D"), key=lambda area: area.width * area.height)


def region(kind: str, area: bpy.types.Area | None = None) -> bpy.types.Region:
    """A region of the viewport: WINDOW, UI, HEADER…"""
    return next(r for r in (area or view()).regions if r.type == kind)


def redraw() -> None:
    """Ask for a redraw of everything."""
    for w in bpy.context.window_manager.windows:
        for area in w.screen.areas:
            area.tag_redraw()


def load() -> float:
    """How many wait for each processor, at least 1, as the host last wrote it: the chroot has no /proc to look it up."""
    try:
        return max(float((OUT / "load").read_text()), 1.0)
    except (FileNotFoundError, ValueError):
        return 1.0


def until(condition: Callable[[], object], what: str, seconds: float = 120) -> Generator:
    """Wait until the condition holds; TimeoutError saying what was waited for. Seconds are those of a machine with nothing else to do."""
    left, last = seconds, time.monotonic()
    while not condition():
        if left < 0.0:
            raise TimeoutError(f"waited {seconds} s for: {what}")
        yield 0.05
        now = time.monotonic()
        left, last = left - (now - last) / load(), now


def settle(seconds: float = 0.3) -> Generator:
    """Redraw twice and wait."""
    for _ in range(2):
        redraw()
        yield seconds


def close_extra_windows() -> Generator:
    """Leave only the first window, once those asked for are open. Without a window manager its pixels may not come back before another
    file is opened."""
    yield 0.1
    for extra in list(bpy.context.window_manager.windows)[1:]:
        with bpy.context.temp_override(window=extra):
            bpy.ops.wm.window_close()
    yield from until(lambda: len(bpy.context.window_manager.windows) == 1, "the other windows to close")
    yield from settle()


def xdotool(*words: object) -> Generator:
    """Real events; Blender goes on meanwhile."""
    process = subprocess.Popen(["xdotool", *map(str, words)])
    yield from until(lambda: process.poll() is not None, f"xdotool {words}")


def point(x: float, y: float) -> tuple[int, int]:
    """Blender's window coordinates (from the lower left) as the X server's (from the upper left)."""
    return int(x), int(window().height - 1 - y)


def hover(x: float, y: float) -> Generator:
    """Move there in two moves: a single jump is not noticed as a movement over a button."""
    px, py = point(x, y)
    yield from xdotool("mousemove", px - 3, py - 2, "sleep", "0.15", "mousemove", px, py, "sleep", "0.2")


def click(x: float, y: float, button: int = 1) -> Generator:
    """Click there."""
    yield from hover(x, y)
    yield from xdotool("click", button)
    yield 0.2


def press(key: str, x: float | None = None, y: float | None = None) -> Generator:
    """A key, with the mouse over the middle of the viewport or a given place."""
    r = region("WINDOW")
    yield from hover(r.x + r.width / 2 if x is None else x, r.y + r.height / 2 if y is None else y)
    yield from xdotool("key", key)
    yield 0.2


def picture(name: str, box: tuple[int, int, int, int] | None = None) -> np.ndarray:
    """The screen, or a box (x, y, width, height) in window coordinates, as $OUT/name.png and as array (h, w, 3) 0…255, top row first."""
    path = OUT / f"{name}.png"
    crop = []
    if box:
        left, top = point(box[0], box[1] + box[3] - 1)
        crop = ["-crop", f"{box[2]}x{box[3]}+{left}+{top}", "+repage"]
    subprocess.run(["import", "-window", "root", *crop, str(path)], check=True)
    raw = subprocess.run(["convert", str(path), "-depth", "8", "rgb:-"], check=True, capture_output=True).stdout
    size = subprocess.run(["identify", "-format", "%h %w", str(path)], check=True, capture_output=True, text=True).stdout.split()
    return np.frombuffer(raw, np.uint8).reshape(int(size[0]), int(size[1]), 3)


def box_of(r: bpy.types.Region) -> tuple[int, int, int, int]:
    """A region as a box."""
    return r.x, r.y, r.width, r.height


def changed_share(a: np.ndarray, b: np.ndarray, threshold: int = 12) -> float:
    """The share of pixels that differ by more than the threshold in any channel; 1 when the sizes differ."""
    if a.shape != b.shape:
        return 1.0
    return float((np.abs(a.astype(int) - b).max(axis=2) > threshold).mean())


def colours(image: np.ndarray) -> int:
    """The number of different colours: an empty area has a handful."""
    return len(np.unique(image.reshape(-1, 3), axis=0))


def _everything(names: list[str]) -> Generator:
    unknown = set(names) - {function.__name__ for function in STEPS}
    if unknown:
        raise ValueError(f"no such steps: {sorted(unknown)}")
    for function in STEPS:
        if names and function.__name__ not in names:
            continue
        started, error = time.monotonic(), None
        try:
            yield from close_extra_windows()
            yield from function()
        except Exception:  # a failed claim must not end the others
            error = traceback.format_exc()
            picture(f"failed_{function.__name__}")
        claim = (function.__doc__ or function.__name__).strip()
        results["steps"].append({"name": claim, "ok": error is None, "error": error, "seconds": round(time.monotonic() - started, 1)})
        save()


def save() -> None:
    """Write the results so far."""
    (OUT / "result.json").write_text(json.dumps(results, indent=1))


results: dict = {"steps": []}


def run(names: list[str]) -> None:
    """Take the steps from a timer, write the results, quit Blender."""
    import gpu

    results.update(
        blender=f"Blender {bpy.app.version_string}, Python {sys.version.split()[0]}",
        gl=f"{gpu.platform.renderer_get()} ({gpu.platform.backend_type_get()})",
    )
    steps = _everything(names)
    faulthandler.enable()  # a crash leaves every thread's Python stack in the log

    def tick() -> float | None:
        faulthandler.dump_traceback_later(HANG_S, exit=True)
        try:
            return next(steps)
        except StopIteration:
            pass
        except Exception:
            results["steps"].append({"name": "the harness", "ok": False, "error": traceback.format_exc(), "seconds": 0})
        save()
        with bpy.context.temp_override(window=window()):
            bpy.ops.wm.quit_blender()
        return None

    bpy.app.timers.register(tick, first_interval=0.5, persistent=True)
