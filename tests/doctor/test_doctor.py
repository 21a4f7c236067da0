"""`ods doctor` says in plain words what is wrong."""

import itertools
import os
import socket
import threading
from collections.abc import Callable
from pathlib import Path

import can
import pytest
import zmq

from ods.base import clock
from ods.base.computer.overload import STARVED, OverloadMonitor
from ods.base.settings_file import load
from ods.cli import main
from ods.config import OnboardConfig
from ods.doctor import chain, plugins
from ods.doctor.finding import Finding
from ods.doctor.lines import serial_device, sonar_port
from ods.doctor.lines.can_interface import controller
from ods.doctor.navigation import listen
from ods.doctor.report import findings
from ods.doctor.running import sockets
from ods.nav_bridge.settings import CanSettings
from ods.pipeline.settings import PipelineSettings
from ods.runtime import bus
from ods.sim_sonar.ins.canopen_ins import SimulatedIns
from ods.sim_sonar.ins.slcan_hub import SlcanHub
from ods.sonar_link.s7k.records import encode_ping
from tests.locked_folder import lock
from tests.sonar_link.sonar_samples import Device, make_ping

CONFIG = Path(__file__).parents[2] / "config" / "onboard.toml"


def config(tmp_path: Path, port: str, can: str = 'interface = "socketcan"\nchannel = "can77"') -> Path:
    text = CONFIG.read_text().replace("/dev/ttyUSB0", port).replace("[bus]", f'[bus]\nrun_dir = "{tmp_path}"')
    text = text.replace('interface = "socketcan"\nchannel = "can0"', can)
    for name in ("ins.eds", "ods_node.eds"):
        text = text.replace(f'"{name}"', f'"{CONFIG.parent / name}"')
    file = tmp_path / "onboard.toml"
    file.write_text(text)
    return file


def levels(found: list[Finding]) -> dict[str, str]:
    return {item.subject: item.level for item in found}


