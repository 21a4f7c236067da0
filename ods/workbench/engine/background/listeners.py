"""Who wants to hear of something, and how to stop hearing of it."""

from collections.abc import Callable
from typing import Generic, ParamSpec

Args = ParamSpec("Args")


class Listeners(Generic[Args]):
    """Functions that are called with each notification. May be used from several threads."""

    def __init__(self) -> None:
        self._called: list[Callable[Args, object]] = []

    def add(self, called: Callable[Args, object]) -> Callable[[], None]:
        """Call this, too; what is returned ends that."""
        self._called.append(called)

        def stop() -> None:
            if called in self._called:
                self._called.remove(called)

        return stop

    def notify(self, *args: Args.args, **kwargs: Args.kwargs) -> None:
        """Call all of them, in this thread."""
        for called in list(self._called):
            called(*args, **kwargs)
