"""What reading one file may cost: chosen once for the computer (Blender's preferences, the command line's options)."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

MEBI = 2**20
STATM = Path("/proc/self/statm")
TOO_MUCH = 75  # exit code of a process that has passed its limit of memory
WATCH_S = 0.1
SHARE = 0.75  # of the computer's memory, where no limit is chosen


@dataclass(frozen=True)
class Limits:
    """`seconds` by the clock, 0 = as long as it takes; `memory_mib` of the process, 0 = three quarters of what the computer has."""

    seconds: int = 300
    memory_mib: int = 0

    def __post_init__(self) -> None:
        if self.seconds < 0 or self.memory_mib < 0:
            raise ValueError(f"not a limit: {self}")


_chosen = [Limits()]


def chosen() -> Limits:
    """The limits that hold."""
    return _chosen[0]


def choose(limits: Limits) -> None:
    """Let these hold from the next file on."""
    _chosen[0] = limits


def memory_bytes(limits: Limits) -> int:
    """What a process may take; 0 when that is not known."""
    if limits.memory_mib:
        return limits.memory_mib * MEBI
    with suppress(AttributeError, ValueError, OSError):  # Windows has no sysconf
        return int(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") * SHARE)
    return 0


def enforce_memory(limits: Limits) -> None:
    """Hold this process to its memory, as far as the system can: called by the process that reads.

    Linux refuses what is beyond the limit; Windows too, by a job object; macOS takes a limit and does not heed it: there the process looks
    after itself and ends when it finds that it has taken more.
    """
    most = memory_bytes(limits)
    if not most:
        return
    if sys.platform == "win32":
        _enforce_on_windows(most)
    elif sys.platform == "darwin":
        watch(most)
    else:
        import resource

        _lower(resource.RLIMIT_AS, most)


def allow_processor(limits: Limits) -> None:
    """Allow this process, from now on, as much processor time as the clock and all its cores give: it then ends even if nobody waits for it
    any more. Not on Windows, which has no such limit."""
    if limits.seconds and sys.platform != "win32":
        import resource

        spent = resource.getrusage(resource.RUSAGE_SELF)
        _lower(resource.RLIMIT_CPU, int(spent.ru_utime + spent.ru_stime) + limits.seconds * (os.cpu_count() or 1) + 5)


@contextmanager
def held_to(limits: Limits) -> Iterator[None]:
    """While this lasts this process ends when it takes longer, and gets no more memory than it has and the limit (Linux with /proc). Not
    on Windows.

    By an alarm of the system's, since Blender lets no Python run meanwhile.
    """
    if sys.platform == "win32":
        yield
        return
    import resource

    before, most = resource.getrlimit(resource.RLIMIT_AS), memory_bytes(limits)
    taken = _address_space()
    if most and taken is not None:
        _lower(resource.RLIMIT_AS, taken + most)
    handler = signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_REAL, limits.seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, handler)
        resource.setrlimit(resource.RLIMIT_AS, before)


def _address_space() -> int | None:
    """Bytes of addresses that this process has taken; None where nobody says: not on Linux, or without /proc as in a bare chroot."""
    try:
        return int(STATM.read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    except OSError:
        return None


def cause(code: int) -> str:
    """What the exit code of a process says."""
    with suppress(ValueError):
        return signal.Signals(-code).name if code < 0 else f"exit code {code}"
    return f"exit code {code}"


def _lower(kind: int, limit: int) -> None:
    import resource

    _, hard = resource.getrlimit(kind)
    with suppress(ValueError, OSError):
        resource.setrlimit(kind, (limit if hard == resource.RLIM_INFINITY else min(limit, hard), hard))


def watch(most: int) -> threading.Thread:
    """End the process with `TOO_MUCH` once it has taken more memory, on a thread that looks now and then."""
    import resource

    unit = 1 if sys.platform == "darwin" else 1024

    def look() -> None:
        while resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit <= most:
            ended.wait(WATCH_S)
        os._exit(TOO_MUCH)

    ended = threading.Event()
    thread = threading.Thread(target=look, name="cad-shadow-memory", daemon=True)
    thread.start()
    return thread


def _enforce_on_windows(most: int) -> None:
    """A job object of its own with JOB_OBJECT_LIMIT_PROCESS_MEMORY."""
    import ctypes
    from ctypes import wintypes

    class Basic(ctypes.Structure):
        _fields_ = [
            ("PerProcessUserTimeLimit", wintypes.LARGE_INTEGER),
            ("PerJobUserTimeLimit", wintypes.LARGE_INTEGER),
            ("LimitFlags", wintypes.DWORD),
            ("MinimumWorkingSetSize", ctypes.c_size_t),
            ("MaximumWorkingSetSize", ctypes.c_size_t),
            ("ActiveProcessLimit", wintypes.DWORD),
            ("Affinity", ctypes.c_size_t),
            ("PriorityClass", wintypes.DWORD),
            ("SchedulingClass", wintypes.DWORD),
        ]

    class Extended(ctypes.Structure):
        _fields_ = [
            ("Basic", Basic),
            ("IoInfo", ctypes.c_ulonglong * 6),
            ("ProcessMemoryLimit", ctypes.c_size_t),
            ("JobMemoryLimit", ctypes.c_size_t),
            ("PeakProcessMemoryUsed", ctypes.c_size_t),
            ("PeakJobMemoryUsed", ctypes.c_size_t),
        ]

    kernel = ctypes.WinDLL("kernel32", use_last_error=True)  # type: ignore[attr-defined]  # Windows has it
    kernel.CreateJobObjectW.restype = kernel.GetCurrentProcess.restype = wintypes.HANDLE
    kernel.CreateJobObjectW.argtypes = [ctypes.c_void_p, wintypes.LPCWSTR]
    kernel.SetInformationJobObject.argtypes = [wintypes.HANDLE, ctypes.c_int, ctypes.c_void_p, wintypes.DWORD]
    kernel.AssignProcessToJobObject.argtypes = [wintypes.HANDLE, wintypes.HANDLE]
    asked = Extended()
    asked.Basic.LimitFlags = 0x100
    asked.ProcessMemoryLimit = most
    job = kernel.CreateJobObjectW(None, None)
    if job and kernel.SetInformationJobObject(job, 9, ctypes.byref(asked), ctypes.sizeof(asked)):  # 9: the extended limits
        kernel.AssignProcessToJobObject(job, kernel.GetCurrentProcess())
