"""compare of a picture that several or soft lights light: its main light alone is held against rays."""

from dataclasses import replace
from math import radians

import numpy as np
import pytest

from addon.maths.view import Light
from addon.pipeline.job import Job
from addon.settings.groups import Settings
from addon.studies.run import run
from addon.studies.truth.against import against_truth
from addon.studies.truth.compare import COMPARED_PASSES
from tests import scenes

pytest.importorskip("embreex")


def test_of_several_lights_the_main_one_is_held_against_its_rays():
    camera = scenes.look_at((14.0, -16.0, 9.0), (0.0, 0.0, 0.7), fov_y_deg=35.0, near=1.0, far=80.0)
    sun = replace(scenes.sun(40.0), half_angle_rad=radians(5.0), name="sun")
    lamp = Light("point", None, np.array([2.0, -2.5, 4.0]), color=(90.0, 90.0, 90.0))
    settings = Settings().replaced(fit={"size": 256}, lights={"samples": 4})
    outcome = run(Job(scenes.closed_box(), camera, sun, settings, (96, 64), ("combined", *COMPARED_PASSES), others=(lamp,)))
    against_truth(outcome)
    assert outcome.report["truth"]["misclassified_pct"] < 0.5
    assert any("'sun' alone" in line for line in outcome.report["warnings"])
