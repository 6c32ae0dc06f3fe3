"""A disk that fails at any write of a command costs no file: each is the old one or a whole new one, and one line says so.

Every write of every way is tried by `python -m benchmarks.faults`; here one in several of them.
"""

import sys

import pytest

from benchmarks import disk_faults
from tests.blender.user_folder import posix

WAYS = {"preview": 5, "preview batch": 14, "theory": 3}


@posix
@pytest.mark.parametrize("way", WAYS)
def test_a_disk_that_fails_costs_no_file_and_says_so(main, tmp_path, way):
    command = disk_faults.Command(main, way, tmp_path)
    assert {"os.mkdir", "open", "os.fsync", "os.rename"} <= set(command.points)
    found = list(command.faults(WAYS[way]))
    assert len(found) >= 3
    assert not [fault for fault in found if fault.wrong]


def test_every_command_that_writes_is_among_those_tried(room):
    named = {name.split()[0] for name in disk_faults.COMMANDS}
    assert named | disk_faults.LEFT_OUT == set(room("cli.commands").COMMANDS)
    assert not named & disk_faults.LEFT_OUT


@pytest.mark.skipif(sys.platform == "win32", reason="files are replaced")
def test_the_hook_sees_what_is_written_in_a_folder_and_nothing_else(tmp_path):
    inside, outside = tmp_path / "in", tmp_path / "out"
    for folder in (inside, outside):
        folder.mkdir()
    with disk_faults.failing(disk_faults.Disk(str(inside))) as disk:
        for folder in (inside, outside):
            (folder / "a").write_bytes(b"a")
            (folder / "a").read_bytes()
            (folder / "a").rename(folder / "b")
    assert disk.passed == ["open", "os.rename"]
    with disk_faults.failing(disk_faults.Disk(str(inside), 0)), pytest.raises(OSError, match="No space"):
        (inside / "c").write_bytes(b"c")
    (inside / "c").write_bytes(b"c")
