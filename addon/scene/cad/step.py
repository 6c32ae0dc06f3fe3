"""STEP through cascadio (OpenCASCADE), which tessellates to a GLB in metres, Z up."""

from __future__ import annotations

import tempfile
from pathlib import Path

from ...errors import CadFileError
from .cad_format import CadFormat, starts_text
from .gltf import read_glb_bytes
from .raw import RawFile

LINEAR_TOLERANCE, ANGULAR_TOLERANCE_RAD = 0.01, 0.5


def read_step(path: Path) -> RawFile:
    """A `.step` or `.stp` file; chord tolerance `LINEAR_TOLERANCE` in the file's unit, `ANGULAR_TOLERANCE_RAD` between facets."""
    try:
        import cascadio
    except ImportError as error:
        raise CadFileError(
            f"{path.name} is a STEP file, and the reader for STEP (cascadio) is not installed: use the zip for your platform."
        ) from error
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "model.glb"
        status = cascadio.step_to_glb(str(path), str(out), LINEAR_TOLERANCE, ANGULAR_TOLERANCE_RAD, merge_primitives=False)
        if status != 0 or not out.exists():
            raise CadFileError(f"{path.name} cannot be read as STEP: it may be damaged. Export it again as AP203, AP214 or AP242.")
        return read_glb_bytes(out.read_bytes(), path)


IS_STEP = starts_text(rb"ISO-10303-21")
ROW = CadFormat("STEP", {".step": IS_STEP, ".stp": IS_STEP}, read_step, place=10, fixes_unit=True)
