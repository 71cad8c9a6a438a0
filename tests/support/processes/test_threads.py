import numpy as np
import pytest
from threadpoolctl import threadpool_info

from haptid.support.processes.threads import map_threads, on_one_thread, single_threaded


def blas_threads() -> set[int]:
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


def test_blas_runs_on_one_thread_inside_and_as_before_outside():
    np.linalg.inv(np.eye(3))
    before = blas_threads()
    assert single_threaded(blas_threads) == {1}
    assert on_one_thread(blas_threads)() == {1}
    assert blas_threads() == before


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_results_keep_their_order_on_any_number_of_threads(threads):
    assert map_threads(lambda a, b: a - b, range(20), range(20, 40), threads=threads) == [-20] * 20
    assert map_threads(abs, [-3, 2, -1], threads=threads) == [3, 2, 1]


def test_an_error_in_a_thread_reaches_the_caller():
    with pytest.raises(ZeroDivisionError):
        map_threads(lambda a: 1 / a, [1, 0], threads=2)
