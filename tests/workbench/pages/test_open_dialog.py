"""Files are opened and kept as the dialog says, and what cannot be done is said on the page."""

import time
from pathlib import Path

import pytest
from nicegui import ui
from nicegui.elements.upload_files import SmallFileUpload
from nicegui.testing import User
from nicegui.testing.user_interaction import UserInteraction

from ods.base.files.shipped import shipped_file
from ods.workbench.engine.files import browsing
from ods.workbench.model.state import State
from ods.workbench.pages import frame
from ods.workbench.pages.parts.open_dialog import OpenDialog
from ods.workbench.session import Session
from tests.workbench.pages.visiting import until, visiting


def _build(session: Session) -> None:
    ui.context.client.on_exception(frame._tell)
    ui.button("Open it", on_click=OpenDialog(session).open)


def click(user: User, name: str) -> None:
    """Click at an entry of a list."""
    labels = user.find(kind=ui.item_label, content=name).elements
    items = {item for label in labels for item in label.ancestors() if isinstance(item, ui.item)}
    UserInteraction(user, items, None).click()


async def test_what_cannot_be_read_is_one_line_on_the_page(tmp_path: Path) -> None:
    (tmp_path / "deep.toml").write_text(f"seed = {'[' * 20_000}")
    session = Session(State(), (tmp_path,))
    before = session.state
    async with visiting(session, _build) as user:
        user.find("Open it").click()
        await user.should_see(f"{tmp_path}: 1")
        click(user, "deep.toml")
        await user.should_see("deep.toml: not valid TOML")
        field = user.find("path of a file, or of a folder of segments")
        field.type("/etc/hostname")
        field.trigger("keydown.enter")
        await user.should_see("not under the workbench's folders")
    assert session.state == before


async def test_what_is_dropped_is_kept_and_opened_or_the_page_says_why_not(tmp_path: Path, own_data: Path) -> None:
    session = Session(State(), (tmp_path,))
    scene = shipped_file("scenes/figure11.toml").read_bytes()
    async with visiting(session, _build) as user:
        user.find("Open it").click()
        await user.should_see(f"{tmp_path}: 1")
        user.find(marker="drop").trigger("rejected")  # by the browser: a folder, another ending, too large
        await user.should_see("not taken: one file, no folder")
        (drop,) = user.find(kind=ui.upload).elements
        assert isinstance(drop, ui.upload)
        await drop.handle_uploads([SmallFileUpload("x.toml", "", b"[bus]\n")])
        await user.should_see("not kept: x.toml: ")
        await drop.handle_uploads([SmallFileUpload("../mine.toml", "", scene)])
        await until(lambda: session.state.scene is not None)
    assert (own_data / "uploads" / "mine.toml").read_bytes() == scene
    assert [each.name for each in own_data.iterdir()] in (["uploads", "recent.json"], ["recent.json", "uploads"])


async def test_what_was_opened_is_offered_first_the_next_time(tmp_path: Path, own_data: Path) -> None:
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "mine.toml").write_bytes(shipped_file("scenes/figure11.toml").read_bytes())
    session = Session(State(), (tmp_path,))
    async with visiting(session, _build) as user:
        user.find("Open it").click()
        await user.should_see(f"{tmp_path}: 2")
        click(user, "deep")
        await user.should_see(f"{tmp_path / 'deep'}: 1")
        click(user, "mine.toml")
        await until(lambda: session.state.data.path == str(tmp_path / "deep" / "mine.toml"))
        await until(lambda: (own_data / "recent.json").exists())
        user.find("Open it").click()
        await user.should_see(str(tmp_path / "deep" / "mine.toml"))


async def test_a_folder_that_is_chosen_at_once_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What the dialog begins with comes later than what the user asked for."""
    ended = []

    def slow(_: object) -> list[browsing.Entry]:
        time.sleep(0.5)
        ended.append(True)
        return []

    monkeypatch.setattr(browsing, "recent", slow)
    session = Session(State(), (tmp_path,))
    async with visiting(session, _build) as user:
        user.find("Open it").click()
        await user.should_see("scenes of ODS")
        click(user, "scenes of ODS")
        await user.should_see("figure11.toml")
        await until(lambda: bool(ended))
        await user.should_see("figure11.toml")
        await user.should_not_see(f"{tmp_path}: 0")
