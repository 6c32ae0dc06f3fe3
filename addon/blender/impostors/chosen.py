"""Which impostors a command or a script means: those it names, else those marked, else everything as one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import bpy

from ...errors import SceneError
from ...scene.records import Scene
from ...studies.impostors.asked import groups_of, whole
from ..snapshot import mark_of_id
from ..snapshot.instances import listed
from .marks import all_marked, named

if TYPE_CHECKING:
    from ...pipeline.impostors.records import ImpostorGroup

NO_SURFACE = "{} has no surface that the render shows: name an object with a mesh, or unhide it."


@dataclass(frozen=True)
class ChosenImpostors:
    """Which impostors there are in the open file: those named, else those marked, else everything as one, called `name`."""

    holders: list[bpy.types.ID]
    name: str

    @classmethod
    def of(cls, names: Sequence[str] | None, name: str) -> ChosenImpostors:
        """Raises `SceneError` for a name that nothing has."""
        return cls([holder for one in names for holder in named(one)] if names else all_marked(), name)

    def groups(self, scene: Scene) -> tuple[ImpostorGroup, ...]:
        """The impostors of a scene that was read while these were the marks."""
        return groups_of(scene) if self.holders else whole(scene, self.name)

    def some(self, scene: Scene) -> tuple[ImpostorGroup, ...]:
        """The same; raises `SceneError` when not one of them has anything to draw."""
        groups = self.groups(scene)
        if not any(group.object_ids for group in groups):
            raise SceneError(NO_SURFACE.format(listed([holder.name for holder in self.holders]) or f"'{self.name}'"))
        return groups

    def missing(self, groups: tuple[ImpostorGroup, ...]) -> list[str]:
        """What to say of those that have nothing to draw."""
        found = {(group.key.kind, group.key.uid) for group in groups}
        marks = map(mark_of_id, self.holders)
        return [NO_SURFACE.format(f"'{mark.name}'") for mark in marks if (mark.kind, mark.uid) not in found]
