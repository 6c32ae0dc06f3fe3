"""Attaching and detaching several parts: all or none, and each is tried."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from addon.blender.registering import attach, detach


class Part:
    """Notes its calls in a shared list; fails where it is told to."""

    def __init__(self, name, calls, failing):
        self.name, self.calls, self.failing = name, calls, failing

    def _call(self, verb):
        self.calls.append((verb, self.name))
        if (verb, self.name) in self.failing:
            raise RuntimeError(f"{verb} {self.name}")

    def register(self):
        self._call("register")

    def unregister(self):
        self._call("unregister")


@given(count=st.integers(1, 6), failing=st.sets(st.integers(0, 5)))
def test_every_part_is_detached_and_the_first_error_is_raised(count, failing):
    calls = []
    parts = [Part(i, calls, {("unregister", f) for f in failing}) for i in range(count)]
    bad = sorted((f for f in failing if f < count), reverse=True)
    if bad:
        with pytest.raises(RuntimeError) as caught:
            detach(parts)
        assert caught.value.args == (f"unregister {bad[0]}",)
        assert len(getattr(caught.value, "__notes__", [])) == len(bad) - 1
    else:
        detach(parts)
    assert calls == [("unregister", i) for i in reversed(range(count))]


@given(count=st.integers(1, 6), bad=st.integers(0, 5), also=st.integers(0, 5))
def test_a_part_that_cannot_be_attached_takes_all_before_it_back(count, bad, also):
    calls = []
    parts = [Part(i, calls, {("register", bad), ("unregister", also)}) for i in range(count)]
    if bad >= count:
        attach(parts)
        assert calls == [("register", i) for i in range(count)]
        return
    with pytest.raises(RuntimeError) as caught:
        attach(parts)
    assert caught.value.args == (f"register {bad}",)
    assert calls == [("register", i) for i in range(bad + 1)] + [("unregister", i) for i in reversed(range(bad))]
