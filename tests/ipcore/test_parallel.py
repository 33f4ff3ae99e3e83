"""Work in threads: its order, its errors, and how many there are."""

import os
import threading

import numpy as np
import pytest

from ipcore.parallel import CHUNK, available, by_rows, mapped


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


@pytest.mark.parametrize("rows", [0, 1, CHUNK, 2 * CHUNK + 1])
def test_rows_are_all_there_once(rows: int) -> None:
    x = np.arange(rows)
    np.testing.assert_array_equal(by_rows(lambda part: x[part], rows, threads=2), x)


def test_the_environment_says_how_many_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    assert available() == 3
    for unclear in ("", "0", "4,2"):
        monkeypatch.setenv("OMP_NUM_THREADS", unclear)
        assert 1 <= available() <= (os.cpu_count() or 1)
