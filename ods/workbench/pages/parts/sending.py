"""What is made for the user: written under a folder of the workbench, or sent to the browser, which keeps it."""

import shutil
import tempfile
from collections.abc import Awaitable, Callable
from pathlib import Path

from nicegui import run, ui
from nicegui.elements.button import Button

from ods.base.errors import OdsError
from ods.workbench.engine.files.folders import writable
from ods.workbench.session import Session

Make = Callable[[Path], object]
"""Writes a file, or a folder of files, at a place. Called in a thread."""


def buttons(session: Session, does: str, name: Callable[[], str], make: Make) -> None:
    """Build the two buttons, called `does` and "Download". name: of what is written, as the user typed it."""

    async def press(then: Callable[[], Awaitable[None]]) -> None:
        for button in both:
            button.disable()
        try:
            await then()
        finally:
            for button in both:
                button.enable()

    with ui.row():
        write = ui.button(does, on_click=lambda: press(lambda: _write(session, name(), make)))
        write.props("dense no-caps").mark(does.lower())
        both = write, download(does, lambda: press(lambda: send(name(), make)))


def download(does: str, pressed: Callable[[], Awaitable[None]]) -> Button:
    """Build the button beside the one that `does` so on the server."""
    button = ui.button("Download", icon="download", on_click=pressed)
    button.props("dense no-caps outline").mark(f"download {does.lower()}").tooltip("to the computer of this browser")
    return button


async def _write(session: Session, name: str, make: Make) -> None:
    place = writable(name, session.folders)
    if not place.parent.is_dir():
        raise OdsError(f"{name}: no such folder")
    await run.io_bound(make, place)
    ui.notify(f"written: {place}", type="positive")


async def send(name: str, make: Make) -> None:
    """Send to the browser what is made under a name. Raises OdsError."""
    plain = Path(name).name
    if not plain:
        raise OdsError("a name is missing")
    content = await run.io_bound(_content, plain, make)
    if content is not None:  # None: the server ends
        ui.download.content(*content)


def _content(name: str, make: Make) -> tuple[bytes, str]:
    """Return what is made under a name, and the name; of a folder its archive."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder, name)
        make(place)
        if place.is_dir():
            place = Path(shutil.make_archive(str(place), "zip", folder, name))
        return place.read_bytes(), place.name
