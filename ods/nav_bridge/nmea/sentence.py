"""Sentences to pose fields: NMEA 0183 by pynmea2, and the lines of a Doppler log's PD6.

Sources: NMEA 0183 as pynmea2 has its fields, its TAG blocks (version 4) and the datagrams of IEC 61162-450 around them;
PASHR as Trimble and NovAtel describe it; PSXN as Kongsberg Seatex describe it for the Seapath; PD6 as Teledyne RD
Instruments describe it in the Pathfinder's guide (1-sigma in degrees; velocities in mm/s).
"""

import math
import re
from collections.abc import Callable, Sequence
from datetime import UTC, datetime, timedelta
from typing import NamedTuple

import pynmea2

KNOT = 1852.0 / 3600.0
MM = 1e-3
NUMBER = re.compile(r"[+-]?(\d{1,12}(\.\d{0,12})?|\.\d{1,12})")
TIME = re.compile(r"(\d\d)(\d\d)(\d\d(?:\.\d{1,9})?)")
PD6 = re.compile(r":([A-Z]{2}),([ -~]*)")
DEGREES = re.compile(r"(\d{0,3})(\d\d)(\.\d{0,12})?")
"""Degrees with or without leading zeros, then minutes, which have two digits before the point."""
PASHR, PSXN = "PASHR", "PSXN"
PROPRIETARY = re.compile(rb"\$(P[A-Z]{3}[A-Z0-9]*)")
"""A maker's sentence has no talker: P, three letters of the maker, and what the maker adds [NMEA 0183]."""
SEAPATH_ATTITUDE, SEAPATH_QUALITY = "23", "20"
"""Of the kinds of PSXN, that with roll, pitch and heading, and that with their qualities;"""
INVALID = "2"
"""the quality of invalid data (0: normal, 1: reduced)."""
DATAGRAM = b"UdPbC\0"
"""Before the sentences of a datagram [IEC 61162-450]."""
TAG = b"\\"
"""Before and behind a TAG block."""
REST_MPS = 0.5
"""Below this speed, m/s, a receiver may omit its course, which is then unknown."""
QUALITIES = {"6": "estimated", "7": "manual", "8": "simulated"}
"""Of a GGA, but for those that are fixes;"""
MODES = {"E": "estimated", "M": "manual", "S": "simulated"}
"""the same of RMC and VTG."""
UNSAFE = "unsafe"
"""What a navigational status U says (NMEA 4.1)."""


class BadSentenceError(Exception):
    """A line that is damaged or says what no sentence can."""


class NoChecksumError(BadSentenceError):
    """A sentence that may be good, without the checksum that would show it."""


class NotValidError(Exception):
    """A sentence flagged as not valid, with the reason if it gives one."""


class SentenceFields(NamedTuple):
    """Contents of a sentence."""

    values: dict[str, float]
    """Pose fields."""
    day_ms: float | None = None
    """UTC, ms since midnight; None where it has none, or an invalid one."""
    kind: str = ""
    """Kind of a position or velocity that was not measured: of `QUALITIES`, or `UNSAFE`."""
    age_s: float = 0.0
    """Age of the values when it was sent, s."""
    corrections_s: float = 0.0
    """Age of a fix's corrections, s: it makes the position worse, but not older."""
    invalid: frozenset[str] | None = None
    """Pose fields that are invalid in the sentences that follow, of a sentence of qualities; None for other
    sentences."""


class Sentence(NamedTuple):
    """A line that was found undamaged."""

    talker: str
    """"" where there is none."""
    name: str
    """GGA, PASHR, BS."""
    parts: Sequence[str]


def strip_framing(line: bytes) -> bytes:
    """Return the sentence of a line: without a datagram's head and TAG blocks, which show nothing that is used here."""
    line = line.removeprefix(DATAGRAM)
    while line.startswith(TAG):
        _, _, line = line[1:].partition(TAG)
    return line


def name_of(line: bytes) -> tuple[str, str]:
    """Return talker and name of a bare line that may be anything, "", "" when it is nothing known; cheap."""
    text = line[:6].decode("ascii", "replace")
    if text[:1] == ":":
        return "", text[1:3] if text[3:4] == "," else ""
    if text[:1] != "$":
        return "", ""
    own = PROPRIETARY.match(line) if text[1:2] == "P" else None
    return ("", own[1].decode()) if own else (text[1:3], text[3:6])


