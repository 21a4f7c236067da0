"""A bar from the first ping to the last, to be dragged."""

from collections.abc import Callable

from nicegui.element import Element


class Scrubber(Element, component="scrubber.js"):
    """Reports the newest position some 30 times a second while it is dragged; in place of `ui.slider`, at whose values
    the browser goes through the whole page."""

    def __init__(self, callback: Callable[[int, bool], None]) -> None:
        """callback: gets the position, and whether the hand still holds it."""
        super().__init__()
        self._props.update({"place": 0, "last": 1})
        self.on("scrub", lambda event: callback(int(event.args["place"]), bool(event.args["held"])))

    @property
    def place(self) -> int:
        """That was shown last."""
        return int(self._props["place"])

    def show(self, place: int, last: int) -> None:
        """Show a place from 0 to last; while the hand holds the bar, it stays in the hand."""
        if (place, last) != (self.place, self._props["last"]):
            with self._props.suspend_updates():  # only the script gets it: NiceGUI would send all again
                self._props.update({"place": place, "last": last})
            self.run_method("set", place, last)
