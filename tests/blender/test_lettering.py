"""Captions in Blender's own fonts: every script, no wider than their place, one line each."""

import numpy as np
import pytest

SCRIPTS = ["配管", "ポンプ", "泵", "밸브", "Łódź", "Труба", "αβγ", "ไทย", "हिंदी", "عربى"]


@pytest.fixture
def lines(extension, room):
    return room("blender.lettering").lines


@pytest.fixture
def blenders(lines):
    """The same, where Blender can draw its fonts into pictures."""
    import blf

    if not hasattr(blf, "bind_imbuf"):
        pytest.skip("Blender draws its fonts into windows only")
    return lines


def test_names_of_every_script_are_written_and_differ(blenders):
    written = blenders(SCRIPTS, 400)
    unknown = blenders(["\U000f0000"], 400)[0]  # a character that no font has
    for text, one in zip(SCRIPTS, written, strict=True):
        assert one.max() > 0.9 and 0 < one.shape[1] < 30 * len(text)
        assert not np.array_equal(one[:, : unknown.shape[1]], unknown), f"{text} begins with the sign for what is missing"
    assert len({one.tobytes() for one in written}) == len(SCRIPTS)


def test_a_line_is_the_same_among_others_as_alone(blenders):
    among = blenders(SCRIPTS, 400)
    assert all(np.array_equal(one, blenders([text], 400)[0]) for text, one in zip(SCRIPTS, among, strict=True))
    assert all(not one[[0, -1]].any() for one in among), "nothing is cut off above or below"


def test_what_is_too_wide_ends_in_dots_within_its_place(blenders):
    long, dots = blenders(["配管" * 100, "…"], 150)
    assert 120 < long.shape[1] <= 150
    assert np.abs(long[:, -dots.shape[1] + 2 :] - dots[:, 2:]).max() < 0.5
    assert blenders(["W", ""], 3)[0].shape[1] <= 3 and blenders([""], 3)[0].shape[1] == 0


def test_more_lines_than_are_drawn_at_once_keep_their_order(blenders):
    texts = [f"{i}" for i in range(300)]
    assert np.array_equal(blenders(texts, 60)[299], blenders(["299"], 60)[0])


def test_names_move_no_cursor_and_turn_no_text(blenders):
    assert np.array_equal(blenders(["a\x1b[31m\u202eb"], 300)[0], blenders(["a\\x1b[31m\\u202eb"], 300)[0])


def test_nothing_stays_in_the_file(blenders, blend):
    before = set(blend.data.images.keys())
    blenders(["配管"], 99)
    assert set(blend.data.images.keys()) == before


def test_a_blender_that_draws_into_windows_only_spells_names(lines, room, monkeypatch):
    monkeypatch.delattr("blf.bind_imbuf", raising=False)
    own = room("images.lettering").lines(["配管", "Größe"], 200)
    assert all(np.array_equal(*pair) for pair in zip(lines(["配管", "Größe"], 200), own, strict=True))


def test_no_room_for_temporary_files_is_one_line(blenders, room, monkeypatch):
    monkeypatch.setattr("imbuf.write", lambda *_, **__: (_ for _ in ()).throw(OSError(28, "No space left on device")))
    with pytest.raises(room("errors").OutputError, match="No space left on device.*set TMPDIR"):
        blenders(["a"], 99)
