"""`ods doctor` says in plain words what is wrong."""

import os
import socket
import tty
from pathlib import Path

import pytest
import zmq

from ods import bus, doctor
from ods.cli import main

CONFIG = Path(__file__).parents[1] / "config" / "onboard.toml"


def config(tmp_path: Path, port: str, can: str = 'interface = "socketcan"\nchannel = "can77"') -> Path:
    text = CONFIG.read_text().replace("/dev/ttyUSB0", port).replace('run_dir = "/tmp/ods"', f'run_dir = "{tmp_path}"')
    text = text.replace('interface = "socketcan"\nchannel = "can0"', can)
    for name in ("ins.eds", "ods_node.eds"):
        text = text.replace(f'"{name}"', f'"{CONFIG.parent / name}"')
    file = tmp_path / "onboard.toml"
    file.write_text(text)
    return file


def levels(found: list[doctor.Finding]) -> dict[str, str]:
    return {item.subject: item.level for item in found}


def test_missing_devices_are_wrong_and_exit_code_is_1(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor", "--config", str(config(tmp_path, "/dev/none"))]) == 1
    said = capsys.readouterr().out
    assert "serial port /dev/none: No such file or directory: is the adapter plugged in, and sonar.port right?" in said
    assert "CAN socketcan can77: no such interface" in said
    assert "2 wrong" in said


def test_what_is_there_is_good(tmp_path: Path) -> None:
    master, slave = os.openpty()
    tty.setraw(slave)
    name = os.ttyname(slave)
    found = list(doctor.findings(config(tmp_path, name, f'interface = "slcan"\nchannel = "{name}"')))
    assert "wrong" not in levels(found).values()
    assert levels(found)[f"serial port {name}"] == "good"
    assert levels(found)[f"CAN slcan {name}"] == "good"
    os.close(master)
    os.close(slave)


def test_a_plain_file_is_no_serial_port(tmp_path: Path) -> None:
    (tmp_path / "plain").touch()
    (finding,) = doctor.serial_port(str(tmp_path / "plain"))
    assert (finding.level, finding.text) == ("wrong", "is no serial device")


def test_a_sonar_on_the_network_is_connected_to_but_a_serial_server_left_alone() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = f"127.0.0.1:{server.getsockname()[1]}"
        (there,) = doctor.serial_port(f"tcp://{address}")
        (left_alone,) = doctor.serial_port(f"socket://{address}")
    (away,) = doctor.serial_port(f"tcp://{address}")
    assert (there.level, there.subject, there.text) == ("good", f"sonar tcp://{address}", "takes connections")
    assert left_alone.level == "note"
    assert away.level == "wrong"
    assert away.text == "Connection refused: is the sonar on, the cable in, and sonar.port right?"


def test_a_wrong_stage_and_a_wrong_key_are_found(tmp_path: Path) -> None:
    file = config(tmp_path, "/dev/none")
    good = file.read_text()
    file.write_text(good.replace("[tracker.map]", '[[pipeline.stage]]\nuse = "filter.magic"\n\n[tracker.map]'))
    wrong = {item.subject: item.text for item in doctor.findings(file) if item.level == "wrong"}
    assert "filter.magic" in " ".join(wrong.values())
    file.write_text(good.replace("[site]", "[sight]"))
    assert levels(list(doctor.findings(file)))["configuration"] == "wrong"


def test_running_processes_are_asked_how_they_are(tmp_path: Path) -> None:
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    publisher = bus.Publisher(context, tmp_path, "nav")
    nothing = {item.subject: (item.level, item.text) for item in doctor.sockets(tmp_path)}
    assert nothing["nav"] == ("wrong", "runs, but gave no sign of life within 1.5 s")
    assert nothing["sonar"] == ("wrong", "does not run, though others do")
    publisher.close()
    context.term()
    assert [item.level for item in doctor.sockets(tmp_path)] == ["note"]
