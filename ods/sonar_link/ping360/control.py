"""Requests to a Ping360, and whether it follows them. Pure: the caller passes the time.

It is asked to sweep its sector by itself, which is far faster than a request for each beam. On RS-485 one side speaks
at a time and a request may be lost while beams come, so the beams decide: where none comes, or others than
wanted, it is asked again.
"""

from collections import Counter

from ods.base.clock import NS
from ods.sonar_link.ping360 import messages
from ods.sonar_link.ping360.messages import Beam, Kind, Sweep, Transmission

LONGEST_TURN_NS = 4 * NS
"""Time that the head may take to where its sector begins, as the maker's document says."""
SILENCE_NS = 3 * NS
"""Time without a beam after which a sweep counts as stopped."""
TOLERANCE = 0.02
"""How far pulse and sample period may lie off the wanted ones, as a share."""


class SweepControl:
    """The request for one sector.

    Counters: control_requests (asked to sweep), control_acknowledged (it began to), control_refused (it said no),
    control_lost (asked `attempts` times in a row without effect).
    """

    def __init__(
        self,
        transmission: Transmission,
        sweep: Sweep,
        counters: "Counter[str]",
        *,
        repeat_s: float,
        attempts: int,
    ) -> None:
        self.counters = counters
        self.refusal = ""
        """What it said when it refused; "": it did not."""
        self._transmission, self._sweep = transmission, sweep
        self._repeat_ns = max(round(repeat_s * NS), LONGEST_TURN_NS)
        self._attempts = attempts
        self._tried = 0
        self._due_ns: int | None = None
        self._introduced = False
        self._swept = False
        self._other = ""

    def begin(self, now_ns: int) -> None:
        """Ask: a line has been opened."""
        self._tried, self._due_ns = 0, now_ns
        self._introduced = self._swept = False
        self.refusal = self._other = ""

    def requests(self, now_ns: int) -> list[bytes]:
        """Return the messages to send now."""
        if self._due_ns is None or now_ns < self._due_ns:
            return []
        if self._tried and not self._tried % self._attempts:
            self.counters["control_lost"] += 1
        self._tried += 1
        self._due_ns = now_ns + self._repeat_ns
        self.counters["control_requests"] += 1
        who = [] if self._introduced else [messages.general_request(Kind.DEVICE_INFORMATION)]
        self._introduced = True
        return [*who, messages.auto_transmit(self._transmission, self._sweep)]

    def receive(self, beam: Beam, now_ns: int) -> None:
        """Take a beam: it shows what the sonar does. Once it does it, silence makes it be asked again."""
        self._other = self._difference(beam)
        self.refusal = ""
        if not self._other:
            self.counters["control_acknowledged"] += not self._swept
            self._swept, self._tried = True, 0
            self._due_ns = now_ns + SILENCE_NS
        elif self._tried >= self._attempts:
            self._due_ns = None  # another program's, or it does not obey: `problem` says so

    def hear_refusal(self, of: int, words: str) -> None:
        """Take a NACK."""
        if of == Kind.AUTO_TRANSMIT:
            self.counters["control_refused"] += 1
            self.refusal = words or "no reason given"

    @property
    def problem(self) -> str:
        """Return a text that the sonar does something else than requested; "": it does not, or is still asked."""
        return self._other if self._other and self._due_ns is None else ""

    def _difference(self, beam: Beam) -> str:
        wanted, sweep = self._transmission, self._sweep
        if beam.sweep is None:
            return "another program requests single beams: end it"
        if beam.sweep[:3] != sweep[:3]:
            return f"the sonar sweeps from {beam.sweep.start} to {beam.sweep.stop} gradians, not the requested sector"
        pairs = ((beam.period, wanted.period), (beam.pulse_us, wanted.pulse_us))
        alike = all(abs(reported - asked) <= 1 + TOLERANCE * asked for reported, asked in pairs)
        if alike and len(beam.samples) == wanted.samples and beam.gain == wanted.gain:
            return ""
        return "the sonar's beams are not those requested: another program sets them, or they exceed its limits"
