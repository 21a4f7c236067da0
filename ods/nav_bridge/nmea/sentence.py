"""Sentences to pose fields: NMEA 0183 by pynmea2, and the lines of a Doppler log's PD6.

Sources: NMEA 0183 as pynmea2 has its fields; PASHR as Trimble and NovAtel describe it; PD6 as Teledyne RD Instruments
describe it in the Pathfinder's guide (1-sigma in degrees; velocities in mm/s).
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
MADE_BY = "PASHR"
"""The one sentence of a maker that is understood: its name has no talker."""


class BadSentenceError(Exception):
    """A line that is damaged or says what no sentence can."""


class NotValidError(Exception):
    """A sentence that says of itself that it is not valid."""


class Told(NamedTuple):
    """What a sentence tells."""

    values: dict[str, float]
    """Pose fields."""
    day_ms: float | None = None
    """UTC, ms since midnight."""


class Sentence(NamedTuple):
    """A line that was found undamaged."""

    talker: str
    """"" where there is none."""
    name: str
    """GGA, PASHR, BS."""
    parts: Sequence[str]


def name_of(line: bytes) -> tuple[str, str]:
    """Return talker and name of a line that may be anything, "", "" when it is nothing known; cheap."""
    text = line[:6].decode("ascii", "replace")
    if text[:1] == ":":
        return "", text[1:3] if text[3:4] == "," else ""
    if text[:1] != "$":
        return "", ""
    return ("", MADE_BY) if text == f"${MADE_BY}" else (text[1:3], text[3:6])


def parse(line: bytes) -> Sentence:
    """Return the parts of a line. Raises BadSentenceError: also where a checksum is missing, which PD6 has not."""
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
    try:
        parts = pynmea2.parse(text, check=True).data
    except Exception as error:  # ValueErrors of its own, and whatever else a malformed sentence runs into
        raise BadSentenceError from error
    return Sentence(talker, name, parts)


def read(sentence: Sentence) -> Told:
    """Return what a sentence of READERS tells. Raises BadSentenceError and NotValidError."""
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


def _gga(parts: Sequence[str]) -> Told:
    if parts[5] in ("", "0"):
        raise NotValidError
    _expect(parts[9:10], "M")
    values = _place(parts[1:5]) | {"altitude": _number(parts[8])}
    return Told(values, _day_ms(parts[0]))


def _rmc(parts: Sequence[str]) -> Told:
    if parts[1] != "A":
        raise NotValidError
    speed, course = _number(parts[6]) * KNOT, _course(parts[7], parts[6])
    return Told(_place(parts[2:6]) | _over_ground(speed, course), _day_ms(parts[0]))


def _vtg(parts: Sequence[str]) -> Told:
    if parts[8:9] == ["N"] or not parts[4]:
        raise NotValidError
    _expect(parts[1:2], "T")
    return Told(_over_ground(_number(parts[4]) * KNOT, _course(parts[0], parts[4])))


def _hdt(parts: Sequence[str]) -> Told:
    _expect(parts[1:2], "T")
    return Told({"yaw": _angle(parts[0])})


def _pashr(parts: Sequence[str]) -> Told:
    _, time, heading, true, roll, pitch, _, *accuracies = parts
    _expect([true], "T")
    values = {"roll": _angle(roll), "pitch": _angle(pitch)}
    if heading:
        values["yaw"] = _angle(heading)
    names = "sigma_roll", "sigma_pitch", "sigma_yaw"
    values |= {name: _angle(text) for name, text in zip(names, accuracies, strict=False) if text}
    return Told(values, _day_ms(time))


def _gst(parts: Sequence[str]) -> Told:
    names = "sigma_north", "sigma_east", "sigma_down"
    return Told({name: _number(part) for name, part in zip(names, parts[5:8], strict=True)}, _day_ms(parts[0]))


def _dpt(parts: Sequence[str]) -> Told:
    offset = _number(parts[1]) if parts[1:] and parts[1] else 0.0
    below = _number(parts[0])
    return Told({"altitude": -below - max(offset, 0.0), "over_bottom": below})  # a negative offset is to the keel


def _in_metres(parts: Sequence[str]) -> Told:
    below = _number(parts[2])
    return Told({"altitude": -below, "over_bottom": below})


def _sa(parts: Sequence[str]) -> Told:
    return Told({name: _angle(part) for name, part in zip(("pitch", "roll", "yaw"), parts, strict=True)})


def _ts(parts: Sequence[str]) -> Told:
    return Told({"altitude": -_number(parts[3])})


def _bd(parts: Sequence[str]) -> Told:
    return Told({"over_bottom": _number(parts[3])})


def _bs(parts: Sequence[str]) -> Told:
    starboard, forward, up = _track(parts)
    return Told({"u": forward, "v": starboard, "w": -up})


def _be(parts: Sequence[str]) -> Told:
    east, north, up = _track(parts)
    return Told({"velocity_north": north, "velocity_east": east, "velocity_down": -up})


READERS: dict[str, Callable[[Sequence[str]], Told]] = {
    "GGA": _gga, "RMC": _rmc, "VTG": _vtg, "HDT": _hdt, "PASHR": _pashr, "GST": _gst, "DPT": _dpt, "DBT": _in_metres,
    "DBS": _in_metres, "SA": _sa, "TS": _ts, "BS": _bs, "BE": _be, "BD": _bd,
}  # fmt: skip


def _expect(found: Sequence[str], letter: str) -> None:
    """Refuse a number in feet, or from magnetic north: its letter says so, where there is one."""
    if "".join(found) not in (letter, ""):
        raise BadSentenceError


def _number(text: str) -> float:
    if not text:
        raise NotValidError
    if NUMBER.fullmatch(text) is None:
        raise BadSentenceError
    return float(text)


def _angle(text: str) -> float:
    return math.radians(_number(text))


def _day_ms(text: str) -> float | None:
    """Return ms since midnight of hhmmss.sss, None where it is left out."""
    if not text:
        return None
    match = TIME.fullmatch(text)
    if match is None or int(match[1]) > 23 or int(match[2]) > 59 or float(match[3]) >= 61.0:
        raise BadSentenceError
    return 1000.0 * (3600 * int(match[1]) + 60 * int(match[2]) + float(match[3]))


def _place(parts: Sequence[str]) -> dict[str, float]:
    """Return latitude and longitude, deg, of ddmm.mm, N or S, dddmm.mm, E or W."""
    if not all(parts):
        raise NotValidError
    latitude, north, longitude, east = parts
    return {
        "latitude": _sign(north, "NS") * _degrees(latitude, 2),
        "longitude": _sign(east, "EW") * _degrees(longitude, 3),
    }


def _degrees(text: str, digits: int) -> float:
    whole, minutes = text[:digits], text[digits:]
    if not whole.isdigit() or not minutes[:1].isdigit() or _number(minutes) >= 60.0:
        raise BadSentenceError
    return int(whole) + _number(minutes) / 60.0


def _sign(text: str, both: str) -> int:
    if text not in tuple(both):
        raise BadSentenceError
    return 1 if text == both[0] else -1


def _course(text: str, speed: str) -> float:
    """Return the course, rad; one who stands still has none."""
    return _angle(text) if text or _number(speed) else 0.0


def _over_ground(speed: float, course: float) -> dict[str, float]:
    return {
        "velocity_north": speed * math.cos(course), "velocity_east": speed * math.sin(course), "velocity_down": 0.0
    }  # fmt: skip


def _track(parts: Sequence[str]) -> list[float]:
    """Return three velocities, m/s, of a bottom track that is good."""
    *numbers, status = parts
    if status != "A":
        raise NotValidError
    first, second, third = numbers
    return [MM * _number(text) for text in (first, second, third)]
