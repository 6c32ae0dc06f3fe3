"""`./dev gui-test held`: how long the window is held up while it is used. Numbers only, into result.json; `python -m benchmarks.window`
makes the table of docs/window.md of them. Nothing is judged, since machines differ.

For every action times are taken, in milliseconds: the longest call of the extension on Blender's main thread, by the clock and on the
processor; the longest time that Python's lock was not to be had by a thread that asks for it every 2 ms; and the longest time between two
events of a timer, which holds Blender's own drawing, too. The last is taken with Blender's own Solid shading as well.
"""

import importlib
import sys
import threading
import time
from collections.abc import Callable, Generator
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from harness import close_extra_windows, results, run, save, settle, step, until, view  # noqa: E402 - see above
from room import ENGINE, addon, here  # noqa: E402

FRAMES, EDITS = 16, 8
ASKED_EVERY_S = 0.002
MESHES = 100  # that the objects of the field share


class Calls:
    """Wraps what Blender calls of the extension on its main thread and notes how long each call takes: (clock, processor) milliseconds.

    Opening a window for the picture, which is Blender's own, does not count.
    """

    def __init__(self) -> None:
        viewport, ticking, sources = addon("blender.viewport"), addon("operators.ticking"), addon("blender.sources")
        places = [(viewport.LiveView, name) for name in ("draw", "update", "draw_late")]
        places += [(ticking.Ticking, "modal"), (ticking.Ticking, "begin"), (sources.ViewReading, "collect")]
        self.ms: dict[str, list[tuple[float, float]]] = {}
        self._not_ours = np.zeros(2)
        self._undo = [(owner, name, getattr(owner, name)) for owner, name in [*places, (addon("blender.image_editor"), "_open")]]
        for owner, name, function in self._undo[:-1]:
            setattr(owner, name, self._timed(f"{owner.__name__}.{name}", function))
        owner, name, function = self._undo[-1]
        setattr(owner, name, self._left_out(function))

    def _timed(self, name: str, function: Callable) -> Callable:
        listed = self.ms.setdefault(name, [])

        def timed(*arguments, **options):
            start, before = spent(), self._not_ours.copy()
            try:
                return function(*arguments, **options)
            finally:
                listed.append(tuple(spent() - start - (self._not_ours - before)))

        def modal(self, context, event):  # Blender counts an operator's arguments
            return timed(self, context, event)

        return modal if function.__name__ == "modal" else timed

    def _left_out(self, function: Callable) -> Callable:
        def timed(*arguments, **options):
            start = spent()
            try:
                return function(*arguments, **options)
            finally:
                self._not_ours += spent() - start

        return timed

    def stop(self) -> dict[str, object]:
        """Put the functions back; the longest call by the clock and by the processor, and the name of the latter."""
        for owner, name, function in self._undo:
            setattr(owner, name, function)
        calls = [(cpu, wall, name) for name, listed in self.ms.items() for wall, cpu in listed] or [(0.0, 0.0, "none")]
        return {"call": round(max(wall for _, wall, _ in calls), 1), "cpu": round(max(calls)[0], 1), "in": max(calls)[2]}


def spent() -> np.ndarray:
    """Milliseconds of the clock, and of this thread on the processor."""
    return 1e3 * np.array([time.perf_counter(), time.thread_time()])


class Ticks:
    """A timer of Blender's every 10 ms; the times between its calls: how long the window's events waited."""

    def __init__(self) -> None:
        self.gaps: list[float] = [0.0]
        self._last = time.perf_counter()
        self._registered = self._tick  # a bound method is a new object each time
        bpy.app.timers.register(self._registered, first_interval=0.01)

    def _tick(self) -> float:
        now = time.perf_counter()
        self.gaps.append(1e3 * (now - self._last))
        self._last = now
        return 0.01

    def stop(self) -> list[float]:
        """End it; the times."""
        bpy.app.timers.unregister(self._registered)
        return self.gaps


class Lock:
    """A thread that does nothing but ask for Python's lock; how late it got it."""

    def __init__(self) -> None:
        self.gaps: list[float] = [0.0]
        self._is_over = False
        self._thread = threading.Thread(target=self._ask, daemon=True)
        self._thread.start()

    def _ask(self) -> None:
        while not self._is_over:
            start = time.perf_counter()
            time.sleep(ASKED_EVERY_S)
            self.gaps.append(1e3 * (time.perf_counter() - start - ASKED_EVERY_S))

    def stop(self) -> list[float]:
        """End it; the times."""
        self._is_over = True
        self._thread.join()
        return self.gaps


def during(action: Generator) -> Generator:
    """The three times of an action; the generator's return value."""
    calls, lock, ticks = Calls(), Lock(), Ticks()
    try:
        yield from action
        yield 0.1
    finally:
        events, waits, longest = ticks.stop(), lock.stop(), calls.stop()
    numbers = {"lock": max(waits), "lock_p99": float(np.quantile(waits, 0.99)), "events": max(events), "events_median": np.median(events)}
    return longest | {name: round(float(value), 1) for name, value in numbers.items()}


def orbit() -> Generator:
    """Turn the view step by step."""
    for _ in range(FRAMES):
        with here():
            bpy.ops.view3d.view_orbit(angle=0.02, type="ORBITRIGHT")
        view().tag_redraw()
        yield 0.02


