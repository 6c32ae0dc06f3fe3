"""Operators on a timer: they end, fail and are given up without leaving their timer behind."""

import importlib
import itertools
import threading
from types import SimpleNamespace

import pytest

TICK, ESC, MOUSE = (SimpleNamespace(type=t, value="PRESS") for t in ("TIMER", "ESC", "MOUSEMOVE"))


@pytest.fixture
def window():
    """A context whose window manager notes what it is asked."""
    log = []
    manager = SimpleNamespace(
        event_timer_add=lambda _every, window: log.append("timer") or "timer",
        event_timer_remove=lambda timer: log.remove(timer),
        progress_begin=lambda *_: log.append("progress"),
        progress_end=lambda: log.remove("progress"),
        modal_handler_add=lambda _operator: None,
    )
    return SimpleNamespace(window_manager=manager, window=object(), screen=None, workspace=None), log


@pytest.fixture
def operator(extension):
    """Made from the results of its ticks; an exception among them is raised."""
    import importlib

    ticking = importlib.import_module(f"{extension.__name__}.operators.ticking")

    class Operator(ticking.Ticking):
        def __init__(self, *results):
            self.results, self.given_up = list(results), False

        def tick(self, _context):
            result = self.results.pop(0)
            if isinstance(result, Exception):
                raise result
            return result

        def give_up(self, _context):
            self.given_up = True

    return Operator


def test_it_runs_until_a_tick_gives_a_result(window, operator):
    context, log = window
    working = operator(None, None, {"FINISHED"})
    assert working.begin(context) == {"RUNNING_MODAL"} and sorted(log) == ["progress", "timer"]
    assert working.modal(context, MOUSE) == {"PASS_THROUGH"}
    assert [working.modal(context, TICK) for _ in range(3)] == [{"RUNNING_MODAL"}, {"RUNNING_MODAL"}, {"FINISHED"}]
    assert log == [] and not working.given_up


def test_escape_gives_up(window, operator):
    context, log = window
    working = operator(None)
    working.begin(context)
    assert working.modal(context, ESC) == {"CANCELLED"}
    assert log == [] and working.given_up


def test_when_the_extension_goes_operators_at_work_are_given_up(window, operator, room):
    context, log = window
    ended, working = operator({"FINISHED"}), operator(None, None)
    for one in (ended, working):
        one.begin(context)
    ended.modal(context, TICK)
    room("operators.ticking").end_all(context)
    assert log == [] and working.given_up and not ended.given_up
    room("operators.ticking").end_all(context)


def test_an_operator_that_blender_has_freed_does_not_keep_the_others_from_being_given_up(window, operator, room, monkeypatch):
    context, log = window
    gone, working = operator(None), operator(None)
    for one in (gone, working):
        one.begin(context)

    def freed(_context):
        raise ReferenceError("StructRNA has been removed")

    monkeypatch.setattr(gone, "give_up", freed)
    room("operators.ticking").end_all(context)
    assert working.given_up and room("operators.ticking")._running == []


def test_a_defect_leaves_no_timer(window, operator):
    context, log = window
    working = operator(RuntimeError("defect"))
    working.begin(context)
    with pytest.raises(RuntimeError, match="defect"):
        working.modal(context, TICK)
    assert log == []


@pytest.fixture
def background(extension):
    import importlib

    return importlib.import_module(f"{extension.__name__}.operators.background")


def test_work_on_a_thread_says_how_far_it_is_and_what_came_of_it(background):
    is_told, may_end = threading.Event(), threading.Event()

    def work(say, _is_given_up):
        say(0.5, "half")
        is_told.set()
        may_end.wait(10)
        return "done"

    pending = background.OnThread(work)
    assert is_told.wait(10) and not pending.done() and pending.progress == (0.5, "half")
    may_end.set()
    assert pending.result() == "done" and pending.done()


def test_work_given_up_is_told_so(background):
    pending = background.OnThread(lambda _say, is_given_up: next(i for i in itertools.count() if is_given_up()))
    assert not pending.done()
    pending.cancel()
    assert isinstance(pending.result(), int)


def test_what_the_work_raises_is_raised_where_its_result_is_taken(background):
    pending = background.OnThread(lambda *_: 1 // 0)
    with pytest.raises(ZeroDivisionError):
        pending.result()


def test_work_on_threads_ends_with_the_extension(background):
    works = [background.OnThread(lambda _say, is_given_up: next(i for i in itertools.count() if is_given_up())) for _ in range(3)]
    background.end_threads(20.0)
    assert all(work.done() and not work.thread.is_alive() for work in works)


def test_python_does_not_wait_for_work_that_nobody_gives_up(background):
    work = background.OnThread(lambda _say, is_given_up: next(i for i in itertools.count() if is_given_up()))
    assert work.thread.daemon
    assert work.thread not in importlib.import_module("concurrent.futures.thread")._threads_queues
    work.cancel()
    work.result()


def test_a_comparison_given_up_while_it_traces_gives_no_result(cube_scene, room):
    import bpy

    job, is_given_up = room("blender.sources").ViewReading().job(bpy.context), threading.Event()

    def say(_fraction, stage):
        if stage == "tracing rays":
            is_given_up.set()

    with pytest.raises(room("errors").Cancelled):
        room("operators.compare").compared(job, say, is_given_up.is_set)


class Dropped:
    """An operator whose class was unregistered while it was at work."""

    @property
    def bl_idname(self):
        raise ValueError("could not be resolved")


@pytest.mark.parametrize(("modal", "takes"), [([], True), ([SimpleNamespace(bl_idname="X_OT_y")], True), ([Dropped()], False)])
def test_no_operator_goes_on_in_a_window_that_would_crash(room, modal, takes):
    takes_operators = room("operators.ticking").takes_operators
    assert takes_operators(SimpleNamespace(modal_operators=modal)) is takes
    assert not takes_operators(None)


def test_the_status_bar_says_what_is_at_work_and_is_given_back(window, operator, extension):
    background, said = importlib.import_module(f"{extension.__name__}.operators.background"), []
    context, _ = window
    context.workspace = SimpleNamespace(status_text_set=said.append)
    context.window_manager.progress_update = lambda _percent: None

    class Work(background.JobOperator):
        bl_label = "CAD Shadow Preview"
        _pending = SimpleNamespace(done=lambda: False, progress=(0.4, "shade"), cancel=lambda: None)

    work = Work()
    work.begin(context)
    assert work.modal(context, TICK) == {"RUNNING_MODAL"}
    assert said == ["CAD Shadow Preview: shade, 40% · Esc stops"]
    work.modal(context, ESC)
    assert said[-1] is None
