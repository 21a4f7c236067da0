"""Messages of the Blueprint Oculus as the sonar itself writes and reads them, by packed record types.

Written from the drivers that docs/sonars/oculus.md names, not from `ods.sonar_link.oculus`, so that the bench shows a
mistake there.
"""

from typing import Any, NamedTuple

import numpy as np

from ods.base.arrays import AnyArray, Image

CHECK = 0x4F53
SIMPLE_FIRE, SIMPLE_PING, DUMMY = 0x15, 0x23, 0xFF
MAX_FIRE_BYTES = 4096
DEVICE_ID = 7892
PART_M750D = 1032
RUNNING = 3

_HEADER = np.dtype([
    ("check", "<u2"), ("source", "<u2"), ("destination", "<u2"), ("kind", "<u2"), ("version", "<u2"),
    ("payload", "<u4"), ("spare", "<u2"),
])  # fmt: skip
_FIRE_1 = np.dtype([
    ("head", _HEADER), ("mode", "u1"), ("ping_rate", "u1"), ("network_speed", "u1"), ("gamma", "u1"), ("flags", "u1"),
    ("range", "<f8"), ("gain", "<f8"), ("sound_speed", "<f8"), ("salinity", "<f8"),
])  # fmt: skip
_FIRE_2 = np.dtype([("first", _FIRE_1), ("extended", "<u4"), ("reserved", "<u4", 8)])
_RESULT_1 = np.dtype([
    ("fire", _FIRE_1), ("number", "<u4"), ("status", "<u4"), ("frequency", "<f8"), ("temperature", "<f8"),
    ("pressure", "<f8"), ("sound_speed", "<f8"), ("start", "<u4"), ("size", "u1"), ("resolution", "<f8"),
    ("ranges", "<u2"), ("beams", "<u2"), ("image_at", "<u4"), ("image_bytes", "<u4"), ("all_bytes", "<u4"),
])  # fmt: skip
_RESULT_2 = np.dtype([
    ("fire", _FIRE_2), ("number", "<u4"), ("status", "<u4"), ("frequency", "<f8"), ("temperature", "<f8"),
    ("pressure", "<f8"), ("heading", "<f8"), ("pitch", "<f8"), ("roll", "<f8"), ("sound_speed", "<f8"),
    ("start", "<f8"), ("size", "u1"), ("resolution", "<f8"), ("ranges", "<u2"), ("beams", "<u2"),
    ("spare", "<u4", 4), ("image_at", "<u4"), ("image_bytes", "<u4"), ("all_bytes", "<u4"),
])  # fmt: skip
_STATUS = np.dtype([
    ("head", _HEADER), ("device", "<u4"), ("type", "<u2"), ("part", "<u2"), ("status", "<u4"), ("versions", "<u4", 6),
    ("address", "u1", 4), ("mask", "u1", 4), ("client", "u1", 4), ("mac", "u1", 6), ("temperatures", "<f8", 8),
    ("pressure", "<f8"),
])  # fmt: skip

_SIXTEEN_BIT, _SENDS_GAIN, _BEAMS_512, _THIRTY_TWO_BIT = 0x02, 0x04, 0x40, 0x200


class FireMessage(NamedTuple):
    """A client's request."""

    version: int
    mode: int
    ping_rate: int
    gamma: int
    flags: int
    range_m: float
    gain_percent: float
    sound_speed: float
    salinity: float
    extended: int

    @property
    def sample_bytes(self) -> int:
        """1, 2 or 4."""
        if self.extended & _THIRTY_TWO_BIT:
            return 4
        return 2 if self.flags & _SIXTEEN_BIT else 1

    @property
    def wants_512(self) -> bool:
        """512 beams, else 256."""
        return bool(self.flags & _BEAMS_512)

    @property
    def wants_gains(self) -> bool:
        """A gain before each line."""
        return bool(self.flags & _SENDS_GAIN)


class ImageHead(NamedTuple):
    """What a result says of its image, beside the fire message."""

    number: int
    frequency_hz: float
    sound_speed: float
    uptime_s: float
    dr_m: float
    bearing_rad: AnyArray
    gain_percent: float


def take_fire(stream: bytearray) -> FireMessage | None:
    """Cut the first whole message off a stream of requests; None when there is none, or when it is no fire message."""
    while len(stream) >= _HEADER.itemsize:
        head = np.frombuffer(bytes(stream[: _HEADER.itemsize]), _HEADER)[0]
        size = _HEADER.itemsize + int(head["payload"])
        if head["check"] != CHECK or size > MAX_FIRE_BYTES:
            stream.clear()
        if len(stream) < size:
            return None
        message = bytes(stream[:size])
        del stream[:size]
        if head["kind"] == SIMPLE_FIRE and size >= _FIRE_1.itemsize:
            return _fire(message, int(head["version"]))
    return None


