"""Checks the sonar's port and, with --listen, the received data."""

import socket
import time
from collections import Counter
from collections.abc import Iterator

import msgspec

from ods.base import clock
from ods.base.plugins import PluginError
from ods.config import OnboardConfig
from ods.doctor.finding import Finding
from ods.doctor.lines import serial_device
from ods.runtime.counters import COUNTERS
from ods.runtime.port.address import TcpAddress, tcp_address, transport_of
from ods.runtime.run_dir import is_locked
from ods.sonar_link.link import BITS_A_BYTE, SonarLink
from ods.sonar_link.registry import make_protocol
from ods.sonar_link.settings import SonarSettings

PROBE_S = 2.0
IDLE_S = 0.002


def examine(port: str, *, in_use: bool = False) -> Iterator[Finding]:
    """Look at the sonar's port without disturbing a running sonar process: a device is not opened.

    `in_use`: that process runs, so a sonar on the network, which may have one connection only, is left alone.
    """
    address = tcp_address(port)
    if address and in_use:
        yield Finding("note", f"sonar {port}", "not tested: the sonar process uses its connection")
    elif address:
        yield from _tcp(port, address)
    elif transport_of(port) == "udp":
        yield Finding("note", f"sonar {port}", "datagrams: only `ods doctor --listen` can show whether any arrive")
    else:
        yield from serial_device.examine(f"serial port {port}", port, "sonar.port")


def listen(settings: OnboardConfig, seconds: float) -> Iterator[Finding]:
    """Listen to the sonar, asking it to send but for no setting, and say what came."""
    sonar = msgspec.structs.replace(settings.sonar, range_m=None, power_db=None, gain_db=None)
    subject = f"sonar on {sonar.port}"
    if is_locked(settings.bus.run_dir, "sonar"):
        yield Finding("note", subject, "no data received: the sonar process uses the line; `ods watch` shows its rates")
        return
    counters: Counter[str] = Counter()
    try:
        protocol = make_protocol(sonar, counters)
    except PluginError as error:
        yield Finding("wrong", subject, str(error))
        return
    link = SonarLink(sonar, protocol, counters)
    _hear(link, seconds)
    pings, traffic = counters["pings"], protocol.traffic(seconds)
    if pings:
        load = _load(link.octets / seconds, sonar)
        yield Finding("good", subject, f"{pings / seconds:.1f} pings/s; {traffic}; {load}")
    elif link.faults and not traffic:
        yield Finding("wrong", subject, "; ".join(link.faults + protocol.problems(clock.monotonic_ns())))
    else:
        yield Finding("wrong", subject, protocol.diagnosis(seconds))
    if traffic:
        yield from _trouble(subject, counters)
    link.close(clock.monotonic_ns())


def _load(rate: float, sonar: SonarSettings) -> str:
    """Return how much comes, bytes/s, and of a serial line, what part of its rate that is."""
    if transport_of(sonar.port) != "serial":
        return f"{rate / 1e6:.2f} MB/s"
    return f"{rate / 1e6:.2f} MB/s, {rate * BITS_A_BYTE / sonar.baud:.0%} of {sonar.baud} baud"


def _trouble(subject: str, counters: "Counter[str]") -> Iterator[Finding]:
    for name, count in sorted(counters.items()):
        row = COUNTERS["sonar"][name]
        if count and row.trouble:
            yield Finding("note", subject, f"{name} {count}" + (f": {row.advice}" if row.advice else ""))


def _hear(link: SonarLink, seconds: float) -> None:
    """Listen; what precedes the first whole ping is the rest of one under way, and not counted as trouble."""
    received_one = False
    stop_ns = clock.monotonic_ns() + round(seconds * clock.NS)
    while (now_ns := clock.monotonic_ns()) < stop_ns:
        pings = link.check(now_ns)
        came = link.read(now_ns)
        if (pings or came) and not received_one:
            received_one = True
            link.counters.clear()
            link.counters["pings"] = 1
        if came is None:
            time.sleep(IDLE_S)


def _tcp(port: str, address: TcpAddress) -> Iterator[Finding]:
    """Connect to the sonar for a moment; a serial server may take one connection only, the sonar process's."""
    subject = f"sonar {port}"
    if address.transport == "socket":
        yield Finding("note", subject, "is a serial server; it is tested when the sonar process starts")
        return
    try:
        socket.create_connection(address[:2], PROBE_S).close()
    except OSError as error:
        reason = error.strerror or f"no answer within {PROBE_S:g} s"
        yield Finding(
            "wrong", subject, f"{reason}: is the sonar on, is the cable connected, and is sonar.port correct?"
        )
    else:
        yield Finding("good", subject, "takes connections")
