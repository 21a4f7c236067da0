"""Missions on several processes: results are in order, and a mission is repeated if its process was killed."""

import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import NamedTuple

from ods.base.errors import OdsError
from ods.missions.outcome import Flown
from ods.missions.settings import Arm, Campaign

MOST_KILLS = 3
"""Processes that a pool may lose in a row, without a result between: then the mission itself kills them."""
AHEAD = 4
"""Missions for each process that are given out at a time."""


class Task(NamedTuple):
    """One mission of one arm."""

    campaign: Campaign
    number: int
    arm: Arm


Fly = Callable[[Task], Flown]


def flown_of(tasks: Sequence[Task], fly: Fly, workers: int) -> Iterator[Flown]:
    """Yield what comes of each task, in their order. With one worker it is flown here. Raises OdsError."""
    if workers == 1:
        yield from map(fly, tasks)
        return
    done = kills = 0
    while done < len(tasks):
        before = done
        try:
            for flown in _of_one_pool(tasks[done:], fly, workers):
                done += 1
                yield flown
        except BrokenProcessPool:
            kills = 1 if done > before else kills + 1
            if kills == MOST_KILLS:
                task = tasks[done]
                raise OdsError(
                    f"mission {task.number} of arm {task.arm!r}, or one in the same process, was killed {kills} times"
                ) from None


def _of_one_pool(tasks: Sequence[Task], fly: Fly, workers: int) -> Iterator[Flown]:
    context = multiprocessing.get_context("spawn")  # of a process with threads no copy is safe
    with ProcessPoolExecutor(workers, mp_context=context) as pool:
        waiting: list[Future[Flown]] = []
        try:
            for task in tasks:
                if len(waiting) == AHEAD * workers:
                    yield waiting.pop(0).result()
                waiting.append(pool.submit(fly, task))
            while waiting:
                yield waiting.pop(0).result()
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
