"""Requested settings of a sonar, and whether it accepted them. Pure: the caller passes the time and the sonar's
reports.

A setting is requested by the configuration or by a planner. The request is sent after each connection and each change.
It is sent again, a limited number of times, until the sonar's reports show the value, and also if the sonar loses it
later, for example in a restart. If a planner's request fails, the planner gets the reason, and the previous request
applies again.
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
"""Least time between two messages for one setting: of requests in quick succession only the last is sent."""


@dataclass(frozen=True)
class Controls:
    """Settings that a sonar reports; not trusted: any number, even NaN."""

    range_m: float = math.nan
    power_db: float = math.nan
    """dB re 1 uPa at 1 m."""
    gain_db: float = math.nan

    def levels(self) -> str:
        """Return `Ping.setting`."""
        return f"power {self.power_db:g} dB, gain {self.gain_db:g} dB"


@dataclass(frozen=True)
class RequestableSetting:
    """A setting of a sonar."""

    name: str
    unit: str
    tolerance: float
    """How far what the sonar says may lie off what was asked for, in the unit."""
    relative: float = 0.0
    """The same as a share of it: a sonar has its own steps."""

    def fits(self, wanted: float, reported: float) -> bool:
        """Return whether the reported value is the requested one."""
        return math.isfinite(reported) and abs(reported - wanted) <= self.tolerance + self.relative * abs(wanted)


REQUESTABLE_SETTINGS: dict[str, RequestableSetting] = {
    "range_m": RequestableSetting("range", "m", tolerance=0.0, relative=0.01),
    "power_db": RequestableSetting("power", "dB", tolerance=0.5),
    "gain_db": RequestableSetting("gain", "dB", tolerance=0.5),
}
"""By the fields of `Controls`, of the configuration and of a planner's request."""


class RequestState(Enum):
    """Result of a request so far."""

    PENDING = 1
    ACCEPTED = 2
    FAILED = 3


@dataclass(eq=False)
class SettingRequest:
    """One requested setting and its value."""

    name: str
    """Key of REQUESTABLE_SETTINGS."""
    value: float
    state: RequestState = RequestState.PENDING
    attempts: int = 0
    due: bool = True
    refusal: str = ""
    """The sonar's reason when it refused."""
    from_planner: bool = False
    """A planner's, and not yet fulfilled."""
    before: "SettingRequest | None" = None
    """The request that a planner's has replaced."""

    def resend(self) -> None:
        """Send it again."""
        self.state, self.attempts, self.due, self.refusal = RequestState.PENDING, 0, True, ""

    def refuse(self, reason: str) -> None:
        """Take the sonar's refusal; `reason` in few words, such as "error 2". One that is late changes nothing."""
        if self.state is RequestState.PENDING:
            self.state, self.due, self.refusal = RequestState.FAILED, False, reason


class SettingRequests:
    """All requests to one sonar, one per setting. Counter: control_lost (accepted settings that the sonar lost)."""

    def __init__(
        self,
        wanted: Mapping[str, float],
        *,
        settable: frozenset[str] = frozenset(REQUESTABLE_SETTINGS),
        repeat_s: float = 1.0,
        attempts: int = 3,
        counters: "Counter[str] | None" = None,
    ) -> None:
        """Request these values, by keys of REQUESTABLE_SETTINGS, from the start.

        `settable`: settings that planners may request; `repeat_s`: time until a setting is sent again;
        `attempts`: largest number of times.
        """
        self.counters: Counter[str] = Counter() if counters is None else counters
        self.reported: Controls | None = None
        """The sonar's newest report; None: none yet."""
        self._settable = settable
        self._requests = {name: SettingRequest(name, value) for name, value in wanted.items()}
        self._sent_ns: dict[str, int] = {}
        """By the names of the settings."""
        self._repeat_ns = round(repeat_s * NS)
        self._interval_ns = min(LEAST_INTERVAL_NS, self._repeat_ns)
        self._attempts = attempts

    def resend(self) -> None:
        """Send all requests again, after a new connection."""
        for request in self._requests.values():
            request.resend()

    def unsupported_reason(self, name: str) -> str:
        """Return why planners cannot request a setting of this sonar; '' if they can."""
        return (
            ""
            if name in self._settable
            else f"{name}: this sonar cannot be asked for its {REQUESTABLE_SETTINGS[name].name}"
        )

    def request(self, name: str, value: float) -> None:
        """Request another value for a planner."""
        earlier = self._requests.get(name)
        before = earlier.before if earlier is not None and earlier.from_planner else earlier
        self._requests[name] = SettingRequest(name, value, from_planner=True, before=before)

    def drop_failed_requests(self) -> None:
        """Restore the requests before planners' failed ones, which have been answered by now."""
        for name, request in list(self._requests.items()):
            if request.from_planner and request.state is RequestState.FAILED:
                del self._requests[name]
                if request.before is not None:
                    self._requests[name] = request.before

    def due(self, now_ns: int) -> list[SettingRequest]:
        """Return the requests to send now, and mark them as sent."""
        due = []
        for name, request in self._requests.items():
            if request.due and now_ns - self._sent_ns.get(name, -self._interval_ns) >= self._interval_ns:
                request.due = False
                request.attempts += 1
                self._sent_ns[name] = now_ns
                due.append(request)
        return due

    def receive(self, reported: Controls, now_ns: int) -> None:
        """Update the requests by the settings that the sonar reports."""
        self.reported = reported
        for name, request in self._requests.items():
            if REQUESTABLE_SETTINGS[name].fits(request.value, getattr(reported, name)):
                request.state, request.due = RequestState.ACCEPTED, False
                request.from_planner, request.before = False, None
            elif request.state is RequestState.ACCEPTED:
                self.counters["control_lost"] += 1
                request.resend()
            elif (
                request.state is RequestState.PENDING
                and not request.due
                and now_ns - self._sent_ns[name] >= self._repeat_ns
            ):
                request.due = request.attempts < self._attempts
                request.state = RequestState.PENDING if request.due else RequestState.FAILED

    def state(self, name: str) -> RequestState:
        """Return the state of a setting's request. Raises KeyError if there is none."""
        return self._requests[name].state

    def problems(self) -> list[str]:
        """Return a text for each setting that the sonar did not accept."""
        return [text for name in self._requests if (text := self.failure(name))]

    def failure(self, name: str) -> str:
        """Return why the request of a setting failed; '' if it did not."""
        setting, request = REQUESTABLE_SETTINGS[name], self._requests[name]
        if request.state is not RequestState.FAILED:
            return ""
        said = (
            f"it reports {getattr(self.reported, name):g} {setting.unit}"
            if self.reported
            else "it has not reported its settings"
        )
        what = f"{setting.name} {request.value:g} {setting.unit}"
        if request.refusal:
            return f"the sonar refused {what} ({request.refusal}): {said}"
        return f"the sonar did not accept {what}: {said}"


def configured_requests(settings: SonarSettings, counters: "Counter[str]") -> SettingRequests:
    """Return the configured requests; planners may request what the protocol's row allows."""
    wanted = {name: value for name in REQUESTABLE_SETTINGS if (value := getattr(settings, name)) is not None}
    settable = PROTOCOLS[settings.protocol].settable
    repeat_s, attempts = settings.control_repeat_s, settings.control_attempts
    return SettingRequests(wanted, settable=settable, repeat_s=repeat_s, attempts=attempts, counters=counters)
