"""Fits that do not wait for each other, side by side on the cores.

Crew                a fitter for each thread
side_by_side, both  things that need no fitter

A model keeps the solutions that it has been at, to start from them, so each thread has a model of
its own. A fit begins without them (`Fitter.fit`): which thread it gets changes no bit of it.
Threads gain because the search, and all that is compiled, does without Python's lock.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from functools import partial
from queue import SimpleQueue
from typing import TypeVar, cast

from cbpt.lab.inference.fit import Fitter
from cbpt.lab.model.dataset import Campaign

_MOST = 4
"""Threads: more would wait for Python's lock."""

Found = TypeVar("Found")
Other = TypeVar("Other")
Task = Callable[[Fitter], Found]
"""What one of the fitters is asked; the same of each."""


class Crew:
    """A fitter for each thread."""

    def __init__(self, fitter: Fitter) -> None:
        self._fitter = fitter
        self._threads = threads_for(fitter.campaign)
        self._idle: SimpleQueue[Fitter] = SimpleQueue()

    def each(self, tasks: Iterable[Task[Found]], take: Callable[[Found], object]) -> None:
        """Has each task done and its outcome taken, these one by one in the order of the tasks.
        What is raised ends all others."""
        if self._threads == 1:
            for task in tasks:
                take(task(self._fitter))
            return
        while self._idle.qsize() < self._threads:
            self._idle.put(self._fitter.beside())
        pool = ThreadPoolExecutor(self._threads)
        try:
            futures = [pool.submit(copy_context().run, partial(self._done, task)) for task in tasks]
            for future in futures:
                take(future.result())
        finally:
            pool.shutdown(cancel_futures=True)

    def _done(self, task: Task[Found]) -> Found:
        fitter = self._idle.get()
        try:
            return task(fitter)
        finally:
            self._idle.put(fitter)


def both(
    campaign: Campaign, one: Callable[[], Found], other: Callable[[], Other]
) -> tuple[Found, Other]:
    """What becomes of two things that are done at once."""
    works: list[Callable[[], Found | Other]] = [one, other]
    return cast("tuple[Found, Other]", tuple(side_by_side(campaign, works)))


def side_by_side(campaign: Campaign, works: Sequence[Callable[[], Found]]) -> list[Found]:
    """What becomes of things that are done on all cores, in their order; each has a model of its
    own, or asks none. What is raised ends those that have not begun."""
    threads = min(threads_for(campaign), len(works))
    if threads <= 1:
        return [work() for work in works]
    pool = ThreadPoolExecutor(threads)
    try:
        futures = [pool.submit(copy_context().run, work) for work in works]
        return [future.result() for future in futures]
    finally:
        pool.shutdown(cancel_futures=True)


def threads_for(campaign: Campaign) -> int:
    """How many are worth having. A function of the user's need not stand being called twice at a
    time."""
    one = any(effect.expression is None for effect in campaign.own.values())
    return 1 if one else min(_cores(), _MOST)


def _cores() -> int:
    """Those that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
