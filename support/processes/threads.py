"""Threads for compiled code that releases the interpreter's lock, and BLAS limited to one thread.

Sums of BLAS depend on the number of its threads, so that one thread gives the same bits on every machine; and on small
matrices several threads wait for each other.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache, wraps
from typing import Any, ParamSpec, TypeVar

from threadpoolctl import ThreadpoolController

P = ParamSpec("P")
T = TypeVar("T")


@lru_cache(maxsize=1)
def _controller() -> ThreadpoolController:
    """Find the libraries with threads once, at the first call: NumPy's and SciPy's libraries are loaded by then."""
    return ThreadpoolController()


def single_threaded(function: Callable[..., T], *arguments: Any) -> T:
    """Call a function with BLAS limited to one thread.

    Parameters
    ----------
    function
        Function to call.
    *arguments
        Its arguments.

    Returns
    -------
    object
        The function's result.
    """
    return on_one_thread(function)(*arguments)


def on_one_thread(function: Callable[P, T]) -> Callable[P, T]:
    """Decorate a function so that BLAS runs on one thread within it.

    Parameters
    ----------
    function
        Function to decorate.

    Returns
    -------
    callable
        Function with the same arguments and result.
    """

    @wraps(function)
    def wrapped(*args: P.args, **kwargs: P.kwargs) -> T:
        with _controller().limit(limits=1):
            return function(*args, **kwargs)

    return wrapped


@lru_cache(maxsize=4)
def _pool(threads: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads, thread_name_prefix="haptid")


def _count_nobody(done: int) -> None:
    """Take a count, and do nothing."""


def map_threads(
    function: Callable[..., T],
    *arguments: Iterable[Any],
    threads: int = 1,
    count: Callable[[int], None] = _count_nobody,
) -> list[T]:
    """Map a function over tuples of arguments on several threads.

    Parameters
    ----------
    function
        Function that releases the interpreter's lock; others gain nothing.
    *arguments
        Iterables of equal length, one per argument of ``function``.
    threads
        Number of threads; 1 calls the function in this thread.
    count
        Told, by the thread that did it, how many calls are done.

    Returns
    -------
    list
        Results in the order of the arguments.

    Raises
    ------
    ValueError
        Where the iterables differ in length.
    """
    tuples = list(zip(*arguments, strict=True))
    numbers = itertools.count(1)

    def run_and_count(each: tuple[Any, ...]) -> T:
        made = function(*each)
        count(next(numbers))
        return made

    if threads <= 1:
        return [run_and_count(each) for each in tuples]
    return list(_pool(threads).map(run_and_count, tuples))
