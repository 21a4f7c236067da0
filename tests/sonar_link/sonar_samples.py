"""Pings and devices for the tests of the sonar link."""

import contextlib
import os
import select
import tty
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from ods.base.arrays import SAMPLE_DTYPES
from ods.messages import Ping, SampleType, Scale
from ods.sonar_link.s7k.assembler import Assembler
from ods.sonar_link.s7k.framer import RecordFramer
from ods.sonar_link.s7k.records import decode

UTC_NS = 1_700_000_000_250_000_000
"""A time whose seconds float32 holds exactly."""


def make_ping(
    number: int = 0,
    *,
    beams: int = 6,
    samples: int = 40,
    dtype: SampleType = "u1",
    scale: Scale = "log8",
    scale_factor: float = 40.0,
    range0_m: float = 0.5,
    dr_m: float = 0.25,
    sound_speed: float = 1500.0,
    planes: int = 1,
    utc_ns: int = UTC_NS,
) -> Ping:
    """Return a ping of random samples whose geometry float32 holds exactly."""
    rng = np.random.default_rng(number)
    frame = (rng.random((beams, samples)) * 190).astype(SAMPLE_DTYPES[dtype])
    bearing = (np.arange(beams // planes) - beams // 2 / planes) / 32
    elevation = np.repeat((np.arange(planes) - planes // 2) / 8, beams // planes)
    return Ping(
        seq=number,
        ping_number=number,
        t_ns=utc_ns,
        t_rx_ns=0,
        utc_ns=utc_ns,
        beams=beams,
        samples=samples,
        dtype=dtype,
        data=frame.tobytes(),
        bearing_rad=np.tile(bearing, planes).tolist(),
        range0_m=range0_m,
        dr_m=dr_m,
        sound_speed=sound_speed,
        elevation_rad=elevation.tolist() if planes > 1 else [],
        beam_width_rad=[1 / 32] * beams,
        planes=planes,
        frequency_hz=455e3,
        scale=scale,
        scale_factor=scale_factor,
    )


def link(chunks: Iterable[bytes]) -> tuple[list[Ping], Counter[str]]:
    """Send bytes through framer and assembler; return the pings and all counters."""
    counters: Counter[str] = Counter()
    framer, assembler = RecordFramer(counters=counters), Assembler(counters=counters)
    records = [record for chunk in chunks for record in framer.feed(chunk)] + framer.flush()
    fed = [assembler.feed(record, decode(record)) for record in records]
    return [ping for ping in fed if ping is not None], counters


class Device:
    """A pseudo-terminal behind a symlink, as udev makes them."""

    def __init__(self, link: Path) -> None:
        self.link = link
        self.master, self._slave = os.openpty()
        tty.setraw(self._slave)
        link.unlink(missing_ok=True)
        link.symlink_to(os.ttyname(self._slave))

    def send(self, data: bytes) -> None:
        """Write all of it, however long the reader takes."""
        os.set_blocking(self.master, True)
        while data:
            data = data[os.write(self.master, data) :]

    def offer(self, data: bytes, patience_s: float = 0.02) -> None:
        """Write as a UART does: what finds no room in time is lost."""
        os.set_blocking(self.master, False)
        while data and select.select([], [self.master], [], patience_s)[1]:
            with contextlib.suppress(BlockingIOError):
                data = data[os.write(self.master, data) :]

    def unplug(self) -> None:
        self.link.unlink(missing_ok=True)
        self.hang_up()

    def hang_up(self) -> None:
        """Vanish, and leave the name behind."""
        for fd in (self.master, self._slave):
            with contextlib.suppress(OSError):
                os.close(fd)