def test_missing_devices_are_wrong_and_exit_code_is_1(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor", "--config", str(config(tmp_path, "/dev/none"))]) == 1
    said = capsys.readouterr().out
    assert (
        "serial port /dev/none: No such file or directory: is the adapter plugged in, and is sonar.port correct?"
        in said
    )
    assert "CAN socketcan can77: no such interface" in said
    assert "2 wrong" in said


def test_what_is_there_is_good(tmp_path: Path) -> None:
    ends = [*os.openpty(), *os.openpty()]
    sonar, adapter = os.ttyname(ends[1]), os.ttyname(ends[3])
    found = list(findings(config(tmp_path, sonar, f'interface = "slcan"\nchannel = "{adapter}"\nbitrate = 500000')))
    assert "wrong" not in levels(found).values()
    assert levels(found)[f"serial port {sonar}"] == "good"
    assert levels(found)[f"CAN slcan {adapter}"] == "good"
    for end in ends:
        os.close(end)


def test_a_plain_file_is_no_serial_port(tmp_path: Path) -> None:
    (tmp_path / "plain").touch()
    (finding,) = sonar_port.examine(str(tmp_path / "plain"))
    assert (finding.level, finding.text) == ("wrong", "is not a serial device")


def test_a_sonar_on_the_network_is_connected_to_but_a_serial_server_left_alone() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = f"127.0.0.1:{server.getsockname()[1]}"
        (there,) = sonar_port.examine(f"tcp://{address}")
        (left_alone,) = sonar_port.examine(f"socket://{address}")
    (away,) = sonar_port.examine(f"tcp://{address}")
    assert (there.level, there.subject, there.text) == ("good", f"sonar tcp://{address}", "takes connections")
    assert left_alone.level == "note"
    assert away.level == "wrong"
    assert away.text == "Connection refused: is the sonar on, is the cable connected, and is sonar.port correct?"


def test_a_wrong_stage_and_a_wrong_key_are_found(tmp_path: Path) -> None:
    file = config(tmp_path, "/dev/none")
    good = file.read_text()
    file.write_text(good.replace("[tracker.map]", '[[pipeline.stage]]\nuse = "filter.magic"\n\n[tracker.map]'))
    wrong = {item.subject: item.text for item in findings(file) if item.level == "wrong"}
    assert "filter.magic" in " ".join(wrong.values())
    file.write_text(good.replace("[site]", "[sight]"))
    assert levels(list(findings(file)))["configuration"] == "wrong"


def test_a_stage_that_raises_at_its_first_image_is_wrong(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(
        "from ods.base.settings import Settings\n"
        "from ods.pipeline.stage.registry import image_stage\n"
        "class Params(Settings, frozen=True): pass\n"
        "@image_stage('doctor.raises', Params)\n"
        "def prepare(params, fan):\n"
        "    def step(source, out): raise ArithmeticError('at the first image')\n"
        "    return step\n"
    )
    settings = PipelineSettings(
        plugins=(tmp_path / "mine.py",), stage=({"use": "doctor.raises"}, {"use": "detect.one_level"})
    )
    (found,) = chain.examine(settings)
    assert found.level == "wrong"
    assert "doctor.raises" in found.text
    assert "at the first image" in found.text


@pytest.mark.usefixtures("registers")
def test_parts_of_ones_own_are_tried(tmp_path: Path) -> None:
    file = config(tmp_path, "/dev/none")
    (tmp_path / "mine.py").write_text(
        "from ods.tracker.association.registry import association\n"
        "@association('doctor.raises')\n"
        "def raises(question): raise ArithmeticError('at the first echo')\n"
    )
    example = Path(__file__).parents[2] / "docs" / "examples" / "user_sonar.py"
    (tmp_path / "sonar.py").write_text(example.read_text().replace('"sketch"', '"doctor.sketch"'))
    text = file.read_text()
    text = text.replace("[sonar]", '[sonar]\nplugins = ["sonar.py"]\nprotocol = "doctor.sketch"')
    text = text.replace(
        "[tracker.map]", '[tracker]\nplugins = ["mine.py"]\nassociation = "doctor.raises"\n[tracker.map]'
    )
    file.write_text(f'{text}\n[recordings]\nplugins = ["none.py"]\n')
    found = {item.subject: (item.level, item.text) for item in plugins.examine(load(file, OnboardConfig))}
    assert found["tracker"] == ("wrong", "ArithmeticError: at the first echo")
    assert found["sonar protocol"] == ("good", "doctor.sketch is known and survives noise")
    level, said = found["recordings"]
    assert level == "wrong"
    assert said.startswith(f"recordings.plugins[0] ({tmp_path / 'none.py'}): FileNotFoundError")


def test_a_dbc_error_is_said_once(tmp_path: Path) -> None:
    text = (CONFIG.parent / "onboard-sbg.toml").read_text().replace("EKF_POS.", "EKF_PO.")
    (tmp_path / "sbg.dbc").write_bytes((CONFIG.parent / "sbg.dbc").read_bytes())
    (tmp_path / "onboard.toml").write_text(text)
    found = [item for item in findings(tmp_path / "onboard.toml", 0.1) if item.subject.startswith("navigation")]
    assert [item.level for item in found] == ["wrong"]
    assert "(did you mean SBG_ECAN_MSG_EKF_POS)" in found[0].text


def test_a_line_that_is_not_there_is_reported_once(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = f"tcp://127.0.0.1:{server.getsockname()[1]}"
    file = config(tmp_path, port, 'interface = "slcan"\nchannel = "/dev/none"\nbitrate = 500000')
    wrong = [item.subject for item in findings(file, 0.1) if item.level == "wrong"]
    assert wrong == [f"sonar {port}", "CAN slcan /dev/none"]


@pytest.mark.parametrize(("start_ins", "level"), [(True, "note"), (False, "wrong")])
def test_an_ins_that_waits_to_be_started_is_one_line(tmp_path: Path, start_ins: bool, level: str) -> None:
    near, far_end = tmp_path / "can0", tmp_path / "can1"
    file = config(tmp_path, "/dev/none", f'interface = "slcan"\nchannel = "{near}"\nbitrate = 500000')
    file.write_text(file.read_text().replace("[nav.canopen]", f"[nav.canopen]\nstart_ins = {str(start_ins).lower()}"))
    with SlcanHub([near, far_end]), can.Bus(str(far_end), "slcan", sleep_after_open=0.0) as far:
        heartbeat = can.Message(arbitration_id=0x705, data=[127], is_extended_id=False)
        far.send_periodic(heartbeat, 0.1)
        (found,) = listen(load(file, OnboardConfig), 0.7)
    assert found.level == level
    assert found.text.startswith("the INS waits to be started")
    assert "start_ins" in found.text


@pytest.mark.parametrize(
    ("load", "why"),
    [("", "it hangs, or is starting"), (STARVED, f"it hangs, or is starting, or is only late, as {STARVED}")],
)
def test_running_processes_are_asked_how_they_are(
    load: str, why: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On a busy computer one that is silent may hang all the same."""
    monkeypatch.setattr(OverloadMonitor, "problem", lambda *_: load)
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    publisher = bus.Publisher(context, tmp_path, "nav")
    nothing = {item.subject: (item.level, item.text) for item in sockets(tmp_path)}
    assert nothing["nav"] == ("wrong", f"runs, but gave no sign of life within 1.5 s: {why}")
    assert nothing["sonar"] == ("wrong", "does not run, although others do")
    publisher.close()
    context.term()
    assert [item.level for item in sockets(tmp_path)] == ["note"]


def test_a_run_folder_in_a_folder_that_may_not_be_looked_into_is_wrong(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lock(monkeypatch, tmp_path)
    assert list(sockets(tmp_path / "run")) == [
        Finding("wrong", "sockets", f"{tmp_path / 'run'} may not be used by this user")
    ]


def link(**data: object) -> dict[str, object]:
    """Return what `ip -details -json link show` says of a CAN controller; keys as iproute2 6.1 writes them."""
    timing = {"bittiming": {"bitrate": 500000, "sample_point": "0.875"}}
    return {"linkinfo": {"info_kind": "can", "info_data": timing | data}}


@pytest.mark.parametrize(
    ("details", "level", "said"),
    [
        (
            link(state="ERROR-ACTIVE", restart_ms=100),
            ["good"],
            "is up, 500000 bit/s, sample point 0.875, error-active, restart-ms 100",
        ),
        (
            link(state="ERROR-ACTIVE", restart_ms=100, bittiming={"bitrate": 250000}),
            ["good", "wrong"],
            "runs at 250000 bit/s, but nav.can.bitrate, not used by socketcan, says 500000",
        ),
        (
            link(state="ERROR-ACTIVE", restart_ms=100, bittiming={}, bittiming_bitrate=500000),
            ["good"],
            "is up, 500000 bit/s, error-active",
        ),
        (link(state="ERROR-ACTIVE", restart_ms=100, ctrlmode=["LISTEN-ONLY"]), ["good", "note"], "is listen-only"),
        (link(state="ERROR-ACTIVE"), ["good", "note"], "type can restart-ms 100"),
        (link(state="BUS-OFF", restart_ms=100), ["wrong"], "bus-off: wiring, termination or bit rate"),
        (link(state="ERROR-PASSIVE", restart_ms=100), ["wrong"], "no other node acknowledges"),
        ({"linkinfo": {"info_kind": "vcan"}}, ["good"], "is up (vcan)"),
        ({}, ["good"], "is iproute2 installed?"),
    ],
)
def test_the_state_of_the_can_controller_in_plain_words(
    details: dict[str, object], level: list[str], said: str
) -> None:
    found = list(controller("CAN", CanSettings(bitrate=500000), details))
    assert [item.level for item in found] == level
    assert said in found[-1].text


def test_the_hardware_page_quotes_a_good_controller_word_for_word() -> None:
    page = (CONFIG.parents[1] / "docs" / "hardware" / "can.md").read_text()
    [item] = controller("CAN socketcan can0", CanSettings(), link(state="ERROR-ACTIVE", restart_ms=100))
    assert f"    {item.level:6} {item.subject}: {item.text}\n" in page


def test_a_network_interface_that_is_no_can_interface(tmp_path: Path) -> None:
    found = list(findings(config(tmp_path, "/dev/none", 'interface = "socketcan"\nchannel = "lo"')))
    assert "is not a CAN interface" in next(item.text for item in found if item.subject == "CAN socketcan lo")


def test_listening_tells_what_comes_what_does_not_and_how_many_poses(tmp_path: Path) -> None:
    near, far_end = tmp_path / "can0", tmp_path / "can1"
    file = config(tmp_path, "/dev/none", f'interface = "slcan"\nchannel = "{near}"\nbitrate = 500000')
    settings = load(file, OnboardConfig)
    with SlcanHub([near, far_end]), can.Bus(str(far_end), "slcan", sleep_after_open=0.0) as far:
        ins = SimulatedIns(far, CONFIG.parent / "ins.eds")
        stopping = threading.Event()

        def send(only: list[int] | None) -> None:
            while not stopping.wait(0.01):
                ins.send(clock.utc_ns() // 1_000_000 * 1_000_000, (1, 2, 3), (1, 0, 0, 0), (1, 0, 0), only=only)

        for only, level in ((None, "good"), ([1, 2, 3, 4, 6], "wrong")):
            stopping.clear()
            thread = threading.Thread(target=send, args=(only,))
            thread.start()
            found = {item.subject: item for item in reversed(list(listen(settings, 0.5)))}  # first of each: the verdict
            stopping.set()
            thread.join()
            assert found["CAN 0x685"].level == level
            assert found["CAN 0x705"].text.startswith("heartbeat: ")
            assert found["navigation by canopen"].level == level
            if level == "good":
                assert "north 1.0, east 2.0, down 3.0 m, roll 0.0, pitch 0.0, yaw 0.0 deg" in (
                    found["navigation by canopen"].text
                )
        assert "never came" in found["CAN 0x685"].text
        assert "epoch_torn" in found["navigation by canopen"].text
        (silent,) = listen(settings, 0.2)
        assert silent.text.startswith("no expected data within 0.2 s (")
        stranger = can.Message(arbitration_id=0x286, data=bytes(8), is_extended_id=False)
        far.send_periodic(stranger, 0.05)
        (instead,) = listen(settings, 0.6)
        assert "others came: 0x286): is the INS on, connected and set to send" in instead.text


def test_listening_tells_a_slow_message_an_emergency_and_a_rate_that_is_too_low(tmp_path: Path) -> None:
    near, far_end = tmp_path / "can0", tmp_path / "can1"
    file = config(tmp_path, "/dev/none", f'interface = "slcan"\nchannel = "{near}"\nbitrate = 500000')
    with SlcanHub([near, far_end]), can.Bus(str(far_end), "slcan", sleep_after_open=0.0) as far:
        ins = SimulatedIns(far, CONFIG.parent / "ins.eds")
        stopping = threading.Event()

        def send() -> None:
            for number in itertools.count():
                if stopping.wait(0.02):
                    return
                whole = number % 25 == 0
                only = None if whole else [1, 2, 3, 4, 5]
                ins.send(clock.utc_ns() // 1_000_000 * 1_000_000, (1, 2, 3), (1, 0, 0, 0), (1, 0, 0), only=only)
                if whole:
                    ins.emergency(0x8110)

        thread = threading.Thread(target=send)
        thread.start()
        found = list(listen(load(file, OnboardConfig), 1.5))
        stopping.set()
        thread.join()
    slow = next(item for item in found if item.subject == "CAN 0x6A5")
    assert slow.level == "note"
    assert "a pose needs all of them" in slow.text
    wrong = [item.text for item in found if item.level == "wrong"]
    assert "the tracker bridges 0.3 s" in wrong[0]
    assert any("8110" in text for text in wrong[1:])


def test_an_adapter_that_holds_bytes_back_is_noted(tmp_path: Path) -> None:
    timer = tmp_path / "ttyUSB7" / "latency_timer"
    timer.parent.mkdir()
    for held_ms, levels_found in (("16", ["note"]), ("1", []), ("?", [])):
        timer.write_text(held_ms + "\n")
        found = list(serial_device.latency_timer("adapter", "/dev/ttyUSB7", tmp_path))
        assert [item.level for item in found] == levels_found
    assert not list(serial_device.latency_timer("adapter", "/dev/ttyS0", tmp_path))


def test_bytes_that_change_on_the_way_are_noted_but_not_the_rest_of_a_ping_at_the_start(tmp_path: Path) -> None:
    device = Device(tmp_path / "seabat")
    settings = load(config(tmp_path, str(device.link)), OnboardConfig)
    stopping = threading.Event()

    def send() -> None:
        number = 0
        device.send(encode_ping(make_ping(number))[-300:])
        while not stopping.wait(0.02):
            number += 1
            data = bytearray(encode_ping(make_ping(number)))
            data[-100] ^= number == 5
            device.send(bytes(data))

    sender = threading.Thread(target=send)
    sender.start()
    good, *notes = sonar_port.listen(settings, 0.5)
    stopping.set()
    sender.join()
    device.unplug()
    assert good.level == "good"
    assert "% of 12000000 baud" in good.text
    assert {item.level for item in notes} == {"note"}
    reported = " ".join(item.text for item in notes)
    assert "bad_checksum 1: the line damages bytes" in reported
    assert "lost_pings 1" in reported


@pytest.mark.parametrize(
    ("sends", "level", "said"),
    [
        (lambda number: encode_ping(make_ping(number)), "good", "pings/s; records 7000 at"),
        (lambda number: encode_ping(make_ping(number))[:400], "wrong", ": 7042 or 7018 never arrived complete; switch"),
        (
            lambda _: b"$GPGGA,115739.00,4158.8441367,N\r\n",
            "wrong",
            "records came: check baud, wiring and protocol",
        ),
        (lambda _: b"", "wrong", "no s7k record within 0.5 s; it is silent"),
    ],
    ids=["pings", "cut off", "another protocol", "silence"],
)
def test_listening_to_the_sonar(tmp_path: Path, sends: Callable[[int], bytes], level: str, said: str) -> None:
    device = Device(tmp_path / "seabat")
    settings = load(config(tmp_path, str(device.link)), OnboardConfig)
    stopping = threading.Event()

    def send() -> None:
        number = 0
        while not stopping.wait(0.05):
            number += 1
            device.send(sends(number))

    sender = threading.Thread(target=send)
    sender.start()
    (found,) = sonar_port.listen(settings, 0.5)
    stopping.set()
    sender.join()
    device.unplug()
    assert found.level == level
    assert said in found.text
