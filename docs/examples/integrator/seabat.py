"""A simulated SeaBat: five pings a second of the records in docs/sonars/s7k.md, and one object in the water.

python seabat.py tcp:PORT START_S NORTH EAST DOWN        a 7k centre: network frames, sends what is subscribed to
python seabat.py serial:LINK START_S NORTH EAST DOWN     a pseudo-terminal, LINK points to it: the records as they are
"""

import math
import os
import select
import socket
import struct
import sys
import time
import tty
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import vehicle

BEAMS, SPREAD, SOUND_SPEED, SAMPLE_M = 32, math.radians(60.0), 1500.0, 0.2
SAMPLE_RATE = 0.5 * SOUND_SPEED / SAMPLE_M
LONGEST_M, SHORTEST_M = 80.0, 5.0
PERIOD_S = 0.2
RADIUS_M, STRENGTH = 0.8, 12.0
SETTINGS, GEOMETRY, WATER_COLUMN = 7000, 7004, 7042
REQUEST, ACKNOWLEDGED, REFUSED = 7500, 7501, 7502
SET_RANGE, SUBSCRIBE = 1003, 1051
OUT_OF_LIMITS = 2
RECORD_HEAD = struct.Struct("<HHIIII10sHIIHHIHHIII")
PACKET_HEAD = struct.Struct("<HHIHHIIIIHHI")
BEARINGS = (np.arange(BEAMS) - (BEAMS - 1) / 2.0) * SPREAD / BEAMS


def record(kind: int, utc_s: float, body: bytes) -> bytes:
    """Return a record frame."""
    moment = datetime.fromtimestamp(utc_s, UTC)
    seconds = moment.second + moment.microsecond * 1e-6
    stamp = struct.pack("<HHfBB", moment.year, moment.timetuple().tm_yday, seconds, moment.hour, moment.minute)
    size = RECORD_HEAD.size + len(body) + 4
    head = RECORD_HEAD.pack(5, 60, 0x0000FFFF, size, 0, 0, stamp, 1, kind, 7000, 0, 0, 0, 1, 0, 0, 0, 0)
    return head + body + struct.pack("<I", sum(head + body) % 2**32)


def packet(content: bytes, number: int) -> bytes:
    """Return a record in one network frame."""
    size = PACKET_HEAD.size + len(content)
    head = (5, PACKET_HEAD.size, 1, 1, number % 2**16, size, len(content), 0, 0, 0, 0, 0)
    return PACKET_HEAD.pack(*head) + content


class Sonar:
    """What it was asked for, and its pings."""

    def __init__(self, object_ned: tuple[float, float, float], start_s: float) -> None:
        self.range_m = LONGEST_M
        self.wanted = {SETTINGS, GEOMETRY, WATER_COLUMN}
        self._object_ned, self._start_s = object_ned, start_s
        self._noise = np.random.default_rng(1)

    def ping(self, number: int) -> list[bytes]:
        """Transmit, listen, return the records."""
        sent_utc_s, at = time.time(), vehicle.state(self._start_s).ned
        north, east, down = (there - here for there, here in zip(self._object_ned, at, strict=True))
        forward, starboard, below = vehicle.to_body((north, east, down))
        image = self._image(math.hypot(forward, starboard, below), math.atan2(starboard, forward))
        time.sleep(2.0 * self.range_m / SOUND_SPEED)
        contents = {
            SETTINGS: self._settings(number),
            GEOMETRY: self._geometry(),
            WATER_COLUMN: self._water_column(number, image),
        }
        return [record(kind, sent_utc_s, body) for kind, body in contents.items() if kind in self.wanted]

    def _image(self, range_m: float, bearing: float) -> np.ndarray:
        """Return amplitudes (beams, samples): speckle, and the near half of a sphere."""
        ranges = SAMPLE_M * np.arange(round(self.range_m / SAMPLE_M))
        beam_width = SPREAD / BEAMS
        across = np.exp(-(((BEARINGS - bearing) / beam_width) ** 2))
        along = np.exp(-(((ranges - range_m + 0.5 * RADIUS_M) / (0.5 * RADIUS_M)) ** 2))
        level = 1.0 + STRENGTH * across[:, None] * along[None, :]
        speckle: np.ndarray = self._noise.rayleigh(20.0, level.shape) * level
        return speckle

    def _settings(self, number: int) -> bytes:
        return struct.pack(
            "<QIHffffIIfHHfffffIIfffffIfIIIfIffffffffH",
            0, number, 0, 200e3, SAMPLE_RATE, 0.0, 0.0, 0, 0, 0.0, 1, 0, 0.0, 0.0, self.range_m, 210.0, 30.0, 0,
            0, 0.0, 0.0, 0.0, 0.0, 0.0, 0, 0.0, 0, 0, 0, 0.0, 0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, SOUND_SPEED, 0.0, 0,
        )  # fmt: skip

    def _geometry(self) -> bytes:
        rows = np.zeros((4, BEAMS), "<f4")
        rows[1], rows[3] = BEARINGS, SPREAD / BEAMS
        return struct.pack("<QI", 0, BEAMS) + rows.tobytes()

    def _water_column(self, number: int, image: np.ndarray) -> bytes:
        logarithmic = np.clip(np.floor(40.0 * np.log10(image) + 0.5), 0.0, 255.0).astype(np.uint8)
        samples = image.shape[1]
        flags = 0b110  # magnitudes only, 8 bit logarithmic
        head = struct.pack("<QIHHIIIIffI", 0, number, 0, BEAMS, samples, samples, flags, 0, SAMPLE_RATE, 0.0, 0)
        return head + b"".join(struct.pack("<HI", k, samples) + row.tobytes() for k, row in enumerate(logarithmic))

    def obey(self, body: bytes) -> bytes:
        """Take the body of a request; return the reply."""
        command, ticket, tracking = struct.unpack_from("<II16s", body)
        error = 0
        if command == SUBSCRIBE:
            (count,) = struct.unpack_from("<I", body, 24)
            self.wanted = set(struct.unpack_from(f"<{count}I", body, 28))
        elif command == SET_RANGE:
            (range_m,) = struct.unpack_from("<f", body, 24)
            error = 0 if SHORTEST_M <= range_m <= LONGEST_M else OUT_OF_LIMITS
            self.range_m = self.range_m if error else range_m
        reply = struct.pack("<I16s", ticket, tracking)
        if error:
            return record(REFUSED, time.time(), reply + struct.pack("<I", error))
        return record(ACKNOWLEDGED, time.time(), reply)


