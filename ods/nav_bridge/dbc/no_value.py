"""Raw values that stand for no measurement: "not available", "error" and the like.

A DBC file says so by a name for the value (`VAL_`), or by a range that leaves it out (`[min|max]`). SAE J1939-71 and
NMEA 2000 keep the highest raw values of every width for it, whatever the file says: J1939 all unsigned ones from 0xFB..
on (0xFE..: error, 0xFF..: not available), NMEA 2000 the highest three, 0x7F..FD to 0x7F..FF of signed numbers.
"""

import re
from typing import NamedTuple

from cantools.database.can import Signal

NAMES = re.compile(
    r"\bn[/.]?a\b|\bsna\b|\bnan\b|not?[\s_-]*(avail|valid|data|signal|present|info|meas|def|fix|used)|unavail|invalid|undef|unknown"
    r"|err|fault|fail|missing|out[\s_-]*of[\s_-]*range|over[\s_-]*(range|flow)|under[\s_-]*(range|flow)|reserved|timed?[\s_-]*out",
    re.IGNORECASE,
)
"""Of values that stand for no measurement."""
HIGHEST = 3
"""Raw values of each width that NMEA 2000 keeps."""
J1939_FIRST, BYTE = 0xFB, 8
"""Highest byte of the first value that J1939 keeps, of numbers of whole bytes."""
LEAST_BITS = 4
"""Of a number: what has fewer is a state."""
SLACK = 1e-3
"""Of the span of a range, at least a count: ends are rounded when they are written down."""


class ReservedValues(NamedTuple):
    """What of a signal's raw values is no measurement."""

    names: dict[int, str]
    least: float
    """What is below is outside of the DBC's range,"""
    most: float
    """and what is above."""
    reserved_from: float
    """What is this or more the protocol keeps."""
    unit: str
    scale: float
    offset: float

    def why(self, count: float) -> str:
        """Return why a raw count is not a measurement, as text; "" if it is one."""
        if count in self.names:
            return f'"{self.names[int(count)]}"'
        if count >= self.reserved_from:
            return f"raw 0x{int(count):X}, which stands for not available or error"
        if not self.least <= count <= self.most:
            return f"{count * self.scale + self.offset:g} {self.unit}".strip() + ", outside of the DBC's range"
        return ""


def no_value_of(signal: Signal, *, extended: bool, j1939: bool, any_value: bool = False) -> ReservedValues:
    """Return which of a signal's values stand for no measurement.

    extended: of a message with such an identifier; j1939: by that protocol; any_value: the DBC's range is not believed.
    """
    names = {int(value): str(name) for value, name in (signal.choices or {}).items() if NAMES.search(str(name))}
    scale, offset = float(signal.scale), float(signal.offset)
    least, most = (-float("inf"), float("inf")) if any_value else _range(signal, scale, offset)
    reserved_from = _reserved_from(signal, extended=extended, j1939=j1939)
    return ReservedValues(names, least, most, reserved_from, signal.unit or "", scale, offset)


def _range(signal: Signal, scale: float, offset: float) -> tuple[float, float]:
    """Return the lowest and the highest raw count of the DBC's range."""
    if signal.minimum is None or signal.maximum is None or not signal.minimum < signal.maximum or scale == 0.0:
        return -float("inf"), float("inf")
    ends = sorted((float(end) - offset) / scale for end in (signal.minimum, signal.maximum))
    slack = max(SLACK * (ends[1] - ends[0]), 0.0 if signal.is_float else 1.0)
    return ends[0] - slack, ends[1] + slack


def _reserved_from(signal: Signal, *, extended: bool, j1939: bool) -> float:
    if signal.is_float or not extended or signal.length < LEAST_BITS:
        return float("inf")
    if signal.is_signed:
        return (1 << (signal.length - 1)) - HIGHEST  # no float: it has 53 bits
    if j1939 and signal.length % BYTE == 0:
        return J1939_FIRST << (signal.length - BYTE)
    return (1 << signal.length) - HIGHEST
