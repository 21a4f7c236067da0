"""What `ods watch` shows: obstacles, and above all what is not right."""

import json
import math
import sys
import threading
import tomllib
from io import StringIO
from pathlib import Path
from typing import Any

import msgspec
import pytest
import tomli_w
import zmq
from rich.console import Console

from ods import cli
from ods.base import clock
from ods.base.clock import NS
from ods.commands import watched
from ods.commands.watched import received, watch_json
from ods.commands.watched.received import Received
from ods.commands.watched.watch_screen import screen
from ods.messages import Clearance, ClosestApproach, Health, Obstacle, ObstacleList, PoseAt, UnseenPart
from ods.runtime import bus
from ods.runtime.processes import on_board

NOW = 100 * NS
SEEN = Obstacle(
    id=17, state="stand_by", position_ned=(12.3, -4.5, 20.0), velocity_ned=(0.3, 0.4, 0.0), radius_m=2.5,
    sigma_position=(0.1, 0.2, 3.0), sigma_velocity=(0.1, 0.1, 0.1), sigma_radius=0.3, first_seen_utc_ns=0,
    last_seen_utc_ns=0, times_seen=42, existence=0.97, cpa=ClosestApproach(12.0, 4.2, 0.5),
)  # fmt: skip


def shown(newest: ObstacleList | None, health: dict[str, Health]) -> str:
    console = Console(width=200, record=True, file=StringIO())
    console.print(screen(newest, health, NOW))
    return console.export_text()


def picture(age_s: float, valid: bool = True, reasons: list[str] | None = None) -> ObstacleList:
    return ObstacleList(1, 9, NOW - round(age_s * NS), 0, 0, valid, reasons or [], [SEEN])


def report(name: str, age_s: float, problems: list[str]) -> Health:
    return Health(
        name, 1, 0, NOW - round(age_s * NS), 0, True, problems, {"pings": 3}, {"ping": 6.7}, {}, {}, 5.0, 40.0
    )


def test_an_obstacle_is_shown_with_its_uncertainty() -> None:
    text = shown(picture(0.1), {})
    for part in (
        "valid, ping 9, 1 obstacles",
        "17",
        "stand_by",
        "12.3 ±0.1",
        "-4.5 ±0.2",
        "0.50",
        "2.5 ±0.3",
        "4.2 ±0.5, 12",
        "0.97",
        "42",
    ):
        assert part in text


def test_how_far_it_is_clear_ahead_is_one_line() -> None:
    half = math.radians(-40.0)
    west = PoseAt((0.0, 0.0, 5.0), (math.cos(half), 0.0, 0.0, math.sin(half)), (0.0,) * 3, (0.0,) * 3, (0.0,) * 3)
    to_m = [0.0] * 8
    to_m[6] = 42.0  # 270 to 315 deg
    clear = Clearance(1, 9, NOW, 0, True, [3.0 if each else 0.0 for each in to_m], to_m, [None] * 8, pose=west)
    console = Console(width=200, record=True, file=StringIO())
    console.print(screen(picture(0.1), {}, NOW, "", clear))
    north = msgspec.structs.replace(west, attitude=(1.0, 0.0, 0.0, 0.0))
    console.print(screen(picture(0.1), {}, NOW, "", msgspec.structs.replace(clear, pose=north)))
    text = console.export_text()
    assert "clear ahead: from 3 to 42 m; water is known in 1 of 8 sectors" in text
    assert "clear ahead: not known; water is known in 1 of 8 sectors" in text


