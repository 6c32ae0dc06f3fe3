"""No file of the user is lost: what is replaced, what is refused, what a full disk does, what is left behind."""

import errno
import os
import socket
import stat
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

from addon.errors import OutputError
from addon.images.exr import encode_exr
from addon.images.png import encode_png
from addon.images.whole import check_picture
from addon.scene import user_files
from addon.studies import outputs, scratch

posix = pytest.mark.skipif(sys.platform == "win32", reason="named pipes, links and modes as POSIX has them")
OLD = b"what the user had"


@pytest.fixture
def old(tmp_path):
    path = tmp_path / "out" / "picture.png"
    path.parent.mkdir()
    path.write_bytes(OLD)
    return path


def only(path):
    """Whether a folder holds this file, as it was, and nothing else, hidden or not."""
    return {p.name: p.read_bytes() for p in path.parent.iterdir()} == {path.name: OLD}


# ---- what is written


def test_a_file_is_replaced_in_one_step_with_the_mode_of_a_new_file(old):
    with outputs.written(old) as temporary:
        assert temporary.suffix == ".png"
        temporary.write_bytes(b"new")
        assert old.read_bytes() == OLD
        assert len(list(old.parent.iterdir())) == 2
    fresh = old.with_name("fresh")
    fresh.touch()
    assert old.read_bytes() == b"new"
    assert stat.S_IMODE(old.stat().st_mode) == stat.S_IMODE(fresh.stat().st_mode)
    assert {p.name for p in old.parent.iterdir()} == {"picture.png", "fresh"}


def test_a_name_as_long_as_the_disk_allows_can_be_written(tmp_path):
    name = "n" * 251 + ".png"
    outputs.write_bytes(tmp_path / name, b"data")
    assert [p.name for p in tmp_path.iterdir()] == [name]


def test_what_was_not_written_replaces_nothing(old):
    with pytest.raises(OutputError, match="cannot be written .nothing came out."), outputs.written(old):
        pass
    assert only(old)


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.99])
@pytest.mark.parametrize("kind", ["png", "exr", "exr raw"])
def test_a_short_file_of_a_foreign_writer_replaces_nothing(old, rng, kind, share):
    noise, flat = rng.random((40, 60)).astype(np.float32), np.ones((40, 60), np.float32)
    data = encode_png((255 * noise).astype(np.uint8)) if kind == "png" else encode_exr({"Y": noise if kind == "exr raw" else flat})
    target = old.with_suffix("." + kind.split()[0])
    old.rename(target)
    with pytest.raises(OutputError, match="came out damaged"), outputs.written(target, check_picture) as temporary:
        temporary.write_bytes(data[: int(share * len(data))])
    assert only(target)
    with outputs.written(target, check_picture) as temporary:
        temporary.write_bytes(data)
    assert target.read_bytes() == data


def test_every_flipped_byte_of_a_png_is_seen(tmp_path, rng):
    data = encode_png(rng.integers(0, 65536, (5, 7, 4), dtype=np.uint16))
    path = tmp_path / "p.png"
    for i in range(len(data)):
        path.write_bytes(data[:i] + bytes([data[i] ^ 0x40]) + data[i + 1 :])
        with pytest.raises(ValueError, match="PNG|end"):
            check_picture(path)


def test_a_folder_that_cannot_be_made_is_one_line_and_nothing_else(tmp_path):
    (tmp_path / "file").write_bytes(OLD)
    for below in ("file/x.json", "file/deeper/x.json"):
        with pytest.raises(OutputError, match="cannot be written") as caught:
            outputs.write_json(tmp_path / below, {})
        assert "\n" not in str(caught.value)
    with pytest.raises(OutputError, match="no file can have this name"):
        outputs.write_json(tmp_path / "a\0b", {})
    assert only(tmp_path / "file")


def full_disk(tmp_path):
    """A file system of 128 KiB, filled but for what a folder takes; None where none can be mounted."""
    place = tmp_path / "small"
    place.mkdir()
    if sys.platform != "linux" or os.geteuid() != 0:
        return None
    done = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=128k", "tmpfs", str(place)], capture_output=True)
    return place if done.returncode == 0 else None


def test_a_full_disk_costs_no_old_file(tmp_path):
    place = full_disk(tmp_path)
    if place is None:
        pytest.skip("no file system can be mounted here")
    try:
        target = place / "report.json"
        target.write_bytes(OLD)
        with pytest.raises(OSError, match="No space"):
            (place / "filler").write_bytes(bytes(1 << 20))
        with pytest.raises(OutputError, match="No space left.*make room"):
            outputs.write_bytes(target, bytes(4096))
        assert target.read_bytes() == OLD
        assert {p.name for p in place.iterdir()} == {"report.json", "filler"}
    finally:
        subprocess.run(["umount", str(place)], check=True)


@pytest.mark.parametrize("number", [errno.EDQUOT, errno.ENOSPC, errno.EIO, errno.EINVAL, errno.ENOSYS])
def test_a_disk_that_fails_late_costs_no_old_file_and_one_that_cannot_tell_is_believed(old, monkeypatch, number):
    """A server says that it is full when it is asked to keep the file, not before."""

    def fail(_handle):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(outputs.os, "fsync", fail)
    if number in (errno.EINVAL, errno.ENOSYS):
        outputs.write_bytes(old, b"new")
        assert old.read_bytes() == b"new"
        return
    with pytest.raises(OutputError, match=os.strerror(number)):
        outputs.write_bytes(old, b"new")
    assert only(old)


