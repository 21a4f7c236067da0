"""The sonar's line: is it there, and, when asked to listen, what comes over it?"""

import socket
import time
from collections import Counter
from collections.abc import Iterator
from typing import NamedTuple

from ods.base import clock
from ods.config import OnboardConfig
from ods.doctor import running, serial_device
from ods.doctor.finding import Finding
from ods.sonar_link.link import BITS_A_BYTE, SonarLink
from ods.sonar_link.port.address import TcpAddress, tcp_address
from ods.sonar_link.s7k import records, remote_control
from ods.sonar_link.s7k.assembler import Assembler
from ods.sonar_link.s7k.drf import CHECKSUM_BYTES, HEADER_BYTES
from ods.sonar_link.settings import SonarSettings

CONNECT_S = 2.0
PAUSE_S = 0.002
QUIET = {
    "records", "unchecked_records", "pings", "port_opens", "other_records", "no_device_time", "network_frames",
}  # fmt: skip
"""Counters that tell of no trouble."""
SAMPLES = (7042, 7018)
ADVICE = {
    "bad_checksum": "bytes change on the way: termination, ground, cable",
    "data_without_geometry": "switch record 7004 on at the sonar, for every ping",
    "data_without_settings": "switch record 7000 on at the sonar, for every ping",
    "garbage_bytes": "bytes that are in no record: noise, or records cut short by a baud that is too low",
    "lost_pings": "pings that the sonar numbered and that did not come whole: noise, a full line, or a busy processor",
    "unframed_bytes": "bytes outside network frames: is this the port of a 7k center?",
}


class Heard(NamedTuple):
    """What came while listening."""

    records: "Counter[int]"
    """How often each type of record came."""
    octets: int
    """Their length as sent."""


def examine(port: str) -> Iterator[Finding]:
    """Look at the sonar's port without disturbing a running sonar process: a device is not opened."""
    address = tcp_address(port)
    if address:
        yield from _tcp(port, address)
    else:
        yield from serial_device.examine(f"serial port {port}", port, "sonar.port")


def listen(settings: OnboardConfig, seconds: float) -> Iterator[Finding]:
    """Listen to the sonar, asking a 7k center to send but nothing else, and say what came."""
    sonar = settings.sonar
    subject = f"sonar on {sonar.port}"
    if running.is_running(settings.bus.run_dir, "sonar"):
        yield Finding("note", subject, "not listened to: the sonar process has the line; `ods watch` shows its rates")
        return
    counters: Counter[str] = Counter()
    link, assembler = SonarLink(sonar, counters), Assembler(counters=counters)
    heard = _hear(link, assembler, _subscription(sonar), seconds)
    if link.fault and not heard.records:
        yield Finding("wrong", subject, link.fault)
    elif not heard.records:
        garbage = counters["garbage_bytes"]
        told = f"{garbage} bytes of no record came: baud, wiring, or another protocol" if garbage else "it is silent"
        yield Finding("wrong", subject, f"no s7k record within {seconds:g} s; {told}")
    else:
        yield _judge(subject, heard, counters["pings"], sonar, seconds)
        yield from _trouble(subject, counters)
    link.close()


def _judge(subject: str, heard: Heard, pings: int, sonar: SonarSettings, seconds: float) -> Finding:
    records = ", ".join(f"{kind} at {count / seconds:.1f} Hz" for kind, count in sorted(heard.records.items()))
    if pings:
        return Finding(
            "good", subject, f"{pings / seconds:.1f} pings/s; records {records}; {_load(heard, sonar, seconds)}"
        )
    missing = [str(kind) for kind in (7000, 7004) if not heard.records[kind]]
    if not any(heard.records[kind] for kind in SAMPLES):
        missing.append("7042 or 7018")
    why = f"{' and '.join(missing)} never came whole" if missing else "they do not fit each other"
    told = (
        f"no ping can be made of records {records}: {why}; switch 7000, 7004 and 7042 on at the sonar, for every ping"
    )
    return Finding("wrong", subject, told)


def _load(heard: Heard, sonar: SonarSettings, seconds: float) -> str:
    """Say how much came and, of a serial line, what part of its rate that is."""
    rate = heard.octets / seconds
    if tcp_address(sonar.port):
        return f"{rate / 1e6:.2f} MB/s"
    return f"{rate / 1e6:.2f} MB/s, {rate * BITS_A_BYTE / sonar.baud:.0%} of {sonar.baud} baud"


def _trouble(subject: str, counters: "Counter[str]") -> Iterator[Finding]:
    for name, count in sorted(counters.items()):
        if count and name not in QUIET:
            yield Finding("note", subject, f"{name} {count}" + (f": {ADVICE[name]}" if name in ADVICE else ""))


def _subscription(sonar: SonarSettings) -> bytes:
    """Return the record that asks a 7k center to send; empty for a line that sends by itself."""
    address = tcp_address(sonar.port)
    if address is None or not address.framed:
        return b""
    request = remote_control.subscribe(1, (records.SONAR_SETTINGS, records.BEAM_GEOMETRY, sonar.samples_record))
    return remote_control.encode_request(request, clock.utc_ns(), records.DEVICE)


def _hear(link: SonarLink, assembler: Assembler, subscription: bytes, seconds: float) -> Heard:
    """Listen; what precedes the first whole ping is the rest of one under way, and not counted as trouble."""
    heard: Counter[int] = Counter()
    octets = 0
    stop_ns = clock.monotonic_ns() + round(seconds * clock.NS)
    while (now_ns := clock.monotonic_ns()) < stop_ns:
        if link.open_if_due(now_ns) and subscription:
            link.send(subscription, now_ns)
        records = link.check(now_ns) + (link.read(now_ns) or [])
        for record in records:
            heard[record.record_type] += 1
            octets += HEADER_BYTES + len(record.body) + CHECKSUM_BYTES
            if assembler.feed(record) and link.counters["pings"] == 1:
                link.counters.clear()
                link.counters["pings"] = 1
        if not records:
            time.sleep(PAUSE_S)
    return Heard(heard, octets)


def _tcp(port: str, address: TcpAddress) -> Iterator[Finding]:
    """Connect to a 7k center for a moment; a serial server may take one connection only, the sonar process's."""
    subject = f"sonar {port}"
    if not address.framed:
        yield Finding("note", subject, "is a serial server; it is tried when the sonar process starts")
        return
    try:
        socket.create_connection(address[:2], CONNECT_S).close()
    except OSError as error:
        reason = error.strerror or f"no answer within {CONNECT_S:g} s"
        yield Finding("wrong", subject, f"{reason}: is the sonar on, the cable in, and sonar.port right?")
    else:
        yield Finding("good", subject, "takes connections")