def test_a_list_of_a_far_range_is_as_old_as_it_was_made() -> None:
    made = msgspec.structs.replace(picture(1.3), made_ns=NOW - NS // 10)
    assert "valid, ping 9" in shown(made, {})
    assert "NOT VALID: no obstacle list for 1.1 s" in shown(
        msgspec.structs.replace(made, made_ns=NOW - 11 * NS // 10), {}
    )


def test_what_is_not_right_is_said() -> None:
    assert "no obstacle list yet" in shown(None, {})
    assert "NOT VALID: no obstacle list for 3.0 s" in shown(picture(3.0), {})
    assert "NOT VALID: no pose for 2 s" in shown(picture(0.1, False, ["no pose for 2 s"]), {})
    text = shown(picture(0.1), {"sonar": report("sonar", 0.1, ["no ping for 2.0 s"]), "nav": report("nav", 9.0, [])})
    assert "no ping for 2.0 s" in text
    assert "silent for 9 s" in text
    assert text.count("not seen") == 2


def test_what_the_sonar_could_not_show_is_shown() -> None:
    part = UnseenPart(-0.785, 0.0, 0.0, 100.0, "no data")
    hidden = msgspec.structs.replace(SEEN, state="active", unseen_s=12.3)
    seen = msgspec.structs.replace(
        picture(0.1), unseen=[part], unseen_share=0.5, unseen_why="no data in 50% of the image", obstacles=[hidden]
    )
    text = shown(seen, {})
    assert "not seen: no data in 50% of the image (within -45 to 0 deg, 0 to 100 m)" in text
    assert "active, unseen 12 s" in text


def test_a_loud_bottom_is_reported_of_and_a_quiet_one_is_not() -> None:
    loud = msgspec.structs.replace(picture(0.1), heard_from_db=17.8)
    assert "objects less than 26 dB over the background may be missing: loud bottom, or high levels" in shown(loud, {})
    assert "bottom" not in shown(msgspec.structs.replace(picture(0.1), heard_from_db=10.9), {})
    assert "bottom" not in shown(picture(0.1), {})


def as_json(newest: ObstacleList | None, health: dict[str, Health], unreachable_reason: str = "") -> dict[str, Any]:
    reported = json.loads(watch_json.text(Received(newest, None, health), NOW, unreachable_reason))
    assert isinstance(reported, dict)
    return reported


def test_one_object_says_what_a_program_asks() -> None:
    reported = as_json(
        picture(0.1), {"sonar": report("sonar", 0.1, ["no ping for 2.0 s"]), "nav": report("nav", 9.0, [])}
    )
    assert (reported["ods"], reported["valid"], reported["reasons"], reported["age_s"]) == (1, True, [], 0.1)
    assert reported["list"]["obstacles"][0]["id"] == 17
    states = {name: process["state"] for name, process in reported["processes"].items()}
    assert states == {"tracker": "not seen", "pipeline": "not seen", "nav": "silent", "sonar": "ready"}
    assert reported["processes"]["sonar"]["problems"] == ["no ping for 2.0 s"]


@pytest.mark.parametrize(
    ("newest", "reasons"),
    [
        (None, ["no obstacle list yet: no socket"]),
        (picture(3.0), ["no obstacle list for 3.0 s"]),
        (picture(0.1, False, ["no pose for 2 s"]), ["no pose for 2 s"]),
    ],
)
def test_one_object_says_why_the_list_is_not_valid(newest: ObstacleList | None, reasons: list[str]) -> None:
    reported = as_json(newest, {}, ": no socket")
    assert (reported["valid"], reported["reasons"], reported["cautions"]) == (False, reasons, [])


def configuration(folder: Path) -> str:
    file = folder / "onboard.toml"
    data = tomllib.loads((Path(__file__).parents[2] / "config" / "onboard.toml").read_text())
    file.write_text(tomli_w.dumps(data | {"bus": {"run_dir": str(folder)}}))
    return str(file)


@pytest.mark.parametrize(("valid", "code"), [(True, 0), (False, 1)])
def test_one_look_ends_when_all_was_received_and_says_by_its_exit_code_whether_the_list_is_valid(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], valid: bool, code: int
) -> None:
    stop = threading.Event()
    publishing = threading.Thread(target=publish, args=(tmp_path, valid, stop))
    publishing.start()
    try:
        assert cli.main(["watch", "--once", "--json", "--config", configuration(tmp_path)]) == code
    finally:
        stop.set()
        publishing.join()
    reported = json.loads(capsys.readouterr().out)
    assert reported["valid"] is valid
    assert reported["clearance"]["seq"] == 1
    assert {reported["processes"][process.name]["state"] for process in on_board()} == {"ready"}


def publish(run_dir: Path, valid: bool, stop: threading.Event) -> None:
    with zmq.Context() as context:
        publishers = {process.name: bus.Publisher(context, run_dir, process.name) for process in on_board()}
        while not stop.wait(0.05):
            now_ns = clock.monotonic_ns()
            reported = msgspec.structs.replace(picture(0.0, valid, [] if valid else ["no ping"]), t_ns=now_ns)
            publishers["tracker"].publish("obstacles", reported)
            publishers["tracker"].publish(
                "clearance", Clearance(1, 9, now_ns, 0, True, [0.0] * 8, [0.0] * 8, [None] * 8)
            )
            for name, publisher in publishers.items():
                publisher.publish(bus.HEALTH, msgspec.structs.replace(report(name, 0.0, []), t_ns=now_ns))
        for publisher in publishers.values():
            publisher.close()


def test_one_look_at_nothing_is_not_valid(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(received, "LOOK_S", 0.1)
    assert cli.main(["watch", "--once", "--json", "--config", configuration(tmp_path)]) == 1
    assert "has no socket of the tracker" in json.loads(capsys.readouterr().out)["reasons"][0]
    assert cli.main(["watch", "--once", "--config", configuration(tmp_path)]) == 1
    assert "no obstacle list yet" in capsys.readouterr().out


def test_one_object_needs_no_rich(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(received, "LOOK_S", 0.1)
    monkeypatch.setitem(sys.modules, "rich.console", None)
    monkeypatch.delitem(sys.modules, "ods.commands.watched.watch_screen")
    monkeypatch.delattr(watched, "watch_screen")
    assert cli.main(["watch", "--once", "--json", "--config", configuration(tmp_path)]) == 1
    assert cli.main(["watch", "--once", "--config", configuration(tmp_path)]) == 2


def test_json_without_once_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["watch", "--json", "--config", configuration(tmp_path)]) == 2
    assert "--json needs --once" in capsys.readouterr().err


def test_a_live_table_without_a_terminal_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["watch", "--config", configuration(tmp_path)]) == 2
    assert "needs a terminal: use --once" in capsys.readouterr().err
