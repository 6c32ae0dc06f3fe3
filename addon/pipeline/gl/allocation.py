"""Whether the driver gave what was asked for: OpenGL only notes that it had no memory, and draws into nothing. Worker thread only."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Protocol, TypeVar

import moderngl

from ...errors import DriverError, GpuError

log = logging.getLogger(__name__)
FULL = "GL_OUT_OF_MEMORY"
NONE = "GL_NO_ERROR"
SEVERAL = 8  # a driver may keep more than one error at a time, and one that is lost reports without end


class Releasable(Protocol):
    """What holds something of the driver's."""

    def release(self) -> None:
        """Give it back."""


R = TypeVar("R", bound=Releasable)


def freed_with(stack: ExitStack, thing: R) -> R:
    """`thing`, released when the stack closes: also when what is made after it fails."""
    stack.callback(thing.release)
    return thing


@contextmanager
def allocating(context: moderngl.Context, what: str, advice: str) -> Iterator[None]:
    """What is made while this lasts is there afterwards; else `GpuError`, which names `what` was wanted and gives the `advice`."""
    check_memory(context)
    try:
        yield
    except (moderngl.Error, GpuError) as error:
        found = noted(context)
        if isinstance(error, GpuError) and FULL not in found:
            raise
        raise _refusal(found or [str(error)], what, advice) from error
    found = noted(context)
    if found:
        raise _refusal(found, what, advice)


def noted(context: moderngl.Context) -> list[str]:
    """The errors that the driver has noted since it was last asked."""
    return [error for error in (context.error for _ in range(SEVERAL)) if error != NONE]


def _refusal(errors: list[str], what: str, advice: str) -> GpuError:
    if FULL in errors:
        return GpuError(f"There is not enough graphics memory for {what}: {advice}.")
    return DriverError(f"The graphics driver refused {what} ({errors[0]}): {advice}, or update the driver.")


def check_memory(context: moderngl.Context) -> None:
    """Raise `DriverError` when the driver has noted, since it was last asked, that it had no memory: what was drawn may be anything.

    Whatever else it has noted is logged: the pictures may be right all the same.
    """
    found = noted(context)
    if FULL in found:
        raise DriverError("There is not enough graphics memory for this picture: choose a smaller one, or hide parts of the scene.")
    if found:
        log.error("OpenGL noted %s", ", ".join(found))


def check_buffer_texture(context: moderngl.Context, texels: int) -> None:
    """Raise `GpuError` when a shader cannot read so many texels of a buffer: the driver would give it zeros beyond its limit."""
    limit = buffer_texture_limit(context)
    if texels > limit:
        raise GpuError(
            f"The scene needs a table of {texels:,} entries, this graphics driver reads {limit:,}: hide or simplify parts of the scene."
        )


def buffer_texture_limit(context: moderngl.Context) -> int:
    """How many texels of a buffer a shader can read."""
    return context.info["GL_MAX_TEXTURE_BUFFER_SIZE"]
