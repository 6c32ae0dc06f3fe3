"""Light linking: which objects a light lights, and which stand in its way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import bpy
import numpy as np

KINDS = ("receiver", "blocker")


@dataclass(frozen=True, slots=True)
class Linked:
    """Names of objects: `only` those (None: all) but `never` those."""

    only: frozenset[str] | None
    never: frozenset[str]

    def left_out(self, names: Sequence[str]) -> np.ndarray:
        """(N,) bool: which of these objects it does not concern."""
        return np.array([name in self.never or (self.only is not None and name not in self.only) for name in names], dtype=bool)


def links_of(ob: bpy.types.Object) -> tuple[Linked, Linked] | None:
    """Whom a light object lights and who blocks it; None where it has no linking, as in Blender before 4.3 and for most lights."""
    linking = getattr(ob.original, "light_linking", None)
    collections = [getattr(linking, f"{kind}_collection", None) for kind in KINDS]
    return None if not any(collections) else tuple(_linked(collection) for collection in collections)


def _linked(collection: bpy.types.Collection | None) -> Linked:
    if collection is None:
        return Linked(None, frozenset())
    found: dict[str, set[str]] = {"INCLUDE": set(), "EXCLUDE": set()}
    for ob, entry in zip(collection.objects, collection.collection_objects, strict=True):
        found[entry.light_linking.link_state].add(ob.name)
    for child, entry in zip(collection.children, collection.collection_children, strict=True):
        found[entry.light_linking.link_state].update(ob.name for ob in child.all_objects)
    return Linked(frozenset(found["INCLUDE"]) if found["INCLUDE"] else None, frozenset(found["EXCLUDE"]))
