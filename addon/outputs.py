"""The one place where results are written: into a temporary file beside the target, renamed when complete. No half file is ever left."""

from __future__ import annotations

import io
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from .errors import OutputError
from .images.exr import encode_exr
from .images.passes import channels_of, picture_of
from .images.png import encode_png
from .job import Outcome

_records: list[list[Path]] = []


@contextmanager
def recorded() -> Iterator[list[Path]]:
    """A list that while this lasts gets the absolute path of every file written, in order."""
    paths: list[Path] = []
    _records.append(paths)
    try:
        yield paths
    finally:
        _records.remove(paths)


@contextmanager
def written(path: Path) -> Iterator[Path]:
    """A temporary path with the target's suffix to write to; it becomes `path` when the block ends well and vanishes when it does not.

    Raises `OutputError` when the folder cannot be made or written.
    """
    path = path.absolute()
    temporary = path.with_name(f".{path.stem}.{os.getpid()}.part{path.suffix}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary.touch()
        yield temporary
        os.replace(temporary, path)
        for paths in _records:
            paths.append(path)
    except OSError as error:
        reason = error.strerror or str(error)
        raise OutputError(f"{path} cannot be written ({reason}): choose another folder with --output, or make room.") from error
    finally:
        temporary.unlink(missing_ok=True)


def write_bytes(path: Path, data: bytes) -> None:
    """Write a whole file; raises `OutputError`."""
    with written(path) as temporary:
        temporary.write_bytes(data)


def json_text(data: object) -> str:
    """JSON without NaN and infinities (a defect if there is one), indented for people."""
    return json.dumps(data, indent=1, ensure_ascii=False, allow_nan=False)


def write_json(path: Path, data: object) -> None:
    """Write a report; raises `OutputError`."""
    write_bytes(path, (json_text(data) + "\n").encode())


def write_pass(path: Path, name: str, outcome: Outcome) -> None:
    """Write one data pass as .png (something to look at) or .exr (exact values), by the path's suffix; raises `OutputError`."""
    passes = outcome.frame.passes
    write_bytes(path, encode_png(picture_of(name, passes)) if path.suffix == ".png" else encode_exr(channels_of(name, passes)))


def npz_arrays(outcome: Outcome, wanted: tuple[str, ...]) -> dict[str, np.ndarray]:
    """The contract's arrays, of the images those `wanted`. Matrices start from true world coordinates: the local origin is taken out."""
    job, frame = outcome.job, outcome.frame
    local_from_world = np.eye(4)
    local_from_world[:3, 3] = -job.scene.origin_ws
    names = ["shadow_depth" if name == "texel" else name for name in wanted]
    arrays = {name: frame.passes[name] for name in names if name in frame.passes}
    arrays["view_from_world"] = job.camera.view_from_world @ local_from_world
    arrays["clip_from_view"] = job.camera.clip_from_view
    direction = job.light.direction_ws if job.light else None
    arrays["light_direction"] = np.full(3, np.nan) if direction is None else direction
    projections = frame.plan.projections if frame.plan else ()
    arrays["shadow_clip_from_world"] = np.array([p.clip_from_world @ local_from_world for p in projections]).reshape(-1, 4, 4)
    arrays["partition_bounds"] = np.array([p.depth_range for p in projections]).reshape(-1, 2)
    return arrays


def write_npz(path: Path, outcome: Outcome, wanted: tuple[str, ...]) -> None:
    """Write the contract's `npz`, one file per view; raises `OutputError`."""
    buffer = io.BytesIO()
    np.savez(buffer, **npz_arrays(outcome, wanted))
    write_bytes(path, buffer.getvalue())
