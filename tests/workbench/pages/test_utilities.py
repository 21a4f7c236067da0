"""Files are opened and written as the menu says, and what cannot be done is said on the page."""

import tomllib
from pathlib import Path

import pytest
from nicegui import ui
from nicegui.elements.upload_files import SmallFileUpload

from ods.base.errors import OdsError
from ods.base.files.shipped import shipped_file
from ods.workbench.engine.files.config_file import load_config
from ods.workbench.engine.files.openable import opening
from ods.workbench.model import actions as do
from ods.workbench.model.share import shared_text
from ods.workbench.model.state import State, Tuning
from ods.workbench.pages import frame, utilities
from ods.workbench.session import Session
from tests.workbench.engine.test_rerun import START
from tests.workbench.model.test_history import LAST
from tests.workbench.pages.visiting import until, visiting

HIGH = f"pipeline.stage[{LAST}].high"


def _build(session: Session) -> None:
    ui.context.client.on_exception(frame._tell)
    utilities.build(session)


def _session(folder: Path) -> Session:
    session = Session(State(), (folder,))
    session.do(do.SetTuning(Tuning(config=session.loaded.config), "as loaded"))
    return session


async def test_a_tuned_configuration_is_shown_as_a_difference_and_then_written(tmp_path: Path) -> None:
    session = _session(tmp_path)
    async with visiting(session, _build) as user:
        session.do(do.SetSetting(HIGH, 7.5))
        await user.should_see("1 setting differ")
        user.find(marker="save").click()
        await until(lambda: list(tmp_path.glob("*-tuned.toml")))
    written = tomllib.loads((tmp_path / "onboard-tuned.toml").read_text())
    assert written["pipeline"]["stage"][LAST]["high"] == 7.5


async def test_a_preset_is_kept_and_shown_again(tmp_path: Path) -> None:
    session = _session(tmp_path)
    session.do(do.SetSetting(HIGH, 7.5))
    wanted = session.state
    async with visiting(session, _build) as user:
        user.find("keep all as it is now as").type("high")
        user.find(marker="keep preset").click()
        await until(lambda: (tmp_path / "workbench-presets" / "high.preset").exists())
        session.undo()
        assert session.state != wanted
        user.find("show what somebody sent").type(f"http://127.0.0.1:1/#state={shared_text(wanted)}")
        user.find(marker="take link").click()
        await until(lambda: session.state == wanted)


async def test_what_is_no_link_is_said(tmp_path: Path) -> None:
    session = _session(tmp_path)
    before = session.state
    async with visiting(session, _build) as user:
        user.find("show what somebody sent").type("nonsense")
        user.find(marker="take link").click()
        await user.should_see("link: no state of a workbench")
    assert session.state == before


async def test_a_file_elsewhere_is_not_written(tmp_path: Path) -> None:
    session = _session(tmp_path / "in")
    (tmp_path / "in").mkdir()
    async with visiting(session, _build) as user:
        field = user.find("file to write")
        field.clear()
        field.type(str(tmp_path / "out.toml"))
        user.find(marker="save").click()
        await user.should_see("not under the workbench's folders")
    assert not (tmp_path / "out.toml").exists()


async def test_what_cannot_be_read_is_one_line_on_the_page(tmp_path: Path) -> None:
    (tmp_path / "deep.toml").write_text(f"seed = {'[' * 20_000}")
    session = _session(tmp_path)
    before = session.state
    async with visiting(session, _build) as user:
        field = user.find("path of a file, or of a folder of segments")
        field.type(str(tmp_path / "deep.toml"))
        field.trigger("keydown.enter")
        await user.should_see("deep.toml: not valid TOML")
    assert session.state == before


