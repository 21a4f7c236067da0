"""The sonar's line: is it there, and, when asked to listen, what comes over it?"""

import os
import socket
import stat
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from ods import clock
from ods.config import OnboardConfig
from ods.doctor import running
from ods.doctor.finding import Finding
from ods.sonar_link import remote_control, s7k
from ods.sonar_link.address import TcpAddress, tcp_address
from ods.sonar_link.assembler import Assembler
from ods.sonar_link.link import SonarLink
from ods.sonar_link.settings import SonarSettings

CONNECT_S = 2.0
PAUSE_S = 0.002
QUIET = {"records", "unchecked_records", "pings", "port_opens", "other_records", "no_device_time"}
"""Counters that tell of no trouble."""
BY_NUMBER = ("/dev/ttyUSB", "/dev/ttyACM")


def examine(port: str) -> Iterator[Finding]:
    """Look at the sonar's port without disturbing a running sonar process: a device is not opened."""
    address = tcp_address(port)
    if address:
        yield from _tcp(port, address)
    else:
        yield from _serial(port)


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
    if link.fault and not heard:
        yield Finding("wrong", subject, link.fault)
    elif not heard:
        garbage = counters["garbage_bytes"]
        told = f"{garbage} bytes of no record came: baud, wiring, or another protocol" if garbage else "it is silent"
        yield Finding("wrong", subject, f"no s7k record within {seconds:g} s; {told}")
    else:
        yield from _judge(subject, heard, counters, seconds)
    link.close()


def _judge(subject: str, heard: "Counter[int]", counters: "Counter[str]", seconds: float) -> Iterator[Finding]:
    records = ", ".join(f"{kind} at {count / seconds:.1f} Hz" for kind, count in sorted(heard.items()))
    trouble = ", ".join(f"{name} {count}" for name, count in sorted(counters.items()) if count and name not in QUIET)
    if counters["pings"]:
        told = f"{counters['pings'] / seconds:.1f} pings/s; records {records}"
        yield Finding("good", subject, told + (f"; {trouble}" if trouble else ""))
    else:
        yield Finding("wrong", subject, f"no ping can be made of records {records}; {trouble}")


def _subscription(sonar: SonarSettings) -> bytes:
    """Return the record that asks a 7k center to send; empty for a line that sends by itself."""
    address = tcp_address(sonar.port)
    if address is None or not address.framed:
        return b""
    request = remote_control.subscribe(1, (s7k.SONAR_SETTINGS, s7k.BEAM_GEOMETRY, sonar.samples_record))
    return remote_control.encode_request(request, clock.utc_ns(), s7k.DEVICE)


def _hear(link: SonarLink, assembler: Assembler, subscription: bytes, seconds: float) -> "Counter[int]":
    """Return how often each type of record came."""
    heard: Counter[int] = Counter()
    stop_ns = clock.monotonic_ns() + round(seconds * clock.NS)
    while (now_ns := clock.monotonic_ns()) < stop_ns:
        if link.open_if_due(now_ns) and subscription:
            link.send(subscription, now_ns)
        records = link.check(now_ns) + (link.read(now_ns) or [])
        for record in records:
            heard[record.record_type] += 1
            assembler.feed(record)
        if not records:
            time.sleep(PAUSE_S)
    return heard


def _serial(port: str) -> Iterator[Finding]:
    subject = f"serial port {port}"
    try:
        status = Path(port).stat()
    except OSError as error:
        yield Finding("wrong", subject, f"{error.strerror}: is the adapter plugged in, and sonar.port right?")
        return
    if not stat.S_ISCHR(status.st_mode):
        yield Finding("wrong", subject, "is no serial device")
    elif not os.access(port, os.R_OK | os.W_OK):
        yield Finding("wrong", subject, "may not be read and written by this user: join the group `dialout`")
    else:
        yield Finding("good", subject, f"is there ({os.path.realpath(port)})")
        if port.startswith(BY_NUMBER):
            yield Finding("note", subject, "may get another number when replugged: use its name in /dev/serial/by-id")


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