def _fire(message: bytes, version: int) -> FireMessage:
    first = np.frombuffer(message, _FIRE_1, 1)[0]
    second = version == 2 and len(message) >= _FIRE_2.itemsize
    extended = int(np.frombuffer(message, _FIRE_2, 1)[0]["extended"]) if second else 0
    return FireMessage(
        version=2 if second else 1,
        mode=int(first["mode"]),
        ping_rate=int(first["ping_rate"]),
        gamma=int(first["gamma"]),
        flags=int(first["flags"]),
        range_m=float(first["range"]),
        gain_percent=float(first["gain"]),
        sound_speed=float(first["sound_speed"]),
        salinity=float(first["salinity"]),
        extended=extended,
    )


def ping_result(fire: FireMessage, head: ImageHead, amplitude: Image, full_scale: float) -> bytes:
    """Return the result of an image, (beams, samples) amplitude; `full_scale`: that of the highest sample value."""
    samples = to_samples(amplitude, full_scale, fire.sample_bytes, fire.gamma)
    lines = np.ascontiguousarray(samples.T)
    rows = lines.view(np.uint8).reshape(len(lines), -1)
    if fire.wants_gains:
        rows = np.hstack([np.full((len(lines), 1), 1, "<u4").view(np.uint8), rows])
    record = np.zeros(1, _RESULT_2 if fire.version == 2 else _RESULT_1)[0]
    bearings = np.rint(100.0 * np.degrees(head.bearing_rad)).astype("<i2").tobytes()
    image_at = record.nbytes + len(bearings)
    _fill(record, fire, head)
    record["size"] = {1: 0, 2: 1, 4: 3}[fire.sample_bytes]
    record["ranges"], record["beams"] = lines.shape
    record["image_at"], record["image_bytes"], record["all_bytes"] = image_at, rows.size, image_at + rows.size
    _set_head(record["fire"]["first"] if fire.version == 2 else record["fire"], fire, head, image_at + rows.size)
    return bytes(record.tobytes()) + bearings + rows.tobytes()


def _fill(record: Any, fire: FireMessage, head: ImageHead) -> None:
    record["number"], record["frequency"], record["temperature"] = head.number % 2**32, head.frequency_hz, 12.5
    record["pressure"], record["sound_speed"], record["resolution"] = 1.2, head.sound_speed, head.dr_m
    # the unit of the first version is not known: in a recording it counts some 62.5 million from ping to ping
    record["start"] = head.uptime_s if fire.version == 2 else round(head.uptime_s * 1e9) % 2**32
    if fire.version == 2:
        record["fire"]["extended"] = fire.extended


def _set_head(first: Any, fire: FireMessage, head: ImageHead, size: int) -> None:
    message = first["head"]
    message["check"], message["source"], message["kind"] = CHECK, DEVICE_ID, SIMPLE_PING
    message["version"], message["payload"] = fire.version, size - _HEADER.itemsize
    first["mode"], first["gamma"], first["flags"] = fire.mode, fire.gamma, fire.flags
    first["ping_rate"] = 195  # sonars do not repeat it
    first["range"], first["gain"] = fire.range_m, head.gain_percent
    first["sound_speed"], first["salinity"] = head.sound_speed, fire.salinity


def to_samples(amplitude: Image, full_scale: float, sample_bytes: int, gamma: int) -> AnyArray:
    """Return unsigned samples of this number of bytes: the share of the full scale to the power gamma / 255,
    rounded."""
    share = np.minimum(amplitude * np.float32(1.0 / full_scale), np.float32(1.0))
    if gamma not in (0, 255):
        share **= np.float32(gamma / 255)
    highest = 2 ** (8 * sample_bytes) - 1
    exact = share.astype(np.float64) if sample_bytes == 4 else share
    return np.asarray(np.rint(exact * exact.dtype.type(highest)).astype(f"<u{sample_bytes}"))


def dummy() -> bytes:
    """Return what a sonar in standby sends."""
    head = np.zeros(1, _HEADER)
    head["check"], head["source"], head["kind"] = CHECK, DEVICE_ID, DUMMY
    return head.tobytes()


def status(address: str, client: str) -> bytes:
    """Return the broadcast of a sonar that works."""
    record = np.zeros(1, _STATUS)
    head = record["head"]
    head["check"], head["source"], head["payload"] = CHECK, DEVICE_ID, _STATUS.itemsize - _HEADER.itemsize
    record["device"], record["type"], record["part"], record["status"] = DEVICE_ID, 1, PART_M750D, RUNNING
    record["address"], record["mask"] = [int(part) for part in address.split(".")], [255, 0, 0, 0]
    record["client"] = [int(part) for part in client.split(".")]
    record["temperatures"], record["pressure"] = 21.5, 1.2
    return record.tobytes()
