"""Versions, wall clock and SQLite of this machine."""

import importlib.metadata
import platform
import re
import sqlite3
from collections.abc import Iterator
from contextlib import closing

import zmq

from ods.base import clock
from ods.doctor.finding import Finding

YEAR_2024_NS = 1_704_067_200 * clock.NS


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
    if clock.utc_ns() < YEAR_2024_NS:
        yield Finding("wrong", "clock", "the wall clock is years behind: stamps are wrong unless the INS sends UTC")
    elif not clock.synchronized():
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
