"""The port: opened when it is there, lost when it is gone, opened again; on real pseudo-terminals."""

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from ods.runtime.port.serial_port import SerialPort
from tests.sonar_link.sonar_samples import Device

MS = 1_000_000


@pytest.fixture
def link(tmp_path: Path) -> Path:
    return tmp_path / "seabat"


@pytest.fixture
def device(link: Path) -> Iterator[Device]:
    made = Device(link)
    yield made
    made.unplug()


def make_port(path: Path | str) -> SerialPort:
    return SerialPort(str(path), 12_000_000, (0.1, 1.0))


def test_bytes_come_through_unchanged_and_reading_never_blocks(device: Device) -> None:
    port = make_port(device.link)
    assert port.open_if_due(0)
    assert port.fault == ""
    assert port.read(0) == b""
    every = bytes(range(256))
    os.write(device.master, every)
    assert port.read(0) == every
    assert port.counters == {"port_opens": 1}
    port.close()
    assert port.fd is None


def test_pauses_double_up_to_the_limit_until_data_come(link: Path) -> None:
    port = make_port(link)
    tried_ms = [ms for ms in range(5000) if _tries(port, ms)]
    assert tried_ms == [0, 100, 300, 700, 1500, 2500, 3500, 4500]
    assert port.fault == f"{link}: no such file or directory"
    device = Device(link)
    assert port.open_if_due(6000 * MS)
    os.write(device.master, b"x")
    assert port.read(6000 * MS) == b"x"
    device.unplug()
    assert port.read(6000 * MS) == b""
    assert [ms for ms in range(6000, 6400) if _tries(port, ms)] == [6100, 6300]
    assert (port.counters["port_opens"], port.counters["port_losses"]) == (1, 1)


def _tries(port: SerialPort, ms: int) -> bool:
    before = port.counters["port_open_errors"]
    port.open_if_due(ms * MS)
    return port.counters["port_open_errors"] > before


def test_why_a_port_is_not_open_is_logged_once_and_that_data_arrive_again(
    link: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("INFO")
    port = make_port(link)
    for ms in range(3000):
        port.open_if_due(ms * MS)
    assert caplog.messages == [f"{link}: no such file or directory; trying again"]
    device = Device(link)
    assert port.open_if_due(6000 * MS)
    os.write(device.master, b"x")
    assert port.read(6000 * MS) == b"x"
    assert caplog.messages[1:] == [f"{link}: data arrive again"]
    device.unplug()
    assert port.read(6000 * MS) == b""
    assert len(caplog.messages) == 3
    assert caplog.messages[2].endswith("; trying again")


def test_a_vanished_path_and_a_replaced_device_are_noticed_without_a_read_error(device: Device) -> None:
    port = make_port(device.link)
    port.open_if_due(0)
    port.check(0)
    assert port.fd is not None
    device.link.unlink()
    port.check(0)
    assert port.fault == f"{device.link}: no such file or directory"
    second = Device(device.link)
    assert port.open_if_due(200 * MS)
    third = Device(device.link)
    port.check(300 * MS)
    assert port.counters["port_losses"] == 2
    assert port.fault == f"{device.link}: the device was replaced"
    second.unplug()
    third.unplug()


def test_one_reader_at_a_time(device: Device) -> None:
    first, second = make_port(device.link), make_port(device.link)
    assert first.open_if_due(0)
    assert not second.open_if_due(0)
    assert second.fault == f"{device.link}: in use by another program"
    first.close()
    assert second.open_if_due(200 * MS)
    second.close()


def test_what_is_no_serial_device_is_said(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("text")
    for name, words in (("file", "ioctl"), (".", "is a directory"), ("file/x", "not a directory")):
        port = make_port(tmp_path / name)
        assert not port.open_if_due(0)
        assert words in port.fault


def test_what_is_written_comes_out_and_a_full_line_does_not_hold_us_up(device: Device) -> None:
    port = make_port(device.link)
    assert not port.write(b"early", 0)
    port.open_if_due(0)
    assert port.write(b"request", 0)
    assert os.read(device.master, 100) == b"request"
    written = [port.write(bytes(1000), 0) for _ in range(100)]  # nobody reads
    assert not written[-1]
    assert port.fault == ""
    port.close()
