"""Numbers read all at once are those that Python reads one by one; words that are none are refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from addon.scene.cad.decimals import Words
from addon.scene.cad.text_numbers import LONG, numbers

FORMS = st.sampled_from(["{!r}", "{:.6E}", "{:+.9f}", "{:g}", "{:.0f}", "{:.17g}", "{:e}"])
ODD = [
    "-0",
    "+.5",
    "5.",
    "-.5e3",
    "1e+5",
    "1E-300",
    "1e22",
    "1e23",
    "0.1e-22",
    "12345678901234567890",
    "nan",
    "inf",
    "1e400",
    "00012",
    "1e255",
]
ODD += ["1e256", "1e257", "9007199254740993", "1e0000005", "-1e-0", "0." + "0" * 30 + "1", "1" * 40, "Infinity", "1.7976931348623157e308"]
WORD = st.one_of(st.sampled_from(ODD), st.builds(lambda form, value: form.format(value), FORMS, st.floats(width=64)))


@given(st.lists(st.tuples(WORD, st.sampled_from([" ", "\n", "\t  ", "\r\n"])), min_size=1, max_size=60))
def test_numbers_read_together_are_those_that_python_reads(words):
    got = Words("".join(word + blank for word, blank in words).encode()).numbers()
    wanted = np.array([float(word) for word, _ in words])
    assert np.array_equal(got, wanted, equal_nan=True)
    assert (np.signbit(got) == np.signbit(wanted))[~np.isnan(wanted)].all()


@pytest.mark.parametrize("word", ["1e", "e5", "1.2.3", "--1", "1-2", "+", "-", "1e+", "1e5.0", "x", "1e-5e3", "1_0", "0x10", "1,5", "."])
def test_words_that_are_no_numbers_are_refused(word):
    with pytest.raises(ValueError, match="number|float"):
        Words(f"1 {word} 2".encode()).numbers()


@pytest.mark.parametrize("count", [1, LONG])
def test_long_and_short_texts_are_read_alike(count):
    assert numbers(b"12 -3\n" * count, np.int64).tolist() == [12, -3] * count
    assert numbers(b"1.5 -3e2\n" * count, np.float64).tolist() == [1.5, -300.0] * count
    for bad in (b"1.5 ", b"nan ", b"1_0 "):
        with pytest.raises(ValueError, match="number|unmatched data"):
            numbers(b"7 " * count + bad, np.int64)


def test_words_are_found_in_any_letters():
    words = Words(b"  Vertex 1 2 3\nvertices VERTEX\r\n vertex")
    assert words.are(b"vertex").tolist() == [True, False, False, False, False, True, True]
