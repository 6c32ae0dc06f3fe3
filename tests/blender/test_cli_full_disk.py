"""The command line on a disk that is full, or fails half way: nothing that was there is lost, and the exit code says so."""

import resource
import subprocess

import pytest

from tests.blender.user_folder import OLD, SMALL, below, posix
from tests.test_user_files import full_disk


@pytest.fixture
def small_files():
    """From the call on no file of this process grows beyond so many bytes, as on a full disk."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    yield lambda count: resource.setrlimit(resource.RLIMIT_FSIZE, (count, limits[1]))
    resource.setrlimit(resource.RLIMIT_FSIZE, limits)


@posix
@pytest.mark.parametrize("kind", ["png", "exr"])
def test_a_picture_that_blender_cuts_short_replaces_nothing_and_is_a_failure(main, box, tmp_path, small_files, kind, capfd):
    out = tmp_path / "out"
    out.mkdir()
    (out / f"box_combined.{kind}").write_bytes(OLD)
    small_files(1500)
    code = main(["preview", str(box), "-o", str(out), "--format", kind, *SMALL])
    small_files(resource.RLIM_INFINITY)
    assert code == 1
    assert (out / f"box_combined.{kind}").read_bytes() == OLD
    assert below(out) == [f"box_combined.{kind}"]
    (line,) = [line for line in capfd.readouterr().err.splitlines() if line.startswith("cad_shadow")]  # Blender 4.5 has a word on EXR too
    assert f"box_combined.{kind} cannot be written" in line
    assert "make room" in line


@posix
@pytest.mark.parametrize("what", ["plane", "sun", "api"])
def test_every_writer_of_blenders_is_checked(main, room, box, tmp_path, small_files, what, capfd):
    out = tmp_path / "out"
    out.mkdir()
    names = {"plane": "box_impostor.blend", "sun": "box_sun_001_1000.png", "api": "api.png"}
    target = out / names[what]
    target.write_bytes(OLD)
    day = ("--latitude", "51", "--longitude", "0", "--date", "2026-06-21", "--from", "10:00", "--steps", "1", "--pictures")
    if what == "plane":
        small_files(40_000)
        code = main(["impostor", str(box), "-o", str(out), "--plane", "--format", "npz", *SMALL])
    elif what == "sun":
        small_files(1500)
        code = main(["sun-study", str(box), "-o", str(out), *day, *SMALL])
    else:
        picture = room("api").preview(size=(96, 64))
        small_files(200)
        with pytest.raises(room("errors").OutputError, match="came out damaged"):
            picture.save(target, ("combined",))
        code = 1
    small_files(resource.RLIM_INFINITY)
    assert code == 1
    assert target.read_bytes() == OLD
    assert not [name for name in below(out) if name.startswith(".")]


def test_a_full_disk_costs_no_old_picture_and_is_a_failure(main, box, tmp_path):
    place = full_disk(tmp_path)
    if place is None:
        pytest.skip("no file system can be mounted here")
    try:
        for kind in ("png", "exr", "npz"):
            name = "box.npz" if kind == "npz" else f"box_combined.{kind}"
            (place / name).write_bytes(OLD)
        with pytest.raises(OSError, match="No space"):
            (place / "filler").write_bytes(bytes(1 << 20))
        before = below(place)
        for kind in ("png", "exr", "npz"):
            assert main(["preview", str(box), "-o", str(place), "--format", kind, *SMALL]) == 1
        assert below(place) == before
        assert all((place / name).read_bytes() == OLD for name in before if name != "filler")
    finally:
        subprocess.run(["umount", str(place)], check=True)
