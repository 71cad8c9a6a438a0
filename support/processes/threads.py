"""Threads for compiled code that lets go of the interpreter; BLAS on one.

BLAS sums depend on the number of its threads, and its small matrices wait for each other on many.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache, wraps
from typing import Any, ParamSpec, TypeVar

from threadpoolctl import ThreadpoolController

P = ParamSpec("P")
T = TypeVar("T")


@lru_cache(maxsize=1)
def _controller() -> ThreadpoolController:
    """Find the libraries with threads, once: NumPy's and SciPy's are loaded by then."""
    return ThreadpoolController()


def single_threaded(function: Callable[..., T], *arguments: Any) -> T:
    """Call ``function`` with BLAS on one thread."""
    return on_one_thread(function)(*arguments)


def on_one_thread(function: Callable[P, T]) -> Callable[P, T]:
    """Decorate ``function`` to run with BLAS on one thread."""

    @wraps(function)
    def wrapped(*args: P.args, **kwargs: P.kwargs) -> T:
        with _controller().limit(limits=1):
            return function(*args, **kwargs)

    return wrapped


@lru_cache(maxsize=4)
def _pool(threads: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads, thread_name_prefix="haptid")


def map_threads(function: Callable[..., T], *arguments: Iterable[Any], threads: int = 1) -> list[T]:
    """Return ``function`` of every tuple of arguments in their order, side by side on ``threads`` threads."""
    tuples = list(zip(*arguments, strict=True))
    if threads <= 1:
        return [function(*each) for each in tuples]
    return list(_pool(threads).map(lambda each: function(*each), tuples))
