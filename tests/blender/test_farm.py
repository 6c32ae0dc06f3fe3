"""As a farm renders: chunks of frames in separate processes give the bytes of one process; the job file fits Flamenco's job type."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import ROOT

TASK = Path(__file__).with_name("farm_task.py")
JOB = ROOT / "docs" / "farm" / "cad_shadow.job.json"
# Flamenco 3.6, SubmittedJob of its API, and the settings of the job type simple-blender-render: (type, required)
JOB_FIELDS = {"name": str, "type": str, "priority": int, "submitter_platform": str, "settings": dict, "metadata": dict}
SETTINGS = {
    "frames": (str, True), "chunk_size": (int, False), "render_output_root": (str, True), "add_path_components": (int, True),
    "render_output_path": (str, True), "blendfile": (str, True), "fps": (int | float, False), "format": (str, True),
    "image_file_extension": (str, True), "has_previews": (bool, False), "scene": (str, True),
}  # fmt: skip


@pytest.fixture
def moving_cube(cube_scene, blend, tmp_path):
    """The cube scene, small, the cube moving and the sun turning; saved."""
    scene, cube = cube_scene, blend.data.objects["Cube"]
    scene.render.resolution_x, scene.render.resolution_y = 64, 48
    scene.cad_shadow.map_size = 128
    scene.render.use_stamp_date = scene.render.use_stamp_render_time = False
    sun = next(o for o in scene.objects if o.type == "LIGHT")
    for frame, x in ((1, -1.0), (4, 1.0)):
        cube.location.x, sun.rotation_euler.x = x, 0.5 + 0.2 * x
        cube.keyframe_insert("location", frame=frame)
        sun.keyframe_insert("rotation_euler", frame=frame)
    path = tmp_path / "moving.blend"
    blend.ops.wm.save_as_mainfile(filepath=str(path))
    return path


@pytest.fixture
def task(tmp_path):
    """Render frames in a process of its own, as a worker's task; gives the folder."""
    user = tmp_path / "user"
    link = user / "extensions" / "user_default" / "cad_shadow_preview"
    link.parent.mkdir(parents=True)
    link.symlink_to(ROOT, target_is_directory=True)

    def render(blend_file, folder, first, last):
        command = [sys.executable, str(TASK), str(blend_file), str(tmp_path / folder / "######"), str(first), str(last)]
        environment = os.environ | {"BLENDER_USER_RESOURCES": str(user)}
        done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=200)
        assert done.returncode == 0, done.stdout + done.stderr
        return tmp_path / folder

    return render


def test_chunks_in_separate_processes_give_the_bytes_of_one_process(moving_cube, task):
    whole = task(moving_cube, "whole", 1, 4)
    task(moving_cube, "chunks", 1, 2)
    chunks = task(moving_cube, "chunks", 3, 4)
    frames = {path.name: path.read_bytes() for path in whole.iterdir()}
    assert sorted(frames) == [f"{n:06d}.png" for n in range(1, 5)]
    assert {path.name: path.read_bytes() for path in chunks.iterdir()} == frames
    assert len(set(frames.values())) == 4, "every frame shows something else"


def test_the_job_file_has_what_flamenco_asks_for():
    job = json.loads(JOB.read_text())
    assert job["type"] == "simple-blender-render"
    assert {name: type(value) for name, value in job.items()} == JOB_FIELDS
    settings = job["settings"]
    assert set(settings) <= set(SETTINGS)
    assert {name for name, (_, required) in SETTINGS.items() if required} <= set(settings)
    assert all(isinstance(value, SETTINGS[name][0]) for name, value in settings.items())
