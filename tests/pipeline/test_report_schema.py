"""Reports are as the schema that ships says: addon/studies/report_schema.json."""

import json

import pytest

from addon.maths.relief.settings import ImpostorSettings
from addon.pipeline.impostors.records import ImpostorChoice, ImpostorGroup
from addon.pipeline.job import Job
from addon.settings.groups import Settings
from addon.studies.outputs import json_text
from addon.studies.report import failed_report
from addon.studies.run import run
from tests import scenes
from tests.schema import REPORT, faults

CAMERA, SUN = scenes.look_at((7.0, -8.0, 5.0), (0.0, 0.0, 0.7), near=1.0, far=60.0), scenes.sun(40.0)
SMALL = Settings().replaced(fit={"size": 64})
IMPOSTORS = ImpostorChoice((ImpostorGroup("box", (1,), "box"),), ImpostorSettings(break_even=False), alone=True)


def written(report):
    """As it is read from its file."""
    return json.loads(json_text(report))


@pytest.mark.parametrize("light", [SUN, None], ids=["sun", "no light"])
@pytest.mark.parametrize("choice", [None, IMPOSTORS], ids=["geometry", "impostors"])
@pytest.mark.parametrize("warp", ["lispsm-general", "uniform", "log"])
def test_a_report_is_as_the_schema_says_and_every_key_is_described(renderer, light, choice, warp):
    settings = SMALL.replaced(warp={"kind": warp}, test={"kind": "id-depth"})
    report = written(run(Job(scenes.closed_box(), CAMERA, light, settings, (48, 32), impostors=choice), on=renderer).report)
    assert not list(faults(report, REPORT))
    assert set(report) <= set(REPORT["properties"]), "a new key is described in addon/studies/report_schema.json"
    for partition in report["partitions"]:
        assert set(partition) <= set(REPORT["$defs"]["partition"]["properties"])
    assert bool(report.get("impostors")) == (choice is not None)


def test_the_report_of_a_failure_is_as_the_schema_says():
    assert not list(faults(written(failed_report("a.stl", None, "It cannot be read.")), REPORT))
    assert not list(faults(written(failed_report("a.stl", SMALL, "It cannot be read.")), REPORT))


@pytest.mark.parametrize(
    ("key", "value"),
    [("errors", None), ("errors", [1]), ("partitions", [{}]), ("gamma_deg", "1"), ("geometry", {"meshes": 1.5}), ("timing_ms", {})],
)
def test_a_report_that_is_not_so_would_be_found(key, value):
    report = written(failed_report("a.stl", SMALL, "It cannot be read."))
    assert list(faults({**report, key: value}, REPORT))
    del report[key]
    assert list(faults(report, REPORT)) == [f"report has no {key}"]