def parse(line: bytes) -> Sentence:
    """Return the parts of a bare line. Raises BadSentenceError: NoChecksumError where that is missing; PD6 has none."""
    try:
        text = line.decode("ascii").strip()
    except UnicodeDecodeError as error:
        raise BadSentenceError from error
    talker, name = name_of(line)
    if line[:1] == b":":
        match = PD6.fullmatch(text)
        if match is None:
            raise BadSentenceError
        return Sentence(talker, name, [part.strip() for part in match[2].split(",")])
    if "*" not in text:
        raise NoChecksumError
    try:
        sentence = pynmea2.parse(text, check=True)
    except Exception as error:  # ValueErrors of its own, and whatever else a malformed sentence runs into
        raise BadSentenceError from error
    # a maker's class in pynmea2 may keep parts for itself, as Nortek's does
    return Sentence(talker, name, sentence.data if talker else text.partition("*")[0].split(",")[1:])


def read(sentence: Sentence) -> SentenceFields:
    """Return the contents of a sentence of READERS. Raises BadSentenceError and NotValidError."""
    try:
        return READERS[sentence.name](sentence.parts)
    except (IndexError, ValueError) as error:  # it has fewer or more parts than it must
        raise BadSentenceError from error


def utc_of(sentence: Sentence) -> int:
    """Return ns since 1970 of a ZDA. Raises BadSentenceError and NotValidError."""
    try:
        milliseconds = _day_ms(sentence.parts[0])
        day, month, year = (int(_number(part)) for part in sentence.parts[1:4])
        midnight = datetime(year, month, day, tzinfo=UTC)
    except (ValueError, IndexError) as error:
        raise BadSentenceError from error
    if milliseconds is None:
        raise NotValidError
    seconds = (midnight - datetime(1970, 1, 1, tzinfo=UTC)) // timedelta(seconds=1)
    return seconds * 1_000_000_000 + round(milliseconds * 1e6)


def _gga(parts: Sequence[str]) -> SentenceFields:
    if parts[5] in ("", "0"):
        raise NotValidError("no fix")
    _expect(parts[9:10], "M")
    values = _place(parts[1:5]) | {"altitude": _number(parts[8])}
    corrections_s = abs(_number(parts[12])) if parts[12:] and parts[12] else 0.0
    return SentenceFields(values, _day_ms(parts[0]), QUALITIES.get(parts[5], ""), corrections_s=corrections_s)


def _rmc(parts: Sequence[str]) -> SentenceFields:
    mode, status = (*parts[11:13], "", "")[:2]
    if parts[1] != "A" or mode == "N":
        raise NotValidError("no fix")
    values = _place(parts[2:6])
    if parts[7] or _speed(parts[6]) <= REST_MPS:
        values |= _over_ground(parts[6], parts[7])
    return SentenceFields(values, _day_ms(parts[0]), UNSAFE if status == "U" else MODES.get(mode, ""))


def _vtg(parts: Sequence[str]) -> SentenceFields:
    mode = "".join(parts[8:9])
    if mode == "N" or not parts[4]:
        raise NotValidError("no fix")
    _expect(parts[1:2], "T")
    return SentenceFields(_over_ground(parts[4], parts[0]), kind=MODES.get(mode, ""))


def _hdt(parts: Sequence[str]) -> SentenceFields:
    _expect(parts[1:2], "T")
    return SentenceFields({"yaw": _angle(parts[0])})


def _pashr(parts: Sequence[str]) -> SentenceFields:
    time, heading, true, roll, pitch, _, *accuracies = parts
    _expect([true], "T")
    values = {"roll": _angle(roll), "pitch": _angle(pitch)}
    if heading:
        values["yaw"] = _angle(heading)
    names = "sigma_roll", "sigma_pitch", "sigma_yaw"
    values |= {name: _angle(text) for name, text in zip(names, accuracies, strict=False) if text}
    return SentenceFields(values, _day_ms(time))


def _psxn(parts: Sequence[str]) -> SentenceFields:
    kind, *angles = parts
    if kind == SEAPATH_QUALITY:
        _, _, heading, roll_and_pitch = angles[:4]
        invalid = {"yaw"} if heading == INVALID else set()
        return SentenceFields(
            {}, invalid=frozenset(invalid | ({"roll", "pitch"} if roll_and_pitch == INVALID else set()))
        )
    if kind != SEAPATH_ATTITUDE:
        return SentenceFields({})
    names = "roll", "pitch", "yaw"
    return SentenceFields({name: _angle(text) for name, text in zip(names, angles[:3], strict=True)})


def _gst(parts: Sequence[str]) -> SentenceFields:
    names = "sigma_north", "sigma_east", "sigma_down"
    return SentenceFields(
        {name: _number(part) for name, part in zip(names, parts[5:8], strict=True)}, _day_ms(parts[0])
    )


