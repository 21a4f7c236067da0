"""Requested settings of a sonar, and whether it accepted them. Pure: the caller passes the time and the sonar's
reports.

A setting is ordered by the configuration or by a planner. It is asked for after each connection and after each order.
What the sonar says of itself says whether it took effect; if not, it is asked for again, a limited number of times. A
setting that is lost later, as by a restart of the sonar, is asked for again. A planner's wish that the sonar does not
fulfil is the planner's matter: it receives why, and what was ordered before holds again.
"""

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from ods.base.clock import NS
from ods.sonar_link.registry import PROTOCOLS
from ods.sonar_link.settings import SonarSettings

LEAST_INTERVAL_NS = NS // 5
"""Between two requests for one setting: orders in quick succession are one, the last."""


@dataclass(frozen=True)
class Controls:
    """What a sonar says of its settings; not trusted: any number, NaN too."""

    range_m: float = math.nan
    power_db: float = math.nan
    """dB re 1 uPa at 1 m."""
    gain_db: float = math.nan

    def levels(self) -> str:
        """Return `Ping.setting`."""
        return f"power {self.power_db:g} dB, gain {self.gain_db:g} dB"


@dataclass(frozen=True)
class Knob:
    """A setting of a sonar."""

    name: str
    unit: str
    tolerance: float
    """How far what the sonar says may lie off what was asked for, in the unit."""
    relative: float = 0.0
    """The same as a share of it: a sonar has its own steps."""

    def fits(self, wanted: float, reported: float) -> bool:
        """Return whether what the sonar says is what was asked for."""
        return math.isfinite(reported) and abs(reported - wanted) <= self.tolerance + self.relative * abs(wanted)


KNOBS: dict[str, Knob] = {
    "range_m": Knob("range", "m", tolerance=0.0, relative=0.01),
    "power_db": Knob("power", "dB", tolerance=0.5),
    "gain_db": Knob("gain", "dB", tolerance=0.5),
}
"""By the fields of `Controls`, of the configuration and of a planner's request."""


class OrderState(Enum):
    """What became of an order."""

    ASKED = 1
    TAKEN = 2
    FAILED = 3


@dataclass(eq=False)
class Order:
    """One setting that is wanted."""

    name: str
    """Key of KNOBS."""
    value: float
    state: OrderState = OrderState.ASKED
    attempts: int = 0
    due: bool = True
    refusal: str = ""
    """What the sonar said when it refused."""
    is_wish: bool = False
    """A planner's, and never fulfilled so far."""
    before: "Order | None" = None
    """What a wish took the place of."""

    def renew(self) -> None:
        """Ask again."""
        self.state, self.attempts, self.due, self.refusal = OrderState.ASKED, 0, True, ""

    def refuse(self, reason: str) -> None:
        """Take the sonar's refusal; `reason` in few words, such as "error 2". One that is late changes nothing."""
        if self.state is OrderState.ASKED:
            self.state, self.due, self.refusal = OrderState.FAILED, False, reason


class Orders:
    """All orders to one sonar, one a setting. Counter: control_lost (settings that a sonar had taken and lost)."""

    def __init__(
        self,
        wanted: Mapping[str, float],
        *,
        settable: frozenset[str] = frozenset(KNOBS),
        repeat_s: float = 1.0,
        attempts: int = 3,
        counters: "Counter[str] | None" = None,
    ) -> None:
        """Want these values, by keys of KNOBS, from the start.

        `settable`: what planners may ask for; `repeat_s`: time for a setting to show before it is asked for again;
        `attempts`: how often at most.
        """
        self.counters: Counter[str] = Counter() if counters is None else counters
        self.reported: Controls | None = None
        """What the sonar last said of itself; None: nothing yet."""
        self._settable = settable
        self._orders = {name: Order(name, value) for name, value in wanted.items()}
        self._sent_ns: dict[str, int] = {}
        """By the names of the orders."""
        self._repeat_ns = round(repeat_s * NS)
        self._interval_ns = min(LEAST_INTERVAL_NS, self._repeat_ns)
        self._attempts = attempts

    def renew(self) -> None:
        """Ask for everything again: the line to the sonar is new."""
        for order in self._orders.values():
            order.renew()

    def objection(self, name: str) -> str:
        """Return why planners cannot ask this sonar for a setting, '' when they can."""
        return "" if name in self._settable else f"{name}: this sonar cannot be asked for its {KNOBS[name].name}"

    def wish(self, name: str, value: float) -> None:
        """Want another value from now on, if the sonar takes it."""
        earlier = self._orders.get(name)
        before = earlier.before if earlier is not None and earlier.is_wish else earlier
        self._orders[name] = Order(name, value, is_wish=True, before=before)

    def drop_failed_wishes(self) -> None:
        """Want again what was ordered before the wishes that failed. Who made them has received it by now."""
        for name, order in list(self._orders.items()):
            if order.is_wish and order.state is OrderState.FAILED:
                del self._orders[name]
                if order.before is not None:
                    self._orders[name] = order.before

    def due(self, now_ns: int) -> list[Order]:
        """Return the orders that are to be sent now, and take them for sent."""
        due = []
        for name, order in self._orders.items():
            if order.due and now_ns - self._sent_ns.get(name, -self._interval_ns) >= self._interval_ns:
                order.due = False
                order.attempts += 1
                self._sent_ns[name] = now_ns
                due.append(order)
        return due

    def receive(self, reported: Controls, now_ns: int) -> None:
        """Take the settings that the sonar reports."""
        self.reported = reported
        for name, order in self._orders.items():
            if KNOBS[name].fits(order.value, getattr(reported, name)):
                order.state, order.due, order.is_wish, order.before = OrderState.TAKEN, False, False, None
            elif order.state is OrderState.TAKEN:
                self.counters["control_lost"] += 1
                order.renew()
            elif order.state is OrderState.ASKED and not order.due and now_ns - self._sent_ns[name] >= self._repeat_ns:
                order.due = order.attempts < self._attempts
                order.state = OrderState.ASKED if order.due else OrderState.FAILED

    def state(self, name: str) -> OrderState:
        """Return what became of the order of a setting. Raises KeyError when there is none."""
        return self._orders[name].state

    def problems(self) -> list[str]:
        """Return the settings that the sonar did not accept, a text each."""
        return [text for name in self._orders if (text := self.failure(name))]

    def failure(self, name: str) -> str:
        """Return why the order of a setting failed, '' when it did not."""
        knob, order = KNOBS[name], self._orders[name]
        if order.state is not OrderState.FAILED:
            return ""
        said = (
            f"it reports {getattr(self.reported, name):g} {knob.unit}"
            if self.reported
            else "it has not reported its settings"
        )
        what = f"{knob.name} {order.value:g} {knob.unit}"
        if order.refusal:
            return f"the sonar refused {what} ({order.refusal}): {said}"
        return f"the sonar did not accept {what}: {said}"


def configured_orders(settings: SonarSettings, counters: "Counter[str]") -> Orders:
    """Return the orders that the configuration gives; planners may ask for what the protocol's row allows."""
    wanted = {name: value for name in KNOBS if (value := getattr(settings, name)) is not None}
    settable = PROTOCOLS[settings.protocol].knobs
    repeat_s, attempts = settings.control_repeat_s, settings.control_attempts
    return Orders(wanted, settable=settable, repeat_s=repeat_s, attempts=attempts, counters=counters)
