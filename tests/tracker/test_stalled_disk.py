"""A disk that stalls or is full costs the map's freshness alone: system calls on the map's file wait or fail."""

import math
import os
import shutil
import signal
import subprocess
import time
from itertools import pairwise
from pathlib import Path

import pytest

from ods.base import clock
from ods.messages import ObstacleList
from ods.tracker.map.store import copy_of_map
from tests.tracker.played import Chain, good, played

pytestmark = pytest.mark.slow

STALL_S = float(os.environ.get("ODS_TEST_STALL_S", "5"))

SHIM = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Calls on files whose name has "map.sqlite" wait while the file $DISK.stalled is there; writes fail, $DISK.full. */
static int reported(const char *what) {
    char path[4096];
    snprintf(path, sizeof path, "%s.%s", getenv("DISK"), what);
    return access(path, F_OK) == 0;
}
static int of_map(int fd) {
    char link[64], path[4096] = "";
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    return readlink(link, path, sizeof path - 1) > 0 && strstr(path, "map.sqlite") != NULL;
}
static void wait_for_disk(void) { while (reported("stalled")) usleep(10000); }

ssize_t pread64(int fd, void *data, size_t size, off_t at) {
    static ssize_t (*real)(int, void *, size_t, off_t);
    if (!real) real = dlsym(RTLD_NEXT, "pread64");
    if (of_map(fd)) wait_for_disk();
    return real(fd, data, size, at);
}
ssize_t pwrite64(int fd, const void *data, size_t size, off_t at) {
    static ssize_t (*real)(int, const void *, size_t, off_t);
    if (!real) real = dlsym(RTLD_NEXT, "pwrite64");
    if (of_map(fd)) {
        wait_for_disk();
        if (reported("full")) { errno = ENOSPC; return -1; }
    }
    return real(fd, data, size, at);
}
int fdatasync(int fd) {
    static int (*real)(int);
    if (!real) real = dlsym(RTLD_NEXT, "fdatasync");
    if (of_map(fd)) wait_for_disk();
    return real(fd);
}
"""


class Disk:
    """What the map's file is on."""

    def __init__(self, folder: Path) -> None:
        (folder / "shim.c").write_text(SHIM)
        shim = folder / "shim.so"
        subprocess.run(
            ["cc", "-shared", "-fPIC", "-w", "-include", "stdlib.h", "-o", shim, folder / "shim.c", "-ldl"], check=True
        )
        self.environment = {"LD_PRELOAD": str(shim), "DISK": str(folder / "disk")}
        self._stalled, self._full = folder / "disk.stalled", folder / "disk.full"

    def stalls(self, does: bool) -> None:
        self._stalled.touch() if does else self._stalled.unlink()

    def is_full(self, so: bool) -> None:
        self._full.touch() if so else self._full.unlink()


@pytest.fixture
def disk(tmp_path: Path) -> Disk:
    if shutil.which("cc") is None:
        pytest.skip("needs a C compiler")
    return Disk(tmp_path)


def _problems(chain: Chain) -> str:
    return "" if chain.health is None else "; ".join(chain.health.problems)


def _turn_away(chain: Chain) -> None:
    """The two objects fall out of view and are hibernated."""
    _turn(chain, 0.0, math.pi)


def _turn_back(chain: Chain) -> None:
    _turn(chain, math.pi, 0.0)


def _turn(chain: Chain, begin: float, end: float) -> None:
    """Turn within two seconds: at once would be a jump of the pose."""
    begun_s = clock.monotonic_ns() / clock.NS

    def heading(t_s: float) -> float:
        return begin + (end - begin) * min(max(0.5 * (t_s - begun_s), 0.0), 1.0)

    chain.heading = heading
    chain.until(lambda _: clock.monotonic_ns() / clock.NS > begun_s + 2.0)


def _longest_gap_s(lists: list[ObstacleList]) -> float:
    return max(later.t_ns - earlier.t_ns for earlier, later in pairwise(lists)) / clock.NS


def _in_map(folder: Path) -> set[int]:
    store = copy_of_map(folder / "map.sqlite")
    ids = {o.id for o in store.load()}
    store.close()
    return ids


def hibernated(message: ObstacleList) -> bool:
    return [o.state for o in message.obstacles] == ["hibernated"] * 2


def test_a_disk_that_stalls_or_is_full_costs_the_maps_freshness_only(disk: Disk) -> None:
    """`ODS_TEST_STALL_S=40` for a stall far beyond the watchdog's 3 s."""
    with played({"life": {"stand_by_s": 0.5}}, disk.environment) as chain:
        ids = {o.id for o in chain.until(good).obstacles}
        disk.stalls(True)
        begun, first = time.monotonic(), len(chain.lists)
        _turn_away(chain)
        chain.until(lambda _: time.monotonic() > begun + STALL_S and "does not answer; not written" in _problems(chain))
        gap_s = _longest_gap_s(chain.lists[first:])
        print(f"{len(chain.lists) - first} lists in {STALL_S} s, the longest gap {gap_s:.2f} s; {_problems(chain)}")
        assert gap_s < 0.5 * STALL_S
        assert hibernated(chain.lists[-1])
        disk.stalls(False)
        chain.until(lambda _: not _problems(chain))
        assert _in_map(chain.folder) == ids

        _turn_back(chain)
        assert {o.id for o in chain.until(good).obstacles} == ids
        disk.is_full(True)
        chain.echoes.append((50.0, -0.4))
        chain.until(lambda m: len(m.obstacles) == 3 and min(o.times_seen for o in m.obstacles) > 10)
        _turn_away(chain)
        chain.until(lambda _: "disk is full; not written" in _problems(chain))
        assert len(chain.until(lambda _: True).obstacles) == 3
        assert _in_map(chain.folder) == ids
        disk.is_full(False)
        chain.until(lambda _: not _problems(chain))
        assert len(_in_map(chain.folder)) == 3


def test_a_disk_that_stalls_at_the_start(disk: Disk) -> None:
    """The tracker goes on without the map, and so does the next one while the first one's writer still waits."""
    with played({"life": {"stand_by_s": 0.5}, "resume_within_s": 300.0}, disk.environment) as chain:
        ids = {o.id for o in chain.until(good).obstacles}
        chain.process.send_signal(signal.SIGTERM)
        assert chain.process.wait(10) == 0
        disk.stalls(True)
        chain.start()
        given = {o.id for o in chain.until(good).obstacles}
        assert not given & ids
        chain.kill()
        chain.start()
        again = chain.until(lambda m: good(m) and "not read for" in _problems(chain))
        assert {o.id for o in again.obstacles} == given
        disk.stalls(False)
        everything = chain.until(lambda m: len(m.obstacles) == 4)
        known = {o.id for o in everything.obstacles}
        assert len(known) == 4
        assert ids < known
        chain.until(lambda _: not _problems(chain))
