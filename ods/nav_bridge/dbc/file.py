"""DBC files of any tool, read message by message with cantools; every failure is one line."""

import re
from pathlib import Path

import cantools
from cantools.database import Database
from cantools.database.can import Message
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


_QUOTED = r'(?:"[^"]*+"|[^;"]){0,20000}+;'
"""The rest of a statement."""
_COMMENT = re.compile(rf'^[ \t]*+CM_\s++(?:\w++\s++){{0,3}}+(?="){_QUOTED}', re.MULTILINE)
"""Of the file, of an object of one or two names, or none: not the word in the list NS_ of the format's symbols."""
_MESSAGE = re.compile(
    r"^[ \t]*+BO_[ \t]++(\d{1,12})[ \t]++(\w++)[ \t]*+:.*+(?:(?:[ \t\r]*+\n)++[ \t]*+SG_[ \t].*+)*+", re.MULTILINE
)
_SIGNAL = re.compile(r"^[ \t]*+SG_[ \t]++(\w++)", re.MULTILINE)
_OF_SIGNAL = re.compile(rf"^[ \t]*+(?:VAL_|SIG_VALTYPE_|SG_MUL_VAL_)\s++(\d{{1,12}})\s++(\w++){_QUOTED}", re.MULTILINE)
_FORMAT = re.compile(rf'^[ \t]*+BA_\s++"VFrameFormat"\s++BO_\s++(\d{{1,12}})\b{_QUOTED}', re.MULTILINE)
_FORMATS = re.compile(rf'^[ \t]*+BA_DEF_(?:DEF_)?+\s++(?:BO_\s++)?+"VFrameFormat"{_QUOTED}', re.MULTILINE)
"""What the numbers of that attribute mean."""


class DbcError(OdsError):
    """A DBC file and the signal map do not fit; the text is one line: file, key, what is wrong with it."""


class DbcText:
    """The statements of a DBC file: a vehicle bus's file describes more than the INS, and all else may be as it is."""

    def __init__(self, file: Path) -> None:
        """Read it, in UTF-8 or, as the format has it, Windows-1252. Raises DbcError."""
        self._file = file
        try:
            text = _COMMENT.sub("", read_text(file, "cp1252"))
        except OSError as error:
            raise DbcError(f"{file}: nav.dbc.file: {error.strerror}") from error
        self._messages: dict[str, list[tuple[str, str]]] = {}
        """Identifier and text of what has a name."""
        for found in _MESSAGE.finditer(text):
            self._messages.setdefault(found[2], []).append((found[1], found[0]))
        if not self._messages:
            raise DbcError(f"{file}: not a usable DBC: no message in it")
        self._about: dict[str, dict[str, str]] = {}
        """Statements about the signals of each identifier, and, by "", about its format."""
        for found in _OF_SIGNAL.finditer(text):
            said = self._about.setdefault(found[1], {})
            said[found[2]] = said.get(found[2], "") + found[0] + "\n"
        for found in _FORMAT.finditer(text):
            self._about.setdefault(found[1], {})[""] = found[0]
        self._formats = "".join(found[0] for found in _FORMATS.finditer(text))

    @property
    def names(self) -> list[str]:
        """Of all messages."""
        return list(self._messages)

    def message(self, name: str, key: str = "nav.dbc.file") -> Message:
        """Return one of them, which a setting names. Raises DbcError."""
        found = self._messages[name]
        if len(found) > 1:
            raise DbcError(f"{self._file}: {key}: message {name} is there {len(found)} times")
        [(number, text)] = found
        about = self._about.get(number, {})
        said = (about.get(signal, "") for signal in (*_SIGNAL.findall(text), ""))
        text = "\n".join((text, self._formats, *said))
        try:
            _refuse_absurd_sizes(text)
            database = cantools.database.load_string(text, "dbc")
            assert isinstance(database, Database)
            return database.messages[0]
        except UnsupportedDatabaseFormatError as error:
            raise DbcError(f"{self._file}: {key}: message {name}: {one_line(error.e_dbc or error)}") from error
        except Exception as error:  # cantools lets through whatever a malformed file runs into
            raise DbcError(f"{self._file}: {key}: message {name}: {one_line(error)}") from error


def _refuse_absurd_sizes(text: str) -> None:
    """Raise ValueError: cantools lists all bits of a message and of each signal, and all numbers of a range."""
    for size in _SIZES.finditer(text):
        if any(int(number[:MOST_DIGITS]) > MOST for number in size.groups("0")):
            raise ValueError(f"{size[0][:80]}: a message has at most {MOST} bits")
    for ranges in _RANGES.finditer(text):
        ends = [(int(first[:MOST_DIGITS]), int(last[:MOST_DIGITS])) for first, last in _RANGE.findall(ranges[0])]
        if any(last - first > MOST or last >= BEYOND_ALL for first, last in ends):
            raise ValueError(f"{ranges[0][:80]}: a range has {MOST} numbers at most")
