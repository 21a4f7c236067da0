"""`ods doctor`: checks configuration, devices, sockets, clock and versions, and says in plain words what is wrong."""

import ctypes
import fcntl
import importlib.metadata
import os
import platform
import re
import socket
import sqlite3
import stat
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Literal, NamedTuple

import zmq
from rich.console import Console
from rich.text import Text

from ods import bus, clock
from ods.config import OnboardConfig
from ods.errors import OdsError
from ods.messages import Health
from ods.processes import on_board
from ods.settings_file import load
from ods.sonar_link.address import TcpAddress, tcp_address

LISTEN_S = 1.5
CONNECT_S = 2.0
YEAR_2024_NS = 1_704_067_200 * clock.NS
COLOURS = {"good": "green", "note": "yellow", "wrong": "bold red"}


class Finding(NamedTuple):
    """One line of the report."""

    level: Literal["good", "note", "wrong"]
    subject: str
    text: str


def examine(config: Path) -> int:
    """Print the report on this machine and `config`; return 0, or 1 when something is wrong."""
    found = list(findings(config))
    console = Console()
    for item in found:
        console.print(
            Text(f"{item.level:6}", COLOURS[item.level]), Text(f"{item.subject}: {item.text}"), soft_wrap=True
        )
    wrong = sum(item.level == "wrong" for item in found)
    console.print(f"{wrong} wrong" if wrong else "nothing is wrong")
    return 1 if wrong else 0


def findings(config: Path) -> Iterator[Finding]:
    """Yield what is found, good or not."""
    yield from versions()
    yield from wall_clock()
    yield from sqlite_rtree()
    try:
        settings = load(config, OnboardConfig)
    except OdsError as error:
        yield Finding("wrong", "configuration", str(error))
        return
    yield Finding("good", "configuration", f"{config} is complete and every value is in range")
    yield from pipeline(settings)
    yield from serial_port(settings.sonar.port)
    yield from can_interface(settings.nav.can.interface, settings.nav.can.channel)
    yield from sockets(settings.bus.run_dir)


def versions() -> Iterator[Finding]:
    """Compare installed packages with what the project requires."""
    found = [f"python {platform.python_version()}", f"libzmq {zmq.zmq_version()}"]
    for requirement in importlib.metadata.requires("ods") or []:
        match = re.match(r"([\w-]+)", requirement)
        if match is None or "extra ==" in requirement:
            continue
        try:
            found.append(f"{match[1]} {importlib.metadata.version(match[1])}")
        except importlib.metadata.PackageNotFoundError:
            yield Finding("wrong", "versions", f"{match[1]} is not installed; run `make` again")
    yield Finding("good", "versions", ", ".join(found))


def wall_clock() -> Iterator[Finding]:
    """Ask the kernel whether the wall clock is synchronized."""
    not_synchronized = 5
    timex = ctypes.create_string_buffer(512)
    state = ctypes.CDLL(None).adjtimex(timex)
    if clock.utc_ns() < YEAR_2024_NS:
        yield Finding("wrong", "clock", "the wall clock is years behind: stored objects would get wrong time stamps")
    elif state == not_synchronized:
        yield Finding("note", "clock", "the wall clock is not synchronized (NTP, PTP); only UTC stamps suffer")
    else:
        yield Finding("good", "clock", "the wall clock is synchronized")


def sqlite_rtree() -> Iterator[Finding]:
    """Yield whether Python's SQLite can keep the map of obstacles: that needs its R-tree."""
    with closing(sqlite3.connect(":memory:")) as database:
        try:
            database.execute("CREATE VIRTUAL TABLE place USING rtree(id, west, east)")
        except sqlite3.Error as error:
            yield Finding(
                "wrong", "SQLite", f"{sqlite3.sqlite_version} has no R-tree, the tracker cannot start: {error}"
            )
        else:
            yield Finding("good", "SQLite", f"{sqlite3.sqlite_version} with R-tree")


def pipeline(settings: OnboardConfig) -> Iterator[Finding]:
    """Build the pipeline's chain."""
    from ods.pipeline.chain import Chain

    try:
        Chain(settings.pipeline)
    except (OdsError, ValueError) as error:
        yield Finding("wrong", "pipeline", str(error))
    else:
        yield Finding("good", "pipeline", "all stages are known and their parameters fit")


def serial_port(port: str) -> Iterator[Finding]:
    """Look at the sonar's serial device without opening it: opening would disturb a running sonar process."""
    subject = f"serial port {port}"
    address = tcp_address(port)
    if address:
        yield from sonar_address(port, address)
        return
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


def sonar_address(port: str, address: TcpAddress) -> Iterator[Finding]:
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


def can_interface(interface: str, channel: str) -> Iterator[Finding]:
    """Look at the CAN interface."""
    subject = f"CAN {interface} {channel}"
    if interface != "socketcan":
        if Path(channel).exists() or not channel.startswith("/"):
            yield Finding("good", subject, "is there")
        else:
            yield Finding("wrong", subject, "no such device: is the adapter plugged in, and nav.can.channel right?")
        return
    flags_file = Path("/sys/class/net") / channel / "flags"
    try:
        up = int(flags_file.read_text(), 16) & 1
    except OSError:
        yield Finding("wrong", subject, "no such interface: `ip link` lists those that are there")
        return
    if up:
        yield Finding("good", subject, "is up")
    else:
        yield Finding("wrong", subject, f"is down: `ip link set {channel} up type can bitrate ...` as root")


def sockets(run_dir: Path) -> Iterator[Finding]:
    """Tell which processes run, and what they say of themselves."""
    if run_dir.exists() and not os.access(run_dir, os.R_OK | os.W_OK | os.X_OK):
        yield Finding("wrong", "sockets", f"{run_dir} may not be used by this user")
        return
    running = [process.name for process in on_board() if _locked(run_dir / f"{process.name}.lock")]
    if not running:
        yield Finding("note", "processes", f"none runs on {run_dir}")
        return
    health = _listen(run_dir, running)
    for process in on_board():
        report = health.get(process.name)
        if process.name not in running:
            yield Finding("wrong", process.name, "does not run, though others do")
        elif report is None:
            yield Finding("wrong", process.name, f"runs, but gave no sign of life within {LISTEN_S} s")
        elif report.problems:
            yield Finding("wrong", process.name, "; ".join(report.problems))
        else:
            yield Finding("good", process.name, "runs and is well" if report.ready else "is starting")


def _locked(lock_file: Path) -> bool:
    try:
        with lock_file.open("r+") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    return False


def _listen(run_dir: Path, names: list[str]) -> dict[str, Health]:
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    health: dict[str, Health] = {}
    deadline_ns = clock.monotonic_ns() + int(LISTEN_S * clock.NS)
    with bus.Subscriber(context, run_dir, [], names) as subscriber:
        while len(health) < len(names) and clock.monotonic_ns() < deadline_ns:
            for _, message in subscriber.receive(0.1)[0]:
                health[message.process] = message
    context.term()
    return health
