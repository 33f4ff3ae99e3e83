"""BLAS has one setting for the process; in whatever order those who limit it leave, it is what it was in the end."""

import numpy as np
from threadpoolctl import threadpool_info

from ipcore._threads import limited, ordered, using


def threads() -> set[int]:
    np.ones((2, 2)) @ np.ones((2, 2))
    return {one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"}


def test_the_least_that_is_asked_for_holds_and_the_setting_comes_back() -> None:
    before = threads()
    wide, narrow = limited(2), limited(1)
    wide.__enter__()
    narrow.__enter__()
    assert threads() == {1}
    wide.__exit__(None, None, None)  # not the last that came
    assert threads() == {1}
    narrow.__exit__(None, None, None)
    assert threads() == before


def test_blas_keeps_to_one_thread_where_ours_work() -> None:
    before = threads()
    assert list(ordered(lambda _: threads(), range(4), threads=2)) == [{1}] * 4
    with using(1):
        assert threads() == {1}
    assert threads() == before
