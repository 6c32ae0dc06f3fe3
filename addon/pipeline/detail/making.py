"""Has coarser casters made in a process of their own, beside the pictures, and keeps them. No bpy, no GL; callable from any thread."""

from __future__ import annotations

import logging
import subprocess
import time
from collections.abc import Callable, Hashable, Mapping
from contextlib import suppress
from threading import Condition, Thread

import numpy as np

from ...scene.child_python import started
from ...scene.reading import wire
from ...scene.records import Mesh, Scene
from . import kept
from .collapse import Coarse

LIBRARIES = ("numpy", "fast_simplification")
LEAST_TRIANGLES = 256  # of a mesh: below, a call costs as much as they do
MOST_TRIANGLES = 4_000_000  # of a mesh: above, making takes minutes
PAYS_FROM = 50_000  # triangles of instances of such meshes: below, maps cost little
POLL_S = 0.05
Levels = Mapping[Hashable, tuple[Coarse, ...]]
_log = logging.getLogger(__name__)


def wanted(scene: Scene) -> tuple[Mesh, ...]:
    """The meshes of a scene that coarser ones are looked for of, those that cast most first; none where it would not pay."""
    triangles = np.array([len(mesh.triangles) for mesh in scene.meshes], np.int64)
    triangles[(triangles < LEAST_TRIANGLES) | (triangles > MOST_TRIANGLES)] = 0
    cast = triangles * np.bincount(scene.instances.mesh_index, minlength=len(triangles))
    if cast.sum() < PAYS_FROM:
        return ()
    return tuple(scene.meshes[i] for i in np.argsort(-cast, kind="stable").tolist() if cast[i])


class CoarseMaker:
    """One thread and one process, which live as long as there is work. What a mesh has come to is told by its key.

    `version` counts the answers: equal ones, equal levels.
    """

    def __init__(self) -> None:
        self._changed = Condition()
        self._asked: tuple[Mesh, ...] | None = None
        self._answer: Levels | None = None
        self.version = 0
        self._waited_for: set[Hashable] = set()
        self._queue: list[Mesh] = []
        self._made: dict[Hashable, tuple[Coarse, ...]] = {}
        self._thread: Thread | None = None
        self._process: subprocess.Popen[bytes] | None = None
        self._is_closed = False

    def levels(self, scene: Scene) -> Levels | None:
        """The levels, by mesh key, of the scene's meshes that have any; None until all are made, which this call asks for.

        What was asked for before and is not in the scene is not begun any more, and what was made of it is forgotten.
        """
        with self._changed:
            if scene.meshes is not self._asked:
                self._ask(scene)
            if self._waited_for:
                return None
            if self._answer is None:
                self.version += 1
                self._answer = {key: levels for key, levels in self._made.items() if levels}
            return self._answer

    def wait(self, scene: Scene, check: Callable[[], None]) -> Levels:
        """The same, waited for; `check()` is called now and then and may raise."""
        while (levels := self.levels(scene)) is None:
            check()
            with self._changed:
                if self._is_closed:
                    return {}
                self._changed.wait(POLL_S)
        return levels

    def _ask(self, scene: Scene) -> None:
        meshes = {mesh.key: mesh for mesh in wanted(scene)}
        self._asked, self._answer = scene.meshes, None
        self._made = {key: levels for key, levels in self._made.items() if key in meshes}
        self._queue = [mesh for mesh in meshes.values() if mesh.key not in self._made]
        self._waited_for = {mesh.key for mesh in self._queue}
        if self._queue and self._thread is None and not self._is_closed:
            self._thread = Thread(target=self._work, name="cad-shadow-casters", daemon=True)
            self._thread.start()

    def _work(self) -> None:
        """On the thread: one mesh after the other."""
        while True:
            with self._changed:
                if not self._queue or self._is_closed:
                    self._thread = None
                    self._end()
                    return
                mesh = self._queue[0]
            levels = self._levels_of(mesh)
            with self._changed:
                if mesh.key in self._waited_for:
                    self._made[mesh.key] = levels
                    self._waited_for.discard(mesh.key)
                    self._queue = [one for one in self._queue if one.key != mesh.key]
                self._changed.notify_all()

    def _levels_of(self, mesh: Mesh) -> tuple[Coarse, ...]:
        name = kept.name_of(mesh.positions, mesh.triangles)
        levels = kept.read(name, len(mesh.triangles))
        if levels is None:
            begin = time.monotonic()
            levels = self._made_apart(mesh)
            if levels is None:
                return ()
            _log.debug("casters of %d triangles made in %.1f s", len(mesh.triangles), time.monotonic() - begin)
            kept.write(name, levels)
        return levels

    def _made_apart(self, mesh: Mesh) -> tuple[Coarse, ...] | None:
        """What the process has made of it; None where it could not, and the mesh casts its shadow as it is."""
        try:
            if self._process is None:
                self._process = started("pipeline.detail.child", (), LIBRARIES, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
            wire.send(self._process.stdin, (mesh.positions, mesh.triangles))
            return tuple(Coarse(*level) for level in wire.receive(self._process.stdout))
        except (EOFError, OSError, ValueError, KeyError, TypeError, MemoryError) as error:
            if not self._is_closed:
                _log.warning("No coarser caster of a mesh of %d triangles could be made (%s).", len(mesh.triangles), error)
            self._end()
            return None

    def _end(self) -> None:
        process, self._process = self._process, None
        if process is not None:
            with suppress(OSError):
                process.stdin.close()
            process.kill()
            process.wait()
            process.stdout.close()

    def release(self) -> None:
        """Stop: what is being made is given up."""
        with self._changed:
            self._is_closed, self._queue = True, []
            process, thread = self._process, self._thread
            self._changed.notify_all()
        if process is not None:
            process.kill()
        if thread is not None:
            thread.join()
