"""Which choices mean something together: one rule for panels, command line, scripts and settings files. No bpy."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any

from ..maths import choices
from ..maths.partitioning import PARTITION_SCHEMES
from ..maths.warping import WARP_METHODS
from .groups import Settings
from .impostor_options import IMPOSTOR_APPLIES
from .light_options import LIGHTS_APPLY
from .options import BY_NAME, OPTIONS, values_of
from .shadowing import SHADOW_TESTS
from .stage_options import STAGE_APPLIES


def applies(name: str, values: object) -> bool:
    """Whether option `name` changes anything, given the other options as attributes of `values`; panels hide what does not."""
    rule = _APPLIES.get(name)
    return True if rule is None else rule(values)


def unsuited(name: str, identifier: str, light_type: str | None) -> str | None:
    """Why choosing `identifier` for option `name` means nothing under a light of Blender's type 'SUN', 'SPOT' or 'POINT'; None if it does.

    `light_type` None: there is no light, a sun will be made.
    """
    return choices.unsuited(name, identifier, "sun" if light_type is None else light_type.lower())


def idle(given: Iterable[str], settings: Settings) -> tuple[str, ...]:
    """One line for each of the options `given` by name that changes nothing with the others of `settings`, with those that make it so."""
    values = values_of(settings)
    lines = []
    for name in given:
        read = _Read(values)
        if name in _APPLIES and not _APPLIES[name](read):
            because = ", ".join(f"{other} = {_shown(values[other])}" for other in read.names)
            lines.append(f"'{name}' changes nothing with {because}: leave it out, or change that.")
    return tuple(lines)


def _shown(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def named(content: Mapping[str, object]) -> tuple[str, ...]:
    """Names of the options that a settings file speaks of: all at its top, and those of its tables that are not the default.

    (Tables are copied whole from a report: what stands at its default there was hardly asked for.)
    """
    names = [name.replace("-", "_") for name, value in content.items() if not isinstance(value, Mapping)]
    for option in OPTIONS:
        group, field = option.targets[0]
        table = content.get(group)
        if isinstance(table, Mapping) and field in table and table[field] != _plain(BY_NAME[option.name].default):
            names.append(option.name)
    return tuple(names)


def _plain(value: object) -> object:
    """As TOML would give it."""
    return list(value) if isinstance(value, tuple) else value


class _Read:
    """The values by attribute, and the names of those that were looked at."""

    def __init__(self, values: dict[str, object]) -> None:
        self._values = values
        self.names: dict[str, None] = {}

    def __getattr__(self, name: str) -> object:
        self.names[name] = None
        return self._values[name]


def _is_of_test(name: str, values: Any) -> bool:
    """Whether the shadow test chosen has that option."""
    return name in SHADOW_TESTS[values.test].options


def _is_of_scheme(name: str, values: Any) -> bool:
    """Whether the partition scheme chosen has that option."""
    return name in PARTITION_SCHEMES[values.partition].options


def _is_sliced(values: Any) -> bool:
    """Whether the view is divided in depth alone."""
    scheme = PARTITION_SCHEMES[values.partition]
    return scheme.divides_depth and not scheme.has_faces


_APPLIES: dict[str, Callable[[Any], bool]] = {
    "eta": lambda v: WARP_METHODS[v.warp].is_warped,
    "warp_parameter": lambda v: WARP_METHODS[v.warp].is_warped,
    "pseudo_near": lambda v: WARP_METHODS[v.warp].is_warped or _is_of_scheme("pseudo_near", v),
    "log_bend": lambda v: WARP_METHODS[v.warp].bends,
    "convergence": lambda v: WARP_METHODS[v.warp].fades,
    "partitions": lambda v: PARTITION_SCHEMES[v.partition].divides_depth,
    "cut": lambda v: _is_sliced(v) and v.partitions > 1,
    "split_weight": partial(_is_of_scheme, "split_weight"),
    "alpha": lambda v: _is_of_scheme("alpha", v) and v.partitions > 1,
    **{name: partial(_is_of_test, name) for test in SHADOW_TESTS.values() for name in test.options},
    "smoothing": lambda v: _is_of_test("smoothing", v) and str(v.pcf) == "1",
    "bias": lambda v: _is_of_test("bias", v) and v.bias_strategy != "automatic",
    "filter_unit": lambda v: str(v.pcf) != "1",
    "filter_width": lambda v: str(v.pcf) != "1",
    "caster_error": lambda v: _is_of_test("caster_error", v) and v.casters != "full",
    "clay": lambda v: not v.use_object_colors,
    "exposure": lambda v: v.display == "shaded",
    **LIGHTS_APPLY,
    **STAGE_APPLIES,
    **IMPOSTOR_APPLIES,
}
