"""From marks and settings to what the renderer is asked about impostors. Used by every face; no bpy.

The pipeline is imported when something is marked, not before, so that enabling the add-on stays quick.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import replace
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np

from ...scene.records import Mark, Scene
from ..run import submit, submit_task

if TYPE_CHECKING:
    from ...errors import GpuError, SceneError
    from ...maths.relief.settings import ImpostorSettings
    from ...maths.relief.warp import CaptureFrame
    from ...pipeline.impostors.baked import BakedImpostor
    from ...pipeline.impostors.records import ImpostorChoice, ImpostorGroup
    from ...pipeline.job import Job
    from ..pending import Pending
    from ..run import Outcome

TRIANGLE_NS, PIXEL_NS = 60.0, 150.0
"""The break-even of fresh pictures: fixed, since what is measured differs from run to run, and they must not."""
AS_LONG_AS_THE_USER_WANTS = 1e12
"""How many times over its limit an error may be before geometry is drawn, where it is the user who says when to capture anew."""


_groups: WeakKeyDictionary[Scene, tuple[ImpostorGroup, ...]] = WeakKeyDictionary()


def groups_of(scene: Scene) -> tuple[ImpostorGroup, ...]:
    """The impostors marked in a scene, in the order of their first object. Looked up once for each scene."""
    if scene not in _groups:
        _groups[scene] = _found(scene)
    return _groups[scene]


def _found(scene: Scene) -> tuple[ImpostorGroup, ...]:
    from ...pipeline.impostors.records import ImpostorGroup

    members: dict[Mark, list[int]] = {}
    for object_id, mark in enumerate(scene.marks):
        if mark is not None:
            members.setdefault(mark, []).append(object_id)
    return tuple(ImpostorGroup(mark, tuple(ids), mark.name) for mark, ids in members.items())


def whole(scene: Scene, name: str) -> tuple[ImpostorGroup, ...]:
    """The whole scene as one impostor."""
    from ...pipeline.impostors.records import ImpostorGroup

    return (ImpostorGroup(Mark("scene", 0, name=name), tuple(range(len(scene.object_names))), name),)


def choice_of(
    scene: Scene, settings: ImpostorSettings, *, fresh: bool = False, regenerate: frozenset[Hashable] = frozenset()
) -> ImpostorChoice | None:
    """What a picture of `scene` asks for; None when nothing is marked or impostors are off.

    `fresh`: all captured for this picture, whatever was before (the settings' use 'manual' is not: its textures are the user's).
    """
    if settings.use == "off" or not scene.marks or not groups_of(scene):
        return None
    return choice_for(groups_of(scene), settings, fresh=fresh, regenerate=regenerate)


def choice_for(
    groups: tuple[ImpostorGroup, ...],
    settings: ImpostorSettings,
    *,
    fresh: bool = False,
    exact: bool = False,
    regenerate: frozenset[Hashable] = frozenset(),
) -> ImpostorChoice:
    """The choice for given groups; `exact` also computes the predictor whose cost grows with the texture."""
    from ...maths.relief.life import LifeModel
    from ...maths.relief.settings import ALL_AT_ONCE
    from ...pipeline.impostors.records import ImpostorChoice

    alone = fresh and settings.use == "automatic"
    model = LifeModel(waiting=AS_LONG_AS_THE_USER_WANTS) if settings.use == "manual" else LifeModel()
    costs = {"triangle_ns": TRIANGLE_NS, "pixel_ns": PIXEL_NS} if alone else {}
    lived = replace(
        settings,
        break_even=settings.break_even and settings.use == "automatic",
        regenerations=ALL_AT_ONCE if alone else settings.regenerations,
    )
    return ImpostorChoice(groups, lived, model, regenerate=regenerate, exact=exact, alone=alone, **costs)


def baked(job: Job, groups: tuple[ImpostorGroup, ...], unlit: bool = False) -> list[BakedImpostor | SceneError | GpuError]:
    """The impostors of `groups` captured from the job's camera, read back, waited for; in the place of one that could not be, its error."""
    return baking(job, groups, unlit).result()


def baking(job: Job, groups: tuple[ImpostorGroup, ...], unlit: bool = False) -> Pending[list[BakedImpostor | SceneError | GpuError]]:
    """The same, not waited for."""
    from ...pipeline.bake import bake_all

    return submit_task(bake_all, job, choice_for(groups, job.settings.impostor), unlit)


def shaded_texture(job: Job, group: ImpostorGroup, frame: CaptureFrame) -> Pending[Outcome]:
    """The group as the camera of `frame` sees it, alone before nothing, in the job's light: the colours of a texture captured earlier."""
    settings = job.settings.replaced(shading={"background": (0.0, 0.0, 0.0, 0.0), "display": "shaded"})
    rows = np.isin(job.scene.instances.object_id, group.object_ids)
    alone = replace(
        job,
        camera=frame.camera(),
        settings=settings,
        size=(frame.width, frame.height),
        passes=("combined",),
        measure=False,
        impostors=None,
        shown=rows,
    )
    return submit(alone)
