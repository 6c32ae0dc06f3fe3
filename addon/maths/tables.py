"""Tables whose rows live in one module each: whoever adds a kind adds a module to the table's package, and nothing else."""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules
from typing import Any


def rows_of(package: str, path: list[str]) -> dict[str, Any]:
    """The `ROW` of each module of a package that has one, by its `name`, ordered by its `place`.

    Called in the package's `__init__.py` with its `__name__` and `__path__`.
    """
    modules = [import_module(f"{package}.{found.name}") for found in iter_modules(path)]
    rows = sorted((module.ROW for module in modules if hasattr(module, "ROW")), key=lambda row: row.place)
    named = {row.name: row for row in rows}
    if len(named) < len(rows) or len({row.place for row in rows}) < len(rows):
        raise ValueError(f"two rows of {package} have one name or one place: {[(row.name, row.place) for row in rows]}")
    return named
