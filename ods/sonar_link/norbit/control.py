"""Commands to a Norbit's command port, one line after another, and its answers. Pure: the caller passes the
time.

The sonar wants its answer awaited before the next command. An answer is a line that repeats the command and the values
that now hold, `set_range 0.5 20.0 # in meter`; some leave out `set_`. Other lines, such as its greeting, are none. The
whole list is sent after each connection of either port, as the sonar may have been switched off and on.
"""

import re
from collections import Counter
from typing import NamedTuple

from ods.base.clock import NS

LONGEST_LINE = 4096
"""Bytes; what comes without a line's end beyond is dropped."""
TOLERANCE, SHARE = 0.01, 0.02
"""How far an answered value may lie off the wanted one: the sonar has its own steps and digits."""
ABOUT = frozenset({"set_resolution"})
"""Commands that the sonar obeys as far as its own steps allow: their values are not compared."""
_NUMBER = re.compile(rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_LINE_END = re.compile(rb"[\r\n]+")


class Command(NamedTuple):
    """One command and its values."""

    name: str
    values: tuple[float, ...]

    @property
    def words(self) -> str:
        """As it is sent, and said."""
        return " ".join([self.name, *(f"{value:g}" for value in self.values)])


class CommandControl:
    """The commands of one sonar.

    Counters: control_requests (commands sent), control_acknowledged (answers), control_refused (answers with other
    values), control_lost (commands never answered).
    """

    def __init__(
        self, commands: list[Command], counters: "Counter[str]", *, repeat_s: float = 1.0, attempts: int = 3
    ) -> None:
        """Send these; each up to `attempts` times, `repeat_s` apart, until it is answered."""
        self.counters = counters
        self._commands = commands
        self._repeat_ns = round(repeat_s * NS)
        self._attempts = attempts
        self._bytes = b""
        self._connected = False
        self._place = 0
        self._tried = 0
        self._due_ns = 0
        self._answers: dict[str, tuple[float, ...] | None] = {}  # None: no answer

    @property
    def answered(self) -> bool:
        """Return whether the sonar has answered any command on this connection."""
        return any(answer is not None for answer in self._answers.values())

    def connected(self, now_ns: int) -> None:
        """Begin: the command port has been connected."""
        self._connected = True
        self._bytes = b""
        self._answers = {}
        self._tried = 0
        self.begin(now_ns)

    def begin(self, now_ns: int) -> None:
        """Send all commands, from the first on; former answers hold until there are new ones.

        One that waits for its very first answer goes on waiting: the stream of a silent sonar is made again and
        again.
        """
        if self._tried and not self.answered:
            return
        self._place = self._tried = 0
        self._due_ns = now_ns

    def lost(self) -> None:
        """Send nothing until there is a connection."""
        self._connected = False

    def requests(self, now_ns: int) -> list[bytes]:
        """Return the command that is to be sent now."""
        if not self._connected or self._place >= len(self._commands) or now_ns < self._due_ns:
            return []
        if self._tried >= self._attempts:
            self.counters["control_lost"] += 1
            self._answers[self._now.name] = None
            self._go_on(now_ns)
            return self.requests(now_ns)
        self._tried += 1
        self._due_ns = now_ns + self._repeat_ns
        self.counters["control_requests"] += 1
        return [self._now.words.encode() + b"\r\n"]

    def receive(self, data: bytes, now_ns: int) -> None:
        """Take what came on the command port, in any chunking."""
        *lines, rest = _LINE_END.split(self._bytes + data)
        self._bytes = rest if len(rest) <= LONGEST_LINE else b""
        for line in lines:
            if self._place < len(self._commands) and self._tried:
                self._take(line, now_ns)

    def problems(self) -> list[str]:
        """Return the commands that the sonar did not accept, as text, without those not answered yet."""
        if self._answers and not self.answered:
            return ["the sonar does not answer commands: is `command_port` that of a WBMS?"]
        return [text for command in self._commands if (text := self._objection(command))]

    @property
    def _now(self) -> Command:
        return self._commands[self._place]

    def _go_on(self, now_ns: int) -> None:
        self._place += 1
        self._tried = 0
        self._due_ns = now_ns

    def _take(self, line: bytes, now_ns: int) -> None:
        said = line.partition(b"#")[0]
        for key in (self._now.name, self._now.name.removeprefix("set_")):
            _, found, values = said.partition(key.encode())
            if found:
                self._answers[self._now.name] = tuple(float(number) for number in _NUMBER.findall(values))
                self.counters["control_acknowledged"] += 1
                if self._objection(self._now):
                    self.counters["control_refused"] += 1
                self._go_on(now_ns)
                return

    def _objection(self, command: Command) -> str:
        if command.name not in self._answers:
            return ""
        answer = self._answers[command.name]
        if answer is None:
            return f"the sonar did not answer {command.words}"
        if command.name in ABOUT or len(answer) < len(command.values) or _alike(command.values, answer):
            return ""
        return f"the sonar did not accept {command.words}: it reports {' '.join(f'{value:g}' for value in answer)}"


def _alike(wanted: tuple[float, ...], answer: tuple[float, ...]) -> bool:
    pairs = zip(wanted, answer, strict=False)
    return all(abs(value - said) <= TOLERANCE + SHARE * abs(value) for value, said in pairs)
