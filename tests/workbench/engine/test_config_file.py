"""What is saved runs on board: it says what was tuned, and all else as it was."""

import tomllib
from pathlib import Path

import pytest

from ods.base.errors import OdsError
from ods.base.settings_file import load
from ods.config import OnboardConfig, part_of
from ods.offline.mission import MissionSettings
from ods.workbench.engine.files.config_file import for_folder, load_config, saving, write_config
from ods.workbench.model import actions as do
from ods.workbench.model.apply import apply
from ods.workbench.model.state import State, Tuning
from tests.workbench.model.test_history import LAST

OWN = """# our vehicle
[bus]
[site]
latitude_deg = 57.0  # the harbour
longitude_deg = 9.0
[sonar]
port = "/dev/ttyS1"
[sonar.mounting]
pitch_deg = -5.0
[nav.canopen]
ins_eds = "ins.eds"
node_eds = "ods_node.eds"
[nav.can]
interface = "virtual"
[pipeline]
min_range_m = 0.5   # the ring
[[pipeline.stage]]
use = "equalize.mean_range"
[[pipeline.stage]]
use = "detect.two_level"   # as in May
high = 6.5
"""


def _tuned(start: Tuning, *actions: do.Action) -> Tuning:
    state = State(tuning=start)
    for action in actions:
        state = apply(state, action)
    return state.tuning


CHANGES: tuple[tuple[do.Action, ...], ...] = (
    (do.SetSetting("pipeline.stage[1].high", 7.0),),
    (do.SetSetting("pipeline.stage[1].low", 3.0), do.SetSetting("tracker.observer", "independent")),
    (do.AddStage("filter.median", 1), do.SetSetting("pipeline.stage[1].window", 5)),
    (do.RemoveStage(0),),
    (do.SetSetting("mounting.pitch_deg", -7.0),),
    (do.SetSetting("pipeline.attention.near_m", 20.0), do.SetSetting("pipeline.min_range_m", 0.1)),
    (do.SetSetting("tracker.planner.lead_times_s", [1.0, 2.0]),),
)


@pytest.mark.parametrize("actions", CHANGES)
def test_the_file_saved_loads_as_what_was_tuned(tmp_path: Path, actions: tuple[do.Action, ...]) -> None:
    file = tmp_path / "own.toml"
    file.write_text(OWN)
    loaded = load_config(file)
    tuning = _tuned(Tuning(config=loaded.config), *actions)
    written = write_config(saving(loaded, tuning).text, tmp_path / "tuned.toml", [tmp_path])
    assert part_of(load(written, OnboardConfig), MissionSettings) == tuning.mission()
    others = ("bus", "site", "nav", "record")
    before, after = tomllib.loads(OWN), tomllib.loads(written.read_text())
    assert {name: before.get(name) for name in others} == {name: after.get(name) for name in others}
    assert "# our vehicle" in written.read_text()
    assert "# the harbour" in written.read_text()


def test_a_file_in_another_folder_names_the_same_files(tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    file.write_text(OWN)
    (tmp_path / "ins.eds").write_text("")
    loaded = load_config(file)
    (tmp_path / "tuned").mkdir()
    text = for_folder(loaded.text, loaded, tmp_path / "tuned")
    named = tomllib.loads(text)["nav"]["canopen"]
    assert named == {"ins_eds": str(tmp_path / "ins.eds"), "node_eds": "ods_node.eds"}  # one is not there
    assert [line for line in OWN.splitlines() if line not in text.splitlines()] == ['ins_eds = "ins.eds"']
    assert for_folder(loaded.text, loaded, tmp_path) == OWN


def test_only_what_was_tuned_is_in_the_difference(tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    file.write_text(OWN)
    loaded = load_config(file)
    would = saving(loaded, _tuned(Tuning(config=loaded.config), do.SetSetting("pipeline.stage[1].high", 7.0)))
    assert [(change.path, change.before, change.after) for change in would.changes] == [
        ("pipeline.stage[1].high", 6.5, 7.0)
    ]
    changed = [line for line in would.difference(loaded).splitlines()[2:] if line[0] in "+-"]
    assert changed == ["-high = 6.5", "+high = 7.0"]
    assert "# as in May" in would.text


def test_nothing_tuned_is_no_difference() -> None:
    loaded = load_config()
    would = saving(loaded, Tuning(config=loaded.config))
    assert (would.changes, would.text, would.difference(loaded)) == ([], loaded.text, "")


def test_the_default_chain_written_out_but_unchanged_is_no_difference() -> None:
    loaded = load_config()
    high = loaded.config.pipeline.chain()[LAST]["high"]
    tuning = _tuned(
        Tuning(config=loaded.config),
        do.SetSetting(f"pipeline.stage[{LAST}].high", 9.0),
        do.SetSetting(f"pipeline.stage[{LAST}].high", high),
    )
    assert saving(loaded, tuning).changes == []


def test_a_stage_bypassed_is_not_saved() -> None:
    loaded = load_config()
    tuning = _tuned(Tuning(config=loaded.config), do.BypassStage(0, True))
    chain = tomllib.loads(saving(loaded, tuning).text)["pipeline"]["stage"]
    assert chain == list(loaded.config.pipeline.chain()[1:])


def test_files_elsewhere_are_not_written(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "link").symlink_to(tmp_path)
    for path in (tmp_path / "out.toml", tmp_path / "in" / ".." / "out.toml", Path("/etc/passwd")):
        with pytest.raises(OdsError, match="not under the workbench's folders"):
            write_config("", path, [tmp_path / "in"])


def test_what_would_not_load_is_not_written(tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    file.write_text(OWN)
    with pytest.raises(OdsError):
        write_config("[bus]\nno_such_key = 1\n", file, [tmp_path])
    assert file.read_text() == OWN
    assert [each.name for each in tmp_path.iterdir()] == ["own.toml"]
