"""Work in threads: its order, its errors, how many threads there are, and the limits of BLAS."""

import os
import threading
from collections.abc import Iterator

import numpy as np
import pytest
from threadpoolctl import threadpool_info

from ipcore._threads import AHEAD, SLICE_ROWS, available, by_rows, limited, mapped, ordered, using


def test_results_come_in_order_from_as_many_threads_as_asked_for() -> None:
    together = threading.Barrier(3, timeout=60.0)  # breaks unless three wait at once

    def square(x: int) -> int:
        together.wait()
        return x * x

    assert mapped(square, range(9), threads=3) == [x * x for x in range(9)]


def test_one_thread_is_the_callers() -> None:
    assert set(mapped(lambda _: threading.get_ident(), range(5), threads=1)) == {threading.get_ident()}


@pytest.mark.parametrize("threads", [1, 2])
def test_errors_come_through(threads: int) -> None:
    with pytest.raises(ZeroDivisionError):
        mapped(lambda x: 1 // x, [1, 0, 2], threads=threads)


@pytest.mark.parametrize("rows", [0, 1, SLICE_ROWS, 2 * SLICE_ROWS + 1])
def test_rows_are_all_there_once(rows: int) -> None:
    x = np.arange(rows)
    np.testing.assert_array_equal(by_rows(lambda part: x[part], rows, threads=2), x)


def test_the_environment_says_how_many_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    assert available() == 3
    for unclear in ("", "0", "4,2"):
        monkeypatch.setenv("OMP_NUM_THREADS", unclear)
        assert 1 <= available() <= (os.cpu_count() or 1)


def test_a_stream_is_taken_only_a_little_ahead() -> None:
    taken = []

    def stream() -> Iterator[int]:
        for k in range(100):
            taken.append(k)
            yield k

    results = ordered(lambda k: -k, stream(), threads=2)
    assert next(results) == 0
    assert len(taken) <= 2 * AHEAD
    assert list(results) == [-k for k in range(1, 100)]


def test_after_an_error_nothing_more_is_begun() -> None:
    begun = []

    def work(k: int) -> float:
        begun.append(k)
        return 1 / (k - 1)

    with pytest.raises(ZeroDivisionError):
        list(ordered(work, iter(range(1000)), threads=2))
    assert len(begun) <= 1 + 2 * AHEAD


def test_work_within_work_keeps_to_its_thread() -> None:
    def inner(_: int) -> set[int]:
        return {threading.get_ident(), *mapped(lambda _: threading.get_ident(), range(4), threads=2)}

    assert all(len(threads) == 1 for threads in mapped(inner, range(4), threads=2))
    with using(3):
        assert available() == 3
        assert mapped(lambda _: available(), range(2), threads=2) == [1, 1]


def blas_threads() -> set[int]:
    np.ones((2, 2)) @ np.ones((2, 2))
    return {one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"}


def test_the_lowest_limit_holds_and_the_setting_comes_back() -> None:
    before = blas_threads()
    wide, narrow = limited(2), limited(1)
    wide.__enter__()
    narrow.__enter__()
    assert blas_threads() == {1}
    wide.__exit__(None, None, None)  # not the last that came
    assert blas_threads() == {1}
    narrow.__exit__(None, None, None)
    assert blas_threads() == before


def test_blas_keeps_to_one_thread_where_ours_work() -> None:
    before = blas_threads()
    assert list(ordered(lambda _: blas_threads(), range(4), threads=2)) == [{1}] * 4
    with using(1):
        assert blas_threads() == {1}
    assert blas_threads() == before