async def test_what_is_dropped_is_kept_and_opened_or_the_page_says_why_not(tmp_path: Path) -> None:
    session = _session(tmp_path)
    scene = shipped_file("scenes/figure11.toml").read_bytes()
    async with visiting(session, _build) as user:
        user.find(marker="drop").trigger("rejected")  # by the browser: a folder, another ending, too large
        await user.should_see("not taken: a file, no folder")
        (drop,) = user.find(kind=ui.upload).elements
        assert isinstance(drop, ui.upload)
        await drop.handle_uploads([SmallFileUpload("../mine.toml", "", scene)])
        await until(lambda: session.state.scene is not None)
    assert (tmp_path / "mine.toml").read_bytes() == scene
    assert [each.name for each in tmp_path.iterdir()] == ["mine.toml"]


async def test_a_ping_is_printed_and_a_macro_written(tmp_path: Path) -> None:
    session = _session(tmp_path)
    session.do(opening(shipped_file("scenes/figure11.toml").resolve(), [Path.cwd()]))
    async with visiting(session, _build) as user:
        user.find(marker="print").click()
        await until(lambda: (tmp_path / "ping.png").exists())
        user.find(marker="write").click()
        await until(lambda: (tmp_path / "macro" / "commands.sh").exists())
    assert "ods track scene.toml" in (tmp_path / "macro" / "commands.sh").read_text()


async def test_the_echogram_is_printed(tmp_path: Path) -> None:
    session = Session(START, (tmp_path,))
    async with visiting(session, _build) as user:
        (what,) = user.find(marker="printed").elements
        assert isinstance(what, ui.select)
        what.set_value("echogram")
        user.find(marker="print").click()
        await until(lambda: (tmp_path / "echogram.png").exists())
    assert (tmp_path / "echogram.png").read_bytes().startswith(b"\x89PNG")


async def test_a_ping_is_marked_and_found_again(tmp_path: Path) -> None:
    session = _session(tmp_path)
    session.do(do.ShowPing(7))
    async with visiting(session, _build) as user:
        user.find("mark the ping that is shown as").type("first echo")
        user.find(marker="mark ping").click()
        await user.should_see("ping 7: first echo")
        session.do(do.ShowPing(0))
        user.find("ping 7: first echo").click()
        await until(lambda: session.state.ping == 7)


def _with_plugins(table: str, named: str) -> str:
    """Return a configuration with plug-ins in a table that it may not have had."""
    text, line = shipped_file("onboard.toml").read_text(), f"plugins = [{named}]\n"
    head, title, rest = text.partition(f"\n[{table}]")
    if not title:
        return f"{text}\n[{table}]\n{line}"
    comment, _, rest = rest.partition("\n")
    return f"{head}{title}{comment}\n{line}{rest}"


async def test_a_configuration_with_code_of_its_own_is_refused(tmp_path: Path) -> None:
    (tmp_path / "evil.py").write_text(f"open({str(tmp_path / 'ran')!r}, 'w')\n")
    (tmp_path / "evil.toml").write_text(_with_plugins("pipeline", f'"{tmp_path}/evil.py"'))
    session = _session(tmp_path)
    before, loaded = session.state, session.loaded
    async with visiting(session, _build) as user:
        field = user.find("file to write")
        field.clear()
        field.type(str(tmp_path / "evil.toml"))
        user.find(marker="load").click()
        await user.should_see("pipeline.plugins[0]")
        await user.should_see("a plug-in is code")
    assert (session.state, session.loaded) == (before, loaded)
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize("table", ["pipeline", "tracker"])
def test_plugins_that_the_first_configuration_names_may_be_loaded(tmp_path: Path, table: str) -> None:
    plugin = _with_plugins(table, f'"{tmp_path}/own.py", "own_module"')
    (tmp_path / "own.py").write_text("")
    for name, text in {"first": plugin, "second": plugin, "third": plugin.replace("own_", "other_")}.items():
        (tmp_path / f"{name}.toml").write_text(text)
    session = Session(State(), (tmp_path,), load_config(tmp_path / "first.toml"))
    session.load(tmp_path / "second.toml")
    assert session.loaded.path == tmp_path / "second.toml"
    with pytest.raises(OdsError, match=rf"{table}\.plugins\[1\] \(other_module\)"):
        session.load(tmp_path / "third.toml")
    assert session.loaded.path == tmp_path / "second.toml"
