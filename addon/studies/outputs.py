"""The one place where results are written: into a temporary file beside the target, renamed when complete. No half file is ever left."""

from __future__ import annotations

import errno
import io
import json
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from math import nan
from pathlib import Path

import numpy as np

from ..errors import OutputError
from ..images.exr import encode_exr
from ..images.png import encode_png
from ..maths.shadow.projection import LogWarp
from ..pipeline.render_passes import channels_of, pass_named, picture_of
from ..scene import user_files
from ..scene.plain_text import shown_json
from .run import Outcome
from .scratch import PART, beside

_records: ContextVar[tuple[tuple[str, list[Path]], ...]] = ContextVar("cad-shadow-records", default=())
_claims: ContextVar[tuple[dict[Path, str], ...]] = ContextVar("cad-shadow-claims", default=())


@contextmanager
def recorded(owner: str = "") -> Iterator[list[Path]]:
    """A list that while this lasts gets the absolute path of every file written, in order; `owner` is the input that they belong to."""
    paths: list[Path] = []
    token = _records.set((*_records.get(), (owner, paths)))
    try:
        yield paths
    finally:
        _records.reset(token)


@contextmanager
def run_of_results() -> Iterator[None]:
    """While this lasts no file is written for two owners: the second is refused."""
    token = _claims.set((*_claims.get(), {}))
    try:
        yield
    finally:
        _claims.reset(token)


def claim(path: Path, owner: str) -> None:
    """Note that a file was written for `owner`; raises `OutputError` when the same run wrote it for another."""
    for claims in _claims.get():
        if claims.setdefault(path, owner) != owner:
            raise OutputError(f"{path} was written for {claims[path]} in this run: give the results of {owner} another name or folder.")


def check_target(path: Path) -> None:
    """Raise `OutputError` when `path` is there and is not a plain file that may be replaced: a device, a link, an input of this run."""
    try:
        state = path.lstat()
    except (FileNotFoundError, NotADirectoryError):
        return
    except OSError as error:
        raise _cannot(path, error) from error
    except ValueError as error:
        raise _cannot(path, "no file can have this name") from error
    kind = user_files.kind_of(state.st_mode)
    if kind is not None:
        raise OutputError(f"{path} is {kind}, not a file: choose another name.")
    if user_files.is_input(path):
        raise OutputError(f"{path} is an input of this run and stays as it is: choose another name or folder.")
    if not os.access(path, os.W_OK):
        raise OutputError(f"{path} is write-protected and stays as it is: choose another name or folder.")


@contextmanager
def written(path: Path, check: Callable[[Path], None] | None = None) -> Iterator[Path]:
    """A temporary path with the target's suffix to write to; it becomes `path` when the block ends well and vanishes when it does not.

    `check` raises `ValueError` for a file that is not whole: for writers that do not say when the disk is full. Raises `OutputError` when
    the folder cannot be made or written, the target is no plain file or an input of this run, or what was written is not whole.
    """
    path = path.absolute()
    try:
        check_target(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        with beside(path.parent) as place:
            temporary = place / f"{PART}{path.suffix}"
            yield temporary
            _complete(path, temporary, check)
            check_target(path)
            records = _records.get()
            claim(path, records[-1][0] if records else "")
            os.replace(temporary, path)
        for _, paths in records:
            paths.append(path)
    except OSError as error:
        raise _cannot(path, error) from error


def _complete(path: Path, temporary: Path, check: Callable[[Path], None] | None) -> None:
    """Have the disk take all that was written for `path`, and see that it is whole."""
    try:
        with temporary.open("r+b") as file:
            _to_disk(file.fileno())
        if check is not None:
            check(temporary)
    except FileNotFoundError as error:
        raise _cannot(path, "nothing came out") from error
    except ValueError as error:
        raise _cannot(path, f"the file came out damaged: {error}") from error


def _to_disk(handle: int) -> None:
    """Wait until the disk has the file, where the file system can say; only then does it tell of a quota or a full server."""
    try:
        os.fsync(handle)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.ENOSYS, errno.ENOTSUP):
            raise


def _cannot(path: Path, reason: OSError | str) -> OutputError:
    if isinstance(reason, OSError):
        reason = reason.strerror or " ".join(str(reason).split())
    return OutputError(f"{path} cannot be written ({reason}): choose another folder with --output, or make room.")


def write_bytes(path: Path, data: bytes) -> None:
    """Write a whole file; raises `OutputError`."""
    with written(path) as temporary:
        temporary.write_bytes(data)


def json_text(data: object) -> str:
    """JSON without NaN and infinities (a defect if there is one), indented for people; what no terminal or UTF-8 should get as escapes."""
    return shown_json(json.dumps(data, indent=1, ensure_ascii=False, allow_nan=False))


def write_json(path: Path, data: object) -> None:
    """Write a report; raises `OutputError`."""
    write_bytes(path, (json_text(data) + "\n").encode())


def write_pass(path: Path, name: str, outcome: Outcome) -> None:
    """Write one data pass as .png (something to look at) or .exr (exact values), by the path's suffix; raises `OutputError`."""
    passes = outcome.frame.passes
    write_bytes(path, encode_png(picture_of(name, passes)) if path.suffix == ".png" else encode_exr(channels_of(name, passes)))


def npz_arrays(outcome: Outcome, wanted: tuple[str, ...]) -> dict[str, np.ndarray]:
    """An .npz file's arrays, of the images those `wanted`. Matrices start from true world coordinates: the local origin is taken out.

    Where maps are logarithmic, also `shadow_log_warp` (k, 5): scale, offset, base, slope of `LogWarp.t_at`; 1 where s is divided by w.
    """
    job, frame = outcome.job, outcome.frame
    local_from_world = np.eye(4)
    local_from_world[:3, 3] = -job.scene.origin_ws
    names = [pass_named(name).array for name in wanted]
    arrays = {name: frame.passes[name] for name in names if name in frame.passes}
    arrays["view_from_world"] = job.camera.view_from_world @ local_from_world
    arrays["clip_from_view"] = job.camera.clip_from_view
    direction = job.light.direction_ws if job.light else None
    arrays["light_direction"] = np.full(3, np.nan) if direction is None else direction
    projections = frame.plan.projections if frame.plan else ()
    arrays["shadow_clip_from_world"] = np.array([p.clip_from_world @ local_from_world for p in projections]).reshape(-1, 4, 4)
    arrays["partition_bounds"] = np.array([p.depth_range for p in projections]).reshape(-1, 2)
    if any(p.log is not None for p in projections):
        arrays["shadow_log_warp"] = np.array([_log_numbers(p.log) for p in projections])
    return arrays


def _log_numbers(log: LogWarp | None) -> tuple[float, ...]:
    """What `shadow_log_warp` holds of a map; NaN of one that is not logarithmic."""
    return (nan,) * 5 if log is None else (log.scale, log.offset, log.base, log.slope, float(log.perspective_s))


def write_npz(path: Path, outcome: Outcome, wanted: tuple[str, ...]) -> None:
    """Write an .npz file, one per view; raises `OutputError`."""
    buffer = io.BytesIO()
    np.savez(buffer, **npz_arrays(outcome, wanted))
    write_bytes(path, buffer.getvalue())
