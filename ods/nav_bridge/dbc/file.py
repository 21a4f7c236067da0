"""DBC files, whoever wrote them: read with cantools, every failure one line."""

import re
from pathlib import Path

import cantools
from cantools.database import Database
from cantools.database.errors import UnsupportedDatabaseFormatError

from ods.base.errors import OdsError, one_line
from ods.nav_bridge.encoding import read_text

MOST = 16_384
"""Bits of a message, which J1939 may send in 1785 bytes, and numbers of a range."""
MOST_DIGITS = 12
"""Of a number; longer ones are cut off and too large as well."""
BEYOND_ALL = 10 ** (MOST_DIGITS - 1)
_SIZES = re.compile(r"\bBO_\s++\d++\s++\w++\s*+:\s*+(\d++)|(?<!\d)(\d++)\s*+\|\s*+(\d++)\s*+@")
"""Bytes of a message; first bit and bits of a signal."""
_RANGES = re.compile(r"\bSG_MUL_VAL_[^;]*+")
_RANGE = re.compile(r"(?<!\d)(\d++)\s*+-\s*+(\d++)")


class DbcError(OdsError):
    """A DBC file and the signal map do not fit; the text is one line: file, key, what is wrong with it."""


def read_database(file: Path) -> Database:
    """Read a DBC file, in UTF-8 or, as the format has it, Windows-1252. Raises DbcError."""
    try:
        text = read_text(file, "cp1252")
    except OSError as error:
        raise DbcError(f"{file}: nav.dbc.file: {error.strerror}") from error
    try:
        _refuse_absurd_sizes(text)
        database = cantools.database.load_string(text, "dbc", strict=False)  # what is mapped is checked by signal_map
    except UnsupportedDatabaseFormatError as error:
        raise DbcError(f"{file}: not a usable DBC: {one_line(error.e_dbc or error)}") from error
    except Exception as error:  # cantools lets through whatever a malformed file runs into
        raise DbcError(f"{file}: not a usable DBC: {one_line(error)}") from error
    assert isinstance(database, Database)
    return database


def _refuse_absurd_sizes(text: str) -> None:
    """Raise ValueError: cantools lists all bits of a message and of each signal, and all numbers of a range."""
    for told in _SIZES.finditer(text):
        if any(int(number[:MOST_DIGITS]) > MOST for number in told.groups("0")):
            raise ValueError(f"{told[0][:80]}: a message has {MOST} bits at most")
    for told in _RANGES.finditer(text):
        ends = [(int(first[:MOST_DIGITS]), int(last[:MOST_DIGITS])) for first, last in _RANGE.findall(told[0])]
        if any(last - first > MOST or last >= BEYOND_ALL for first, last in ends):
            raise ValueError(f"{told[0][:80]}: a range has {MOST} numbers at most")