# ---- what is refused


@posix
def test_only_plain_files_are_replaced(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # a socket's name must be short
    os.mkfifo("pipe")
    os.mkdir("folder")
    (tmp_path / "file").write_bytes(OLD)
    os.symlink("file", "link")
    os.symlink("nowhere", "dangling")
    with socket.socket(socket.AF_UNIX) as server:
        server.bind("socket")
        kinds = {"pipe": "a named pipe", "folder": "a folder", "link": "a link", "dangling": "a link", "socket": "a socket"}
        kinds["/dev/null"] = "a device"
        for name, words in kinds.items():
            with pytest.raises(OutputError, match=f"is {words}, not a file: choose another name"):
                outputs.write_json(tmp_path / name, {})
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)
    assert (tmp_path / "file").read_bytes() == OLD
    assert os.readlink("link") == "file"
    assert {p.name for p in tmp_path.iterdir()} == {"pipe", "folder", "file", "link", "dangling", "socket"}


def test_an_input_is_never_replaced_by_whatever_name_it_is_called(old):
    hard = old.with_name("other.json")
    os.link(old, hard)
    with user_files.run_of_inputs():
        assert user_files.read_bytes(old, 100) == OLD
        for name in (old, hard, old.parent / ".." / "out" / "picture.png"):
            with pytest.raises(OutputError, match="is an input of this run"):
                outputs.write_bytes(name, b"x")
    assert old.read_bytes() == hard.read_bytes() == OLD
    outputs.write_bytes(old, b"another run")
    assert old.read_bytes() == b"another run"


@posix
@pytest.mark.skipif(hasattr(os, "geteuid") and os.geteuid() == 0, reason="root may write everything")
def test_a_write_protected_file_stays(old):
    old.chmod(0o444)
    with pytest.raises(OutputError, match="write-protected"):
        outputs.write_bytes(old, b"x")
    assert only(old)


def test_two_inputs_never_write_one_file_in_a_run(tmp_path):
    target = tmp_path / "a_b.json"
    with outputs.run_of_results():
        for owner in ("first", "first"):
            with outputs.recorded(owner):
                outputs.write_json(target, [owner])
        with outputs.recorded("second"), pytest.raises(OutputError, match="was written for first in this run"):
            outputs.write_json(target, ["second"])
    assert target.read_text() == '[\n "first"\n]\n'


# ---- temporary files


@posix
def test_nobody_else_can_guess_or_enter_the_temporary_folder(tmp_path):
    places = []
    for _ in range(3):
        with outputs.written(tmp_path / "x.png") as temporary:
            temporary.write_bytes(b"x")
            places.append(temporary.parent)
            assert stat.S_IMODE(temporary.parent.stat().st_mode) == 0o700
    assert len(set(places)) == 3
    assert not any(str(os.getpid()) in place.name for place in places)


@posix
def test_what_a_killed_process_left_is_taken_away_and_what_a_living_one_holds_is_not(tmp_path, monkeypatch):
    code = (
        "import sys, time; sys.path.insert(0, sys.argv[1])\n"
        "from pathlib import Path\nfrom addon.studies import scratch\n"
        "with scratch.beside(Path(sys.argv[2])) as place:\n"
        "    (place / 'part.png').write_bytes(b'half'); print(place.name, flush=True); time.sleep(60)\n"
    )
    root = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    children = [subprocess.Popen([sys.executable, "-c", code, root, str(tmp_path)], stdout=subprocess.PIPE, text=True) for _ in range(2)]
    try:
        dead, alive = (child.stdout.readline().strip() for child in children)
        children[0].kill()
        children[0].wait()
        foreign = tmp_path / (scratch.PREFIX + "foreign")
        foreign.mkdir()
        (foreign / "thesis.txt").write_bytes(OLD)
        (foreign / scratch.LOCK).touch()
        outputs.write_bytes(tmp_path / "young.png", b"x")
        assert (tmp_path / dead).exists(), "it might be one that has just begun"
        late = time.time() + 3600
        monkeypatch.setattr(scratch.time, "time", lambda: late)
        scratch._swept.clear()
        outputs.write_bytes(tmp_path / "x.png", b"x")
        assert not (tmp_path / dead).exists()
        assert (tmp_path / alive / "part.png").read_bytes() == b"half"
        assert (foreign / "thesis.txt").read_bytes() == OLD, "a folder with anything else in it is not ours"
    finally:
        for child in children:
            child.kill()
            child.communicate()


# ---- what is read


@posix
def test_pipes_and_devices_are_not_even_opened(tmp_path, monkeypatch):
    os.mkfifo(tmp_path / "pipe.obj")
    os.symlink("/dev/zero", tmp_path / "zero.obj")
    answers = []

    def attempt():
        for path, words in ((tmp_path / "pipe.obj", "a named pipe"), (tmp_path / "zero.obj", "a device"), (tmp_path, "a folder")):
            with pytest.raises(OSError, match=words):
                user_files.read_bytes(path, 1 << 20)
            answers.append(words)

    thread = threading.Thread(target=attempt, daemon=True)
    thread.start()
    thread.join(10.0)
    assert len(answers) == 3


def test_a_file_larger_than_allowed_is_not_read_whole(tmp_path):
    path = tmp_path / "large"
    with path.open("wb") as file:
        file.truncate(1 << 40)
    with pytest.raises(OSError, match="larger than the 1 MiB allowed"):
        user_files.read_bytes(path, 1 << 20)
    assert user_files.size_text(2 << 30) == "2 GiB"
