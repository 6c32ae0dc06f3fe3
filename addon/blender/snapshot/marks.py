"""Which objects and collections are marked as impostors, and which of them a drawn instance belongs to.

A mark is a switch of the object or collection itself, so it is saved, copied, undone and renamed with it. A marked empty stands for all
objects below it (an assembly of a CAD file). Where several hold, the narrowest counts: an object's own mark, then that of the nearest
marked empty above it, then that of the smallest collection it is in.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import bpy
import numpy as np

from ...scene.records import Mark
from .instances import MarkOf

PROPERTY = "cad_shadow_impostor"


def marked(holders: bpy.types.bpy_prop_collection) -> list[bpy.types.ID]:
    """The marked ones of `bpy.data.objects` or `bpy.data.collections`. Fast, also where there are many and none is marked."""
    if not len(holders) or not hasattr(type(holders[0]), PROPERTY):
        return []
    flags = np.zeros(len(holders), dtype=bool)
    holders.foreach_get(PROPERTY, flags)
    return [one for one, is_marked in zip(holders, flags, strict=True) if is_marked] if flags.any() else []


def mark_of_id(holder: bpy.types.ID) -> Mark:
    """The mark of an object or a collection."""
    return Mark("collection" if isinstance(holder, bpy.types.Collection) else "object", holder.session_uid, name=holder.name)


def mark_reader(instead: Sequence[bpy.types.ID] | None = None) -> MarkOf | None:
    """A function from a depsgraph's instance to the impostor it belongs to; None when nothing is marked.

    `instead` of the file's marks these objects and collections count as marked, and nothing else.
    """
    holders = [*marked(bpy.data.collections), *marked(bpy.data.objects)] if instead is None else instead
    groups = [(holder, members_of(holder)) for holder in holders]
    wide = sorted(groups, key=lambda group: (not isinstance(group[0], bpy.types.Collection), -len(group[1])))
    by_object = {ob.session_uid: mark_of_id(holder) for holder, members in wide for ob in members}
    by_object |= {holder.session_uid: mark_of_id(holder) for holder, _ in groups if isinstance(holder, bpy.types.Object)}
    return _reader(by_object) if by_object else None


def members_of(holder: bpy.types.ID) -> list[bpy.types.Object]:
    """The objects that a marked object or collection stands for."""
    if isinstance(holder, bpy.types.Collection):
        return list(holder.all_objects)
    if holder.type == "EMPTY" and holder.instance_type != "COLLECTION":
        return [holder, *holder.children_recursive]
    return [holder]


def _reader(by_object: dict[int, Mark]) -> MarkOf:
    def mark_of(instance: bpy.types.DepsgraphObjectInstance) -> Mark | None:
        if not instance.is_instance:
            return by_object.get(instance.object.original.session_uid)
        owner = instance.parent.original.session_uid
        if owner in by_object:
            return by_object[owner]
        mark = by_object.get(instance.object.original.session_uid)
        if mark is None:
            return None
        return replace(mark, place=(owner,) if mark.kind == "collection" else _place(owner, instance.persistent_id))

    return mark_of


def _place(owner: int, persistent_id: Iterable[int]) -> tuple[int, ...]:
    return owner, *persistent_id
