"""Faults of the OpenGL driver, put in wherever it can fail: at every object that is made, every storage, every framebuffer asked about.

The points are those that a picture is seen to pass, not a list: what returns something to be released, and the raw calls that allocate.
"""

from __future__ import annotations

import ctypes
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import wraps

import moderngl

from addon.pipeline.gl.gl_raw import RawGL

ALLOCATING = ("TexImage", "TexBuffer", "RenderbufferStorage")
KINDS = ("refused", "refused for memory", "out of memory", "driver lost")
"""The object cannot be made, without or with a reason; it is made without storage and the driver notes why; from here on this context
makes nothing any more."""
UNSUPPORTED = 0x8CDD


@dataclass
class Points:
    """Every place where the driver could fail, counted as it is passed; at number `at` it does, as `kind` says."""

    at: int = -1
    kind: str = "refused"
    passed: list[str] = field(default_factory=list)
    noted: list[tuple[moderngl.Context, str]] = field(default_factory=list)
    lost: list[moderngl.Context] = field(default_factory=list)

    def fails(self, context: moderngl.Context, name: str) -> bool:
        """Whether the driver refuses this call; what it notes is in `noted`."""
        self.passed.append(name)
        if any(one is context for one in self.lost):
            return True
        if len(self.passed) - 1 != self.at:
            return False
        self.noted.append((context, "GL_OUT_OF_MEMORY" if "memory" in self.kind else "GL_INVALID_OPERATION"))
        if self.kind == "driver lost":
            self.lost.append(context)
        return self.kind != "out of memory"


def makers() -> list[str]:
    """The methods of a context that make something of the driver's: those whose code names a class that can be released."""
    found = []
    for name, method in vars(moderngl.Context).items():
        code = getattr(method, "__code__", None)
        kinds = [getattr(moderngl, one, None) for one in code.co_names] if code is not None and not name.startswith("_") else []
        if any(isinstance(one, type) and hasattr(one, "release") for one in kinds):
            found.append(name)
    return found


@contextmanager
def injected(points: Points) -> Iterator[Points]:
    """While this lasts the driver fails as `points` says. What is made before counts too: begin with the first picture."""
    kept = {name: getattr(moderngl.Context, name) for name in makers()}
    real_error, real_raw = moderngl.Context.error, RawGL.__init__

    def maker(name: str, real: Callable) -> Callable:
        @wraps(real)
        def make(context: moderngl.Context, *arguments: object, **options: object) -> object:
            if points.fails(context, name):
                raise moderngl.Error(f"cannot create {name}")
            return real(context, *arguments, **options)

        return make

    def raw_init(raw: RawGL, context: moderngl.Context) -> None:
        real_raw(raw, context)
        for name in [one for one in vars(raw) if one.startswith(ALLOCATING)]:
            setattr(raw, name, _raw(points, context, name, getattr(raw, name)))
        raw.CheckFramebufferStatus = _raw(points, context, "CheckFramebufferStatus", raw.CheckFramebufferStatus)

    def error(context: moderngl.Context) -> str:
        own = [one for one in points.noted if one[0] is context]
        if not own:
            return real_error.fget(context)
        points.noted.remove(own[0])
        return own[0][1]

    for name, real in kept.items():
        setattr(moderngl.Context, name, maker(name, real))
    moderngl.Context.error, RawGL.__init__ = property(error), raw_init
    try:
        yield points
    finally:
        for name, real in kept.items():
            setattr(moderngl.Context, name, real)
        moderngl.Context.error, RawGL.__init__ = real_error, real_raw


def _raw(points: Points, context: moderngl.Context, name: str, real: Callable) -> Callable:
    def call(*arguments: object) -> object:
        if points.fails(context, name):
            return UNSUPPORTED if name.startswith("Check") else None
        return real(*arguments)

    return call


def names(context: moderngl.Context, most: int = 1024) -> Counter:
    """How many objects of each kind are alive, asked from the driver itself."""
    found = Counter()
    for kind in ("Texture", "Buffer", "Framebuffer", "Program", "Shader", "VertexArray", "Renderbuffer"):
        is_name = ctypes.CFUNCTYPE(ctypes.c_ubyte, ctypes.c_uint)(context.mglo._context.load_opengl_function(f"glIs{kind}"))
        found[kind] = sum(is_name(number) for number in range(1, most))
    return found
