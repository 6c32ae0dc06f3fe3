"""Work under way is asked, given up and taken in one way, whatever it is made of."""

from concurrent.futures import Future

import pytest

from addon.errors import Cancelled, SceneError
from addon.studies.pending import Chained, PendingFuture, ready, waited


class Slow:
    """Work that is done at its third look, or fails then."""

    progress = (0.25, "slow")

    def __init__(self, error=None):
        self.looks, self.is_given_up, self._error = 0, False, error

    def done(self):
        self.looks += 1
        if self._error is not None and self.looks >= 3:
            raise self._error
        return self.looks >= 3

    def cancel(self):
        self.is_given_up = True

    def result(self, timeout_s=None):
        return 7


def queued(future, **options):
    return PendingFuture(future, lambda: (0.5, "queued"), **options)


def test_the_second_piece_is_made_once_of_the_result_of_the_first():
    made = []
    chain = Chained(Slow(), lambda found: made.append(found) or ready(found + 1))
    assert [chain.done(), chain.done(), chain.done(), chain.done()] == [False, False, True, True]
    assert (made, chain.result(), chain.progress) == ([7], 8, (1.0, ""))


def test_taking_the_result_at_once_waits_for_both_pieces():
    assert Chained(Slow(), lambda found: ready(found + 1)).result() == 8


@pytest.mark.parametrize("place", ["first", "then"])
def test_what_a_user_can_mend_is_raised_where_the_result_is_taken(place):
    def then(_found):
        raise SceneError("empty")

    chain = Chained(Slow(SceneError("empty")), ready) if place == "first" else Chained(ready(1), then)
    while not chain.done():
        pass
    with pytest.raises(SceneError, match="empty"):
        chain.result()


def test_giving_up_reaches_the_piece_it_is_at():
    first, second = Slow(), Slow()
    chain = Chained(first, lambda _found: second)
    chain.cancel()
    assert first.is_given_up
    for _ in range(3):
        chain.done()
    chain.cancel()
    assert second.is_given_up and chain.progress == second.progress


def test_work_given_up_before_its_turn_is_cancelled():
    told, future = [], Future()
    work = queued(future, give_up=lambda: told.append(True))
    work.cancel()
    assert told == [True] and work.done()
    with pytest.raises(Cancelled):
        work.result()


def test_waiting_says_how_far_it_is_and_gives_up_when_asked():
    said, future = [], Future()
    with pytest.raises(Cancelled):
        waited(queued(future), lambda *words: said.append(words), lambda: len(said) == 2)
    assert said == [(0.5, "queued")] * 2


def test_work_that_fails_for_want_of_time_says_so_and_work_done_in_between_is_taken():
    future = Future()
    future.set_exception(TimeoutError("the disk"))
    with pytest.raises(TimeoutError, match="the disk"):
        waited(queued(future))

    class DoneMeanwhile(Slow):
        def done(self):
            return True

        def result(self, timeout_s=None):
            if timeout_s is not None:
                raise TimeoutError
            return 7

    assert waited(DoneMeanwhile()) == 7
