"""What the sonar is asked for, and whether it took it. Pure: the caller tells the time and what the sonar said.

A setting is asked for after each connection and after each order. Record 7000, which comes with every ping, tells
whether it took effect; if not, it is asked for again, a limited number of times. A setting that is lost later, as by a
restart of the sonar, is asked for again.
"""

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from ods.sonar_link.port.port import NS
from ods.sonar_link.s7k import remote_control
from ods.sonar_link.s7k.records import Controls
from ods.sonar_link.s7k.remote_control import Reply, Request

LEAST_INTERVAL_NS = NS // 5
"""Between two requests for one setting: orders in quick succession are one, the last."""


@dataclass(frozen=True)
class Knob:
    """A setting of the sonar."""

    name: str
    command: int
    unit: str
    tolerance: float
    """How far what the sonar says may lie off what was asked for, in the unit."""
    relative: float = 0.0
    """The same as a share of it: a sonar has its own steps."""


KNOBS: dict[str, Knob] = {
    "range_m": Knob("range", remote_control.SET_RANGE, "m", tolerance=0.0, relative=0.01),
    "power_db": Knob("power", remote_control.SET_POWER, "dB", tolerance=0.5),
    "gain_db": Knob("gain", remote_control.SET_GAIN, "dB", tolerance=0.5),
}
"""By the fields of `s7k.Controls`, of the configuration and of a planner's request."""


class State(Enum):
    """Of an order."""

    ASKED = 1
    TAKEN = 2
    FAILED = 3


@dataclass
class _Order:
    """One setting that is wanted."""

    value: float
    state: State = State.ASKED
    attempts: int = 0
    due: bool = True
    ticket: int = 0
    error: int | None = None

    def renew(self) -> None:
        self.state, self.attempts, self.due, self.error = State.ASKED, 0, True, None


class SonarControl:
    """Orders to one sonar. Counters: control_requests, control_acknowledged, control_refused, control_lost."""

    def __init__(
        self,
        wanted: Mapping[str, float],
        *,
        repeat_s: float = 1.0,
        attempts: int = 3,
        records: tuple[int, ...] = (),
        counters: "Counter[str] | None" = None,
    ) -> None:
        """`wanted`: values by the keys of KNOBS; `records`: types to subscribe to, none for a line that sends all."""
        self.counters: Counter[str] = Counter() if counters is None else counters
        self.told: Controls | None = None
        """What the sonar last said of itself."""
        self._orders = {name: _Order(value) for name, value in wanted.items()}
        self._sent_ns: dict[str, int] = {}  # by the orders' names
        self._repeat_ns = round(repeat_s * NS)
        self._interval_ns = min(LEAST_INTERVAL_NS, self._repeat_ns)
        self._attempts = attempts
        self._records = records
        self._subscription = 0  # its ticket
        self._subscribe_due = False
        self._subscription_error: int | None = None
        self._ticket = 0

    def connected(self) -> None:
        """Ask for everything again: the line to the sonar is new."""
        self._subscribe_due = bool(self._records)
        self._subscription_error = None
        for order in self._orders.values():
            order.renew()

    def order(self, name: str, value: float) -> None:
        """Want another value from now on."""
        self._orders[name] = _Order(value)

    def requests(self, now_ns: int) -> list[Request]:
        """Return what is to be sent now."""
        due = []
        if self._subscribe_due:
            self._subscribe_due = False
            self._subscription = self._next_ticket()
            due.append(remote_control.subscribe(self._subscription, self._records))
        for name, order in self._orders.items():
            if order.due and now_ns - self._sent_ns.get(name, -self._interval_ns) >= self._interval_ns:
                order.due, order.ticket = False, self._next_ticket()
                self._sent_ns[name] = now_ns
                order.attempts += 1
                due.append(remote_control.set_value(KNOBS[name].command, order.ticket, order.value))
        self.counters["control_requests"] += len(due)
        return due

    def hear(self, told: Controls, now_ns: int) -> None:
        """Take what record 7000 says."""
        self.told = told
        for name, order in self._orders.items():
            if _fits(KNOBS[name], order.value, getattr(told, name)):
                order.state, order.due = State.TAKEN, False
            elif order.state is State.TAKEN:
                self.counters["control_lost"] += 1
                order.renew()
            elif order.state is State.ASKED and not order.due and now_ns - self._sent_ns[name] >= self._repeat_ns:
                order.due = order.attempts < self._attempts
                order.state = State.ASKED if order.due else State.FAILED

    def answered(self, reply: Reply) -> None:
        """Take what the sonar replied to a request."""
        self.counters["control_acknowledged" if reply.error is None else "control_refused"] += 1
        if reply.error is None:
            return
        if reply.ticket == self._subscription:
            self._subscription_error = reply.error
        for order in self._orders.values():
            if order.ticket == reply.ticket and order.state is State.ASKED:
                order.state, order.due, order.error = State.FAILED, False, reply.error

    def state(self, name: str) -> State:
        """Return what became of the order of a setting. Raises KeyError when there is none."""
        return self._orders[name].state

    def problems(self) -> list[str]:
        """Say in plain words what the sonar would not do."""
        said = []
        if self._subscription_error is not None:
            records = ", ".join(map(str, self._records))
            said.append(f"the sonar refused to send records {records} (error {self._subscription_error})")
        return said + [text for name in self._orders if (text := self.failure(name))]

    def failure(self, name: str) -> str:
        """Say why the order of a setting failed, '' when it did not."""
        knob, order = KNOBS[name], self._orders[name]
        if order.state is not State.FAILED:
            return ""
        said = f"it says {getattr(self.told, name):g} {knob.unit}" if self.told else "it has not said what it has"
        what = f"{knob.name} {order.value:g} {knob.unit}"
        if order.error is not None:
            return f"the sonar refused {what} (error {order.error}): {said}"
        return f"the sonar did not take {what}: {said}"

    def _next_ticket(self) -> int:
        self._ticket = self._ticket % (2**32 - 1) + 1
        return self._ticket


def _fits(knob: Knob, wanted: float, told: float) -> bool:
    return math.isfinite(told) and abs(told - wanted) <= knob.tolerance + knob.relative * abs(wanted)