def _dpt(parts: Sequence[str]) -> SentenceFields:
    offset = _number(parts[1]) if parts[1:] and parts[1] else 0.0
    below = _number(parts[0])
    return SentenceFields(
        {"altitude": -below - max(offset, 0.0), "over_bottom": below}
    )  # a negative offset is to the keel


def _in_metres(parts: Sequence[str]) -> SentenceFields:
    below = _number(parts[2])
    return SentenceFields({"altitude": -below, "over_bottom": below})


def _sa(parts: Sequence[str]) -> SentenceFields:
    return SentenceFields({name: _angle(part) for name, part in zip(("pitch", "roll", "yaw"), parts, strict=True)})


def _ts(parts: Sequence[str]) -> SentenceFields:
    return SentenceFields({"altitude": -_number(parts[3])})


def _bd(parts: Sequence[str]) -> SentenceFields:
    age_s = _number(parts[4]) if parts[4:] and parts[4] else 0.0
    return SentenceFields({"over_bottom": _number(parts[3])}, age_s=max(age_s, 0.0))


def _bs(parts: Sequence[str]) -> SentenceFields:
    starboard, forward, up = _track(parts)
    return SentenceFields({"u": forward, "v": starboard, "w": -up})


def _be(parts: Sequence[str]) -> SentenceFields:
    east, north, up = _track(parts)
    return SentenceFields({"velocity_north": north, "velocity_east": east, "velocity_down": -up})


READERS: dict[str, Callable[[Sequence[str]], SentenceFields]] = {
    "GGA": _gga, "RMC": _rmc, "VTG": _vtg, "HDT": _hdt, PASHR: _pashr, PSXN: _psxn, "GST": _gst, "DPT": _dpt,
    "DBT": _in_metres, "DBS": _in_metres, "SA": _sa, "TS": _ts, "BS": _bs, "BE": _be, "BD": _bd,
}  # fmt: skip


def _expect(found: Sequence[str], letter: str) -> None:
    """Refuse a number in feet, or from magnetic north: its letter says so, where there is one."""
    if "".join(found) not in (letter, ""):
        raise BadSentenceError


def _number(text: str) -> float:
    if not text:
        raise NotValidError("a number is missing")
    if NUMBER.fullmatch(text) is None:
        raise BadSentenceError
    return float(text)


def _angle(text: str) -> float:
    return math.radians(_number(text))


def _day_ms(text: str) -> float | None:
    """Return ms since midnight of hhmmss.sss; None where it is left out, or is no time: all else may be good."""
    match = TIME.fullmatch(text)
    if match is None or int(match[1]) > 23 or int(match[2]) > 59 or float(match[3]) >= 61.0:
        return None
    return 1000.0 * (3600 * int(match[1]) + 60 * int(match[2]) + float(match[3]))


def _place(parts: Sequence[str]) -> dict[str, float]:
    """Return latitude and longitude, deg, of ddmm.mm, N or S, dddmm.mm, E or W."""
    if not all(parts):
        raise NotValidError("no place")
    latitude, north, longitude, east = parts
    return {
        "latitude": _sign(north, "NS") * _degrees(latitude),
        "longitude": _sign(east, "EW") * _degrees(longitude),
    }


def _degrees(text: str) -> float:
    match = DEGREES.fullmatch(text)
    if match is None:
        raise BadSentenceError
    minutes = float(match[2] + (match[3] or ""))
    if minutes >= 60.0:
        raise BadSentenceError
    return int(match[1] or 0) + minutes / 60.0


def _sign(text: str, both: str) -> int:
    if text not in tuple(both):
        raise BadSentenceError
    return 1 if text == both[0] else -1


def _speed(knots: str) -> float:
    """Return it in m/s."""
    return _number(knots) * KNOT


def _over_ground(knots: str, course: str) -> dict[str, float]:
    """Return the velocity; one who hardly moves has no course, and is taken to stand still."""
    speed = _speed(knots)
    if not course and speed > REST_MPS:
        raise NotValidError(f"no course at {speed:.1f} m/s")
    north, east = (speed * math.cos(_angle(course)), speed * math.sin(_angle(course))) if course else (0.0, 0.0)
    return {"velocity_north": north, "velocity_east": east, "velocity_down": 0.0}


def _track(parts: Sequence[str]) -> list[float]:
    """Return three velocities, m/s, of a bottom track that is good."""
    *numbers, status = parts
    if status != "A":
        raise NotValidError("no bottom track")
    first, second, third = numbers
    return [MM * _number(text) for text in (first, second, third)]
