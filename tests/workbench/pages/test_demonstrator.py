"""The gallery on its page."""

from pathlib import Path

import pytest
from nicegui import ui

from ods.workbench.engine.gallery.demos import demos
from ods.workbench.engine.gallery.results import made
from ods.workbench.model.state import State, Tuning
from ods.workbench.pages import demonstrator
from ods.workbench.session import Session
from tests.workbench.engine.test_gallery import SHORT
from tests.workbench.pages.visiting import until, visiting


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    shown = [SHORT, *(each for each in demos([]) if each.key in ("oculus", "didson"))]
    monkeypatch.setattr(demonstrator, "demos", lambda _: shown)
    monkeypatch.setattr(demonstrator, "gallery_folder", lambda: tmp_path)
    return tmp_path


async def test_pictures_come_as_they_are_made_and_what_is_missing_is_said(folder: Path) -> None:
    session = Session()
    async with visiting(session, demonstrator.build) as user:
        await user.should_see("Not here: no .avi file")
        (facts,) = user.find(kind=ui.label, marker="short").elements
        await until(lambda: facts.text.startswith("14 pings"), 240.0)
        assert len(user.find(kind=ui.image).elements) == 2
    assert list(folder.glob("oculus-*.png"))


async def test_what_was_made_before_shows_at_once_and_opens(folder: Path) -> None:
    session = Session()
    made(SHORT, State(tuning=Tuning(session.loaded.config)), folder)
    async with visiting(session, demonstrator.build) as user:
        (facts,) = user.find(kind=ui.label, marker="short").elements
        assert facts.text.startswith("14 pings")
        user.find(kind=ui.button, marker="short").click()
        assert session.state.scene == SHORT.scene
        assert session.history.undoes == "gallery: Short"
        session.undo()
        assert session.state.scene is None
