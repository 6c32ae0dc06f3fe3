"""What the GPU holds from the frame before is used again only when the picture is the same with and without it."""

from dataclasses import replace

import numpy as np
import pytest

from addon.maths.relief.settings import ImpostorSettings
from addon.pipeline import renderer as pipeline
from addon.pipeline import stages
from addon.pipeline.device import device_of
from addon.pipeline.impostors.records import ImpostorChoice, ImpostorGroup
from addon.pipeline.job import Job
from addon.pipeline.render_passes import DATA_PASSES
from addon.pipeline.renderer import render_frame
from addon.settings.groups import Settings
from tests import scenes

SCENES = (scenes.railing(), scenes.chair())


def changed(scene, **columns):
    """The scene with other columns of its instances, by functions of the ones there are."""
    new = {name: make(np.array(getattr(scene.instances, name))) for name, make in columns.items()}
    return replace(scene, instances=replace(scene.instances, **new))


RED = changed(SCENES[0], base_color=lambda c: c * [1.0, 0.2, 0.2, 1.0])
LIFTED = changed(SCENES[0], world_from_object=lambda m: m + np.eye(4, k=1) * [[0.0], [0.0], [0.1], [0.0]])
SCENES += (RED, LIFTED)
CAMERAS = [scenes.look_at(eye, (0.0, 0.0, 0.7), fov_y_deg=35.0, near=1.0, far=80.0) for eye in ((14.0, -16.0, 9.0), (-9.0, -12.0, 4.0))]
LIGHTS = (scenes.sun(40.0), scenes.sun(15.0), None)
CHANGES = {  # a job's field, or a group of the settings' fields
    "scene": SCENES,
    "camera": CAMERAS,
    "light": LIGHTS,
    "size": ((64, 48), (48, 64)),
    "shown": (None, "first"),
    "impostors": (None, None, "last"),
    "warp": ({"kind": "lispsm-general"}, {"kind": "uniform"}, {"kind": "logpsm"}),
    "partition": ({"kind": "none"}, {"kind": "z-log"}),
    "fit": ({"kind": "samples", "size": 64}, {"kind": "scene", "size": 64}, {"kind": "samples", "size": 96}),
    "test": (
        {"kind": "depth"},
        {"kind": "id-depth"},
        {"kind": "id-depth", "id_per_material": True},
        {"kind": "depth", "depths": 2, "pcf": 4},
        {"kind": "triangle"},
        {"kind": "triangle", "outlines": True},
        {"kind": "depth", "bias_strategy": "constant", "bias": 0.01},
    ),
    "shading": ({"samples": 1}, {"samples": 4}, {"display": "aliasing", "samples": 1}),
}


def job_of(chosen):
    scene = chosen["scene"]
    groups = {name: chosen[name] for name in ("warp", "partition", "fit", "test", "shading")}
    shown = np.arange(len(scene.instances)) < 1 if chosen["shown"] else None
    last = ImpostorGroup("last", (len(scene.object_names) - 1,))
    impostors = ImpostorChoice((last,), ImpostorSettings(break_even=False)) if chosen["impostors"] else None
    return Job(
        scene,
        chosen["camera"],
        chosen["light"],
        Settings().replaced(**groups),
        chosen["size"],
        ("combined", *DATA_PASSES),
        impostors=impostors,
        shown=None if impostors else shown,
    )


def forget(device):
    """As if the device had drawn nothing yet."""
    device.plan = None
    for kind, (_, kept) in device._kept.items():
        if kind == "shadow" or kind.startswith(("gbuffer", "shade")):
            kept.holds = None
        elif kind == "mean":
            kept.target.holds = None


def differing(kept, anew):
    return [name for name, image in anew.passes.items() if not np.array_equal(image, kept.passes[name], equal_nan=True)]


def test_pictures_are_those_of_a_renderer_that_remembers_nothing(worker, rng):
    """A walk over everything that can change, at most two things a step, back to what was there before as often as on.

    Impostors have a life of their own from frame to frame; they are drawn in between, and must leave nothing behind.
    """
    chosen = {name: values[0] for name, values in CHANGES.items()}

    def step(context):
        device, job = device_of(context, worker), job_of(chosen)
        kept = render_frame(device, job, pipeline.Ticket())
        forget(device)
        return kept, render_frame(device, job, pipeline.Ticket())

    for _ in range(60):
        for name in rng.choice(list(CHANGES), size=rng.integers(0, 3), replace=False):
            chosen[name] = CHANGES[name][rng.integers(len(CHANGES[name]))]
        kept, anew = worker.call(step)
        assert chosen["impostors"] or differing(kept, anew) == [], chosen


@pytest.mark.parametrize(
    ("name", "value", "drawn"),
    [
        ("shading", {"display": "aliasing", "samples": 1}, []),
        ("test", {"kind": "depth", "bias_strategy": "constant", "bias": 0.01}, []),
        ("test", {"kind": "id-depth"}, ["maps"]),
        ("warp", {"kind": "uniform"}, ["maps"]),
        ("light", LIGHTS[1], ["maps"]),
        ("camera", CAMERAS[1], ["surfaces", "maps"]),
        ("scene", scenes.open_sheet(), ["surfaces", "maps"]),
        ("scene", RED, []),
        ("scene", LIFTED, ["surfaces", "maps"]),
    ],
)
def test_only_what_a_change_touches_is_drawn_again(worker, monkeypatch, name, value, drawn):
    seen = []

    def noted(what, function):
        return lambda *args: (seen.append(what), function(*args))[1]

    monkeypatch.setattr(stages, "draw_gbuffer", noted("surfaces", stages.draw_gbuffer))
    monkeypatch.setattr(stages, "draw_shadow_maps", noted("maps", stages.draw_shadow_maps))
    chosen = {key: values[0] for key, values in CHANGES.items()}
    worker.call(lambda context: render_frame(device_of(context, worker), job_of(chosen), pipeline.Ticket()))
    seen.clear()
    worker.call(lambda context: render_frame(device_of(context, worker), job_of({**chosen, name: value}), pipeline.Ticket()))
    assert seen == drawn


@pytest.mark.parametrize("samples", [1, 4])
def test_asked_again_nothing_is_drawn_and_nothing_shaded(worker, monkeypatch, samples):
    chosen = {key: values[0] for key, values in CHANGES.items()} | {"shading": {"samples": samples}}

    def asked(context):
        device = device_of(context, worker)
        shaded = []
        with monkeypatch.context() as patch:
            draw = device.shade_pass.draw
            patch.setattr(device.shade_pass, "draw", lambda *a, **k: (shaded.append(1), draw(*a, **k))[1])
            first, again = (render_frame(device, job_of(chosen), pipeline.Ticket()) for _ in range(2))
        return shaded, differing(first, again)

    worker.call(asked)
    shaded, wrong = worker.call(asked)
    assert shaded == [] and wrong == []