def drag() -> Generator:
    """Move an object step by step."""
    for i in range(EDITS):
        bpy.context.scene.objects[-1].location.z += 0.01 if i % 2 else -0.01
        yield 0.02


def settings() -> Generator:
    """Change the method, one setting after another."""
    props = bpy.context.scene.cad_shadow
    for name, values in (("map_size", (512, 1024)), ("partition", ("none", "z-adaptive")), ("test", ("triangle", "depth"))):
        for value in values:
            setattr(props, name, value)
            yield from shown()


def shown() -> Generator:
    """Until the live view shows the full picture of the present view."""

    def is_fine() -> bool:
        return any(
            live._shown and live._shown.coarseness <= 1 and live._shown.key == live._wanted for live in addon("blender.viewport")._views
        )

    view().tag_redraw()
    yield 0.1
    yield from until(is_fine, "the live view's full picture", 300)


def switched() -> Generator:
    """To Rendered shading, until the full picture is there."""
    view().spaces.active.shading.type = "RENDERED"
    yield from shown()


def pressed(name: str, **options: object) -> Generator:
    """An operator as its button starts it, until it is over."""
    ticking, ended = addon("operators.ticking"), []
    release = ticking.Ticking._release

    def released(self, context):
        ended.append(True)
        release(self, context)

    ticking.Ticking._release = released
    try:
        with here():
            assert getattr(bpy.ops.cad_shadow, name)("INVOKE_DEFAULT", **options) == {"RUNNING_MODAL"}
        yield from until(lambda: ended, name, 300)
    finally:
        ticking.Ticking._release = release


def advised() -> Generator:
    """The advice as its dialog starts it."""
    with here():
        assert bpy.ops.cad_shadow.advise("EXEC_DEFAULT", texels=1.0, seconds=10.0) == {"RUNNING_MODAL"}
    session = addon("blender.session")
    yield from until(session.last_advice, "the advice", 300)


def field(count: int) -> None:
    """So many objects side by side that share `MESHES` meshes, each with a material."""
    scene = bpy.context.scene
    box = scene.objects["Cube"].data
    meshes = [box.copy() for _ in range(MESHES)]
    for mesh in meshes:
        mesh.materials.clear()
        mesh.materials.append(bpy.data.materials.new("painted"))
    side = round(count**0.5)
    for i in range(count):
        ob = bpy.data.objects.new(f"part {i}", meshes[i % MESHES])
        ob.location = 3.0 * (i % side), 3.0 * (i // side), 0.0
        scene.collection.objects.link(ob)


def deck(triangles: int) -> None:
    """The example deck."""
    addon("blender.cad_import").to_blender(addon("scene.platform_deck").build(triangles), bpy.context.scene.collection)


def scene_of(make: Callable[[], None]) -> Generator:
    """A new file with this scene in view, Solid shading."""
    bpy.ops.wm.read_homefile(app_template="", load_ui=False)
    yield 0.5
    make()
    scene = bpy.context.scene
    for name in ("Cube", "Light", "Camera"):
        bpy.data.objects.remove(scene.objects[name])
    scene.cad_shadow.sun.steps = 3
    scene.render.engine = ENGINE
    view().spaces.active.shading.type = "SOLID"
    with here():
        bpy.ops.object.select_all(action="DESELECT")
        bpy.ops.view3d.view_all()
    yield from settle(1.0)


BUTTONS = ("preview", "analyse", "light_view", "sun_study", "compare", "fit_clip", "frame_camera")


def held_up(name: str, make: Callable[[], None]) -> Generator:
    """All actions in one scene, their times in the results under its name."""
    importlib.import_module("bl_ext.user_default.cad_shadow_preview.addon.pipeline.renderer")  # what the first picture loads on a thread
    yield from scene_of(make)
    found = results.setdefault("held_up_ms", {}).setdefault(name, {})
    found["Solid shading: orbit"] = yield from during(orbit())
    found["Solid shading: edit"] = yield from during(drag())
    found["live view: the switch, until the full picture"] = yield from during(switched())
    found["live view: orbit"] = yield from during(orbit())
    yield from shown()
    found["live view: edit"] = yield from during(drag())
    yield from shown()
    found["live view: settings"] = yield from during(settings())
    view().spaces.active.shading.type = "SOLID"
    yield from settle()
    for button in BUTTONS:
        found[f"button: {button}"] = yield from during(pressed(button))
        yield from close_extra_windows()
        save()
    found["button: advise"] = yield from during(advised())


@step
def a_thousand_objects() -> Generator:
    """1,000 objects: how long the window is held up is written down."""
    yield from held_up("1,000 objects", lambda: field(1_000))


@step
def ten_thousand_objects() -> Generator:
    """10,000 objects: how long the window is held up is written down."""
    yield from held_up("10,000 objects", lambda: field(10_000))


@step
def a_million_triangles() -> Generator:
    """The deck of a million triangles: how long the window is held up is written down."""
    yield from held_up("deck, 1,000,000 triangles", lambda: deck(1_000_000))


run(sys.argv[sys.argv.index("--") + 1 :])
