"""Who wants to hear of something, and how to stop hearing of it."""

from collections.abc import Callable
from typing import Generic, ParamSpec

Told = ParamSpec("Told")


class Listeners(Generic[Told]):
    """Functions that are called with what is told. May be used from several threads."""

    def __init__(self) -> None:
        self._called: list[Callable[Told, object]] = []

    def add(self, called: Callable[Told, object]) -> Callable[[], None]:
        """Call this, too; what is returned ends that."""
        self._called.append(called)

        def stop() -> None:
            if called in self._called:
                self._called.remove(called)

        return stop

    def tell(self, *args: Told.args, **kwargs: Told.kwargs) -> None:
        """Call all of them, in this thread."""
        for called in list(self._called):
            called(*args, **kwargs)