def requests(received: bytearray) -> Iterator[bytes]:
    """Take the whole requests out of the data received; what is between them, such as network frames, is dropped."""
    while (sync := received.find(b"\xff\xff\x00\x00")) >= 4 and len(received) >= sync - 4 + RECORD_HEAD.size:
        begin = sync - 4
        size, kind = struct.unpack_from("<I", received, begin + 8)[0], struct.unpack_from("<I", received, begin + 32)[0]
        if len(received) < begin + size:
            return
        if kind == REQUEST:
            yield bytes(received[begin + RECORD_HEAD.size : begin + size - 4])
        del received[: begin + size]


class SerialLine:
    """A pseudo-terminal whose far end is LINK."""

    def __init__(self, link: str) -> None:
        self._fd, there = os.openpty()
        tty.setraw(there)
        Path(link).unlink(missing_ok=True)
        Path(link).symlink_to(os.ttyname(there))

    def send(self, content: bytes) -> None:
        """Send a record."""
        while content:
            content = content[os.write(self._fd, content) :]

    def receive(self) -> bytes:
        """Return what has come."""
        return os.read(self._fd, 4096) if select.select([self._fd], [], [], 0.0)[0] else b""


class TcpLine:
    """A server with one client at a time."""

    def __init__(self, port: int) -> None:
        self._server = socket.create_server(("127.0.0.1", port))
        self._client = self._server.accept()[0]
        self._packets = 0

    def send(self, content: bytes) -> None:
        """Send a record; when the client has gone, wait for the next one."""
        try:
            self._client.sendall(packet(content, self._packets))
            self._packets += 1
        except OSError:
            self._client = self._server.accept()[0]

    def receive(self) -> bytes:
        """Return what has come."""
        return self._client.recv(4096) if select.select([self._client], [], [], 0.0)[0] else b""


def main(where: str, start_s: float, object_ned: tuple[float, float, float]) -> None:
    """Ping until killed."""
    kind, _, address = where.partition(":")
    line = TcpLine(int(address)) if kind == "tcp" else SerialLine(address)
    sonar, received = Sonar(object_ned, start_s), bytearray()
    for number in range(2**31):
        due_s = time.monotonic() + PERIOD_S
        received += line.receive()
        for body in requests(received):
            line.send(sonar.obey(body))
        for content in sonar.ping(number):
            line.send(content)
        time.sleep(max(0.0, due_s - time.monotonic()))


if __name__ == "__main__":
    north, east, down = map(float, sys.argv[3:6])
    main(sys.argv[1], float(sys.argv[2]), (north, east, down))
