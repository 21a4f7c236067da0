"""Sending of the fire message, and its effect by the pings. Pure: the caller passes the time.

An Oculus pings by itself, as its last fire message requested. Each ping result repeats that message, but for the ping
rate. So the message is sent when a connection is made, and again, every REPEAT_S, as long as no ping comes (the sonar
may be in standby) or the pings report other settings; changes of sound speed take several seconds.
"""

from collections import Counter

from ods.base.clock import NS
from ods.sonar_link.oculus import messages
from ods.sonar_link.oculus.messages import Fire
from ods.sonar_link.oculus.settings import MODES, OculusSettings

REPEAT_S = 2.0
LEAST_HIGH_GAIN_PERCENT = 40.0
"""In high mode, 0 to 100 percent of gain are reported as this to 100."""


class FireControl:
    """The wanted settings of one sonar. Counters: control_requests (fire messages), control_lost."""

    def __init__(self, settings: OculusSettings, counters: "Counter[str]") -> None:
        self.counters = counters
        self._wanted = settings.fire()
        self._message = messages.encode_fire(self._wanted, settings.message_version)
        self._settle_ns = round(settings.settle_s * NS)
        self._due_ns: int | None = None  # None: not connected
        self._since_ns = 0
        self._unlike: list[str] = []
        self._taken = False

    def connected(self, now_ns: int) -> None:
        """Send the sonar all settings: the connection is new."""
        self._due_ns = self._since_ns = now_ns
        self._unlike, self._taken = [], False

    def lost(self) -> None:
        """Send nothing until there is a connection."""
        self._due_ns = None

    def receive(self, reported: Fire, now_ns: int) -> None:
        """Take what a ping result repeats of the fire message."""
        self._unlike = differences(self._wanted, reported)
        if self._unlike and self._taken:
            self._since_ns = now_ns
            self.counters["control_lost"] += 1
        self._taken = not self._unlike
        if self._taken and self._due_ns is not None:
            self._due_ns = now_ns + round(REPEAT_S * NS)

    def requests(self, now_ns: int) -> list[bytes]:
        """Return the messages to send now."""
        if self._due_ns is None or now_ns < self._due_ns:
            return []
        self._due_ns = now_ns + round(REPEAT_S * NS)
        self.counters["control_requests"] += 1
        return [self._message]

    def problems(self, now_ns: int) -> list[str]:
        """Return, as text, what the sonar does not do, when it has had the time."""
        late = now_ns - self._since_ns > self._settle_ns
        return [f"the sonar did not accept {what}" for what in self._unlike] if late else []


def differences(wanted: Fire, reported: Fire) -> list[str]:
    """Say in which settings a sonar differs from what was asked for; a model's own steps count as none."""
    unlike = []
    if reported.mode != wanted.mode:
        unlike.append(f"mode {wanted.mode}: it reports {reported.mode}")
    if reported.gamma != wanted.gamma:
        unlike.append(f"gamma {wanted.gamma}: it reports {reported.gamma}")
    if not abs(reported.range_m - wanted.range_m) <= 0.01 * wanted.range_m:
        unlike.append(f"range {wanted.range_m:g} m: it reports {reported.range_m:g} m")
    if not any(abs(reported.gain_percent - gain) <= 0.5 for gain in _gains(wanted)):
        unlike.append(f"gain {wanted.gain_percent:g} %: it reports {reported.gain_percent:g} %")
    if wanted.sound_speed and not abs(reported.sound_speed - wanted.sound_speed) <= 0.5:
        unlike.append(f"sound speed {wanted.sound_speed:g} m/s: it reports {reported.sound_speed:g} m/s")
    if not wanted.sound_speed and not abs(reported.salinity_ppt - wanted.salinity_ppt) <= 0.5:
        unlike.append(f"salinity {wanted.salinity_ppt:g} ppt: it reports {reported.salinity_ppt:g} ppt")
    return unlike


def _gains(wanted: Fire) -> list[float]:
    """Return the values that a ping may report for a gain."""
    high = LEAST_HIGH_GAIN_PERCENT + (1.0 - LEAST_HIGH_GAIN_PERCENT / 100.0) * wanted.gain_percent
    return [wanted.gain_percent, high] if wanted.mode == MODES["high"] else [wanted.gain_percent]
