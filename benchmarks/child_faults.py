"""Processes of our own killed at every message: the one that renders, the one that reads CAD files. What must hold is asked after each."""

from __future__ import annotations

import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path
from unittest.mock import patch

import numpy as np

from addon.errors import UserError
from addon.pipeline.remote import renderer as remote
from addon.scene.reading import apart, process, wire
from benchmarks.attack_seeds import seeds
from benchmarks.fault_jobs import CASES, PLAIN, Fault

JOB = CASES["a picture"]


def rendering_faults() -> Iterator[Fault]:
    """The rendering process killed before every message to it and at every one from it."""
    with remote_of() as renderer:
        expected = [renderer.submit(job)[0].result(120.0).passes["combined"] for job in (JOB, PLAIN)]
    number, is_over = 0, False
    while not is_over:
        passed: list[str] = []
        with remote_of() as renderer, _killing(number, passed):
            said = _said(lambda renderer=renderer: renderer.submit(JOB)[0].result(120.0))
            is_over = len(passed) <= number
            wrong = "" if isinstance(said, UserError | None) else f"{type(said).__name__}: {said}"
            for job, picture in zip((JOB, PLAIN), expected, strict=True):
                again = _said(lambda job=job, picture=picture, renderer=renderer: _same(renderer.submit(job)[0].result(120.0), picture))
                wrong = wrong or (f"afterwards: {again}" if again is not None else "")
        wrong = wrong or _threads("cad-shadow-_")
        if not is_over:
            yield Fault(passed[number], "killed", wrong)
        number += 1


class remote_of:  # noqa: N801 - a context
    """A rendering process of its own, ended with the block."""

    def __enter__(self) -> remote.RemoteRenderer:
        self.renderer = remote.RemoteRenderer()
        return self.renderer

    def __exit__(self, *_error: object) -> None:
        self.renderer.close()


def _same(frame: object, picture: np.ndarray) -> None:
    if not np.array_equal(frame.passes["combined"], picture):
        raise AssertionError("another picture")


def _said(work: object) -> Exception | None:
    try:
        work()
    except Exception as error:
        return error
    return None


def _killing(at: int, passed: list[str]) -> object:
    """While this lasts the process is killed when message number `at` is about to go either way; the next process lives."""
    take, send, start, started = remote._Child._take, remote.send, remote.started, []

    def kill(what: str) -> None:
        passed.append(what)
        if len(passed) - 1 == at:
            started[-1].kill()
            started[-1].wait()

    def start_noted(*arguments: object, **streams: object) -> object:
        started.append(start(*arguments, **streams))
        return started[-1]

    def taken(child: remote._Child, *message: object) -> None:
        kill(f"from the rendering process: {message[1]}")
        take(child, *message)

    def sent(stream: object, message: tuple) -> None:
        kill(f"to the rendering process: {message[0]}")
        send(stream, message)

    return patch.multiple(remote, send=sent, started=start_noted, _Child=type("_Child", (remote._Child,), {"_take": taken}))


def _threads(start: str) -> str:
    left = [thread.name for thread in threading.enumerate() if thread.name.startswith(start)]
    return f"threads left: {left}" if left else ""


def reading_faults() -> Iterator[Fault]:
    """The reading process killed before it is asked and at every piece of its answer."""
    real_send, real_filled = wire.send, wire._filled
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "model.obj")
        path.write_bytes(seeds()[".obj"].data)
        count, number, is_over = apart.read(path).triangle_count, 0, False
        while not is_over:
            passed: list[str] = []
            reading: list[process.ReaderProcess] = []

            def kill(what: str, passed: list[str] = passed, number: int = number, reading: list = reading) -> None:
                passed.append(what)
                if len(passed) - 1 == number:
                    reading[0]._process.kill()
                    reading[0]._process.wait()

            def send(stream: object, message: object, kill: object = kill) -> None:
                kill("to the reading process")
                real_send(stream, message)

            def filled(stream: object, array: np.ndarray, kill: object = kill) -> np.ndarray:
                kill("from the reading process")
                return real_filled(stream, array)

            real_ask = process.ReaderProcess.ask

            def ask(own: process.ReaderProcess, *words: object, reading: list = reading, real_ask: object = real_ask) -> object:
                reading.append(own)
                return real_ask(own, *words)

            with patch.multiple(wire, send=send, _filled=filled), patch.object(process.ReaderProcess, "ask", ask):
                said = _said(lambda: apart.read(path))
            is_over = len(passed) <= number
            wrong = "" if isinstance(said, UserError | None) else f"{type(said).__name__}: {said}"
            wrong = wrong or ("" if apart.read(path).triangle_count == count else "the next file is read wrong")
            if not is_over:
                yield Fault(passed[number], "killed", wrong)
            number += 1
    process.shutdown()
