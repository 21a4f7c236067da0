"""The latest request is done, whatever came before it."""

import threading

from ods.workbench.engine.background.newest import Newest


def test_requests_that_a_later_one_overtook_are_dropped() -> None:
    begun, may_end, done = threading.Event(), threading.Event(), threading.Event()
    reported: list[int] = []

    def work(request: int) -> int:
        begun.set()
        assert may_end.wait(10.0)
        return 10 * request

    def tell(_: int, answer: int) -> None:
        reported.append(answer)
        if answer == 50:
            done.set()

    newest = Newest(work, tell, lambda _, error: reported.append(-1))
    newest.ask(0)
    assert begun.wait(10.0)
    for request in range(1, 6):
        newest.ask(request)
    assert newest.overtaken
    may_end.set()
    assert done.wait(10.0)
    assert reported == [0, 50]
    assert newest.dropped == 4
    newest.close()


def test_a_request_that_fails_is_reported_and_the_next_is_done() -> None:
    reported: list[str] = []
    done = threading.Event()

    def work(request: int) -> float:
        return 1.0 / request

    def tell(_: int, answer: float) -> None:
        reported.append(f"{answer}")
        done.set()

    def fail(request: int, error: Exception) -> None:
        reported.append(f"{request}: {error}")
        done.set()

    newest = Newest(work, tell, fail)
    newest.ask(0)
    assert done.wait(10.0)
    done.clear()
    newest.ask(4)
    assert done.wait(10.0)
    assert reported == ["0: float division by zero", "0.25"]
    newest.close()


def test_what_is_kept_is_given_back_once_nothing_is_asked_and_at_the_end() -> None:
    done, idle = threading.Semaphore(0), threading.Semaphore(0)
    newest: Newest[int, int] = Newest(
        lambda request: request, lambda *_: done.release(), lambda *_: None, idle.release, idle_s=0.01
    )
    newest.ask(1)
    assert done.acquire(timeout=10.0)
    assert idle.acquire(timeout=10.0)
    newest.ask(2)
    assert done.acquire(timeout=10.0)
    newest.close()
    assert idle.acquire(timeout=10.0)
