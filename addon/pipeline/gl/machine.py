"""How this computer is to be used for rendering: chosen once for all pictures (Blender's preferences), not per scene. No OpenGL."""

from __future__ import annotations

from dataclasses import dataclass

from ...errors import GpuError

BACKENDS = ("auto", "egl", "native")

MEBI = 2**20
MOST_SAMPLES = 768 * MEBI
"""Bytes of the largest picture of camera samples: 4 of each pixel of 2560 × 1440, 9 of 1920 × 1080."""


@dataclass(frozen=True)
class Machine:
    """`backend` one of `BACKENDS`; `threads` of a software OpenGL driver, 0 = its own choice; `memory_mib` for the targets and maps of
    one picture, 0 = no limit; `is_separate` True renders in a process of its own, which may crash without taking Blender along."""

    backend: str = "auto"
    threads: int = 0
    memory_mib: int = 0
    is_separate: bool = False

    def __post_init__(self) -> None:
        if self.backend not in BACKENDS or self.threads < 0 or self.memory_mib < 0:
            raise ValueError(f"not a machine: {self}")


def backends_on(platform: str) -> tuple[str, ...]:
    """Those of `BACKENDS` that there are on a platform, as `sys.platform` names it."""
    return BACKENDS if platform.startswith("linux") else ("auto", "native")


_chosen = [Machine()]


def chosen() -> Machine:
    """The machine to render with."""
    return _chosen[0]


def choose(machine: Machine) -> bool:
    """Render with this machine from the next start of the worker on; True when it differs from the one before."""
    before, _chosen[0] = _chosen[0], machine
    return before != machine


_described: dict[str, object] = {}


def note_context(backend: str, info: dict[str, object]) -> None:
    """Remember what the context of this process says of itself: `moderngl.Context.info`, and how it was made."""
    names = ("GL_VENDOR", "GL_RENDERER", "GL_VERSION", "GL_MAX_TEXTURE_SIZE", "GL_MAX_ARRAY_TEXTURE_LAYERS", "GL_MAX_TEXTURE_BUFFER_SIZE")
    _described.update(made_by=backend, **{name: info[name] for name in names if name in info})


def described() -> dict[str, object]:
    """What the last context of this process has said of itself; empty before there was one."""
    return dict(_described)


def check_picture(size: tuple[int, int], data: bool) -> None:
    """Raise `GpuError` when the camera's targets alone pass the memory limit. Bytes per pixel: G-buffer 20, picture 16, data 40."""
    _check(size[0] * size[1] * (36 + 40 * data), f"A picture of {size[0]}×{size[1]} pixels", "choose a smaller size")


def spare_bytes(size: tuple[int, int], data: bool) -> int:
    """What the memory limit leaves beside the camera's targets, at most `MOST_SAMPLES`."""
    limit = chosen().memory_mib * MEBI
    return max(0, min(limit - size[0] * size[1] * (36 + 40 * data), MOST_SAMPLES)) if limit else MOST_SAMPLES


def check_maps(size: int, layers: int, ids: int, doubled: bool) -> None:
    """Raise `GpuError` when the shadow maps pass the memory limit. Bytes per texel: depth 4, each id 4; with depths per cell or outlines
    (`doubled`) twice that."""
    wanted = size * size * layers * (4 + 4 * ids) * (1 + doubled)
    _check(wanted, f"{layers} shadow map{'s' * (layers > 1)} of {size}² texels", "lower Map Size or Partitions")


def check_layers(size: tuple[int, int], layers: int, each: int = 20) -> None:
    """Raise `GpuError` when the layers of what is see-through pass the memory limit, at so many bytes a pixel."""
    what = f"{layers} layers of what is see-through, {size[0]}×{size[1]} pixels each,"
    _check(size[0] * size[1] * each * layers, what, "choose a smaller size")


def check_panes(side: int, maps: int, layers: int) -> None:
    """Raise `GpuError` when the layers of what tints light pass the memory limit. Bytes per texel: 8; 20 of those in the making."""
    wanted = side * side * (8 * maps * layers + 20)
    _check(wanted, f"{layers} layers of transparent casters before {maps} shadow maps", "lower Map Size or Partitions")


def _check(wanted: int, what: str, advice: str) -> None:
    limit = chosen().memory_mib
    if limit and wanted > limit * MEBI:
        raise GpuError(
            f"{what} would take {-(-wanted // MEBI):,} MiB of graphics memory, more than the {limit:,} MiB allowed: {advice}, or raise "
            "Memory Limit in the extension's preferences."
        )
