"""A navigation system, or single sensors, whose sentences come on one line, which is receive-only."""

import logging
import math
from collections.abc import Iterator

from ods.base.clock import DAY_MS, MS, NS
from ods.base.errors import OdsError
from ods.messages import Pose
from ods.nav_bridge.clocks.ins_clock import InsClock
from ods.nav_bridge.clocks.utc import ReportedUtc
from ods.nav_bridge.held import HeldSlot, HeldValues
from ods.nav_bridge.nmea import sentence
from ods.nav_bridge.nmea.line import Line
from ods.nav_bridge.nmea.sentence import BadSentenceError, NoChecksumError, NotValidError, SentenceFields
from ods.nav_bridge.pose_fields import ATTITUDE_SIGMAS, OPTIONAL, OVER_BOTTOM, PLACE_SIGMAS, PoseMaker
from ods.nav_bridge.settings import NMEA_CHOICES, TALKER, HeldSettings, NavSettings, NmeaSettings
from ods.nav_bridge.source import PoseSource, SourceHost

log = logging.getLogger(__name__)

TALKER_NS = 10 * NS
"""Time after which a talker counts as gone; the slowest useful sentences come more often."""
DATE = "ZDA"
"""Carries UTC, the only value taken from it."""
BODY, OVER_GROUND = ("u", "v", "w"), ("velocity_north", "velocity_east", "velocity_down")
FIELDS: dict[str, tuple[str, ...]] = {
    "place": ("latitude", "longitude"),
    "depth": ("altitude",),
    "attitude": ("roll", "pitch"),
    "heading": ("yaw",),
    "accuracy": PLACE_SIGMAS[0],
    "altitude": (OVER_BOTTOM,),
}
"""Pose fields of each part of the settings; a velocity's are those of its sentence."""


BARE = "without checksum, and dropped: configure the sender to append it (*hh)"
DAMAGED = "damaged, and is dropped: its checksum or its fields are wrong"


class NmeaSource(PoseSource[Line]):
    """Sentences to poses: one for each sentence with roll and pitch; all else is held, each with its age.

    The clock of the sentence with roll and pitch, where it has one, is mapped as any INS's; others with a time
    are placed by it, those that do not by their arrival. Counts `nmea_sentences`, `nmea_other` (of no use),
    `nmea_damaged` (checksum, or no sentence), `nmea_no_checksum`, `nmea_not_valid` (by its own word), `nmea_no_fix`
    (used, by `nav.nmea.accept`), `epoch_aged`, `epoch_untimed`, `nmea_talkers`, and what `InsClock`, `ReportedUtc` and
    `PoseMaker` do.
    """

    kind = "NMEA"

    def __init__(self, nav: NavSettings, settings: NmeaSettings, host: SourceHost) -> None:
        """Choose the sentences. Raises OdsError when they do not make a pose."""
        super().__init__(nav, host.now_ns)
        self._counters, self._utc = host.counters, host.utc
        self._accept, self._look_at = settings.accept, settings.look_at
        self._parts = _parts(settings)
        self._talkers = {TALKER.sub("", part): part[:2] for part in self._parts.values() if TALKER.match(part)}
        self._fields = _fields(self._parts)
        self._pace = TALKER.sub("", settings.attitude)
        self._slots = {
            name: HeldSlot(name, f"nav.nmea.held.{name}", settings.held.get(name, HeldSettings()), fields)
            for name, fields in self._fields.items()
            if name != self._pace
        }
        self._held = HeldValues(self._slots.values())
        self._usual_sigma = nav.sigma.attitude_rad
        names = {name for fields in self._fields.values() for name in fields}
        try:
            self._maker = PoseMaker(names, host.frame, nav.limits, nav.sigma, host.utc, host.counters)
        except OdsError as error:
            raise OdsError(f"nav.nmea: {error}") from error
        self._clock = InsClock(round(nav.clock_jump_s * NS), host.counters)
        self._newest: tuple[float, int] | None = None
        self._reported_utc = ReportedUtc(host.counters)
        self._talker_times: dict[str, dict[str, int]] = {}
        """When each sentence last came of each talker."""
        self._unreadable_ns = self._undamaged_ns = host.now_ns - NS
        """When a line that is no sentence, and an undamaged sentence of use, last came."""
        self._dropped: dict[str, tuple[int, str]] = {}
        """Of sentences that were not undamaged since: when they last came, and what is wrong with them."""
        self._refused: tuple[int, str] | None = None
        """When the sentence with pace last was not valid, and why, if that was the newest."""
        self._seapath_invalid: frozenset[str] = frozenset()
        """Pose fields of PSXN 23 that the newest PSXN 20 calls invalid."""
        self._start_ns = host.now_ns

    def expects(self) -> dict[str, str]:
        """Return the chosen sentences and what is taken from each."""
        return {name: ", ".join(self._parts_of(name)) for name in self._fields}

    @property
    def late_ns(self) -> int:
        """How late the newest sentence with pace was."""
        return self._clock.late_ns

    def name_of(self, item: Line) -> str:
        """Return the sentence's name without talker, "?" for a malformed line."""
        return sentence.name_of(sentence.strip_framing(item.data))[1] or "?"

    def _take(self, item: Line) -> Pose | None:
        line = sentence.strip_framing(item.data)
        talker, name = sentence.name_of(line)
        if name not in self._fields and name != DATE:
            self._counters["nmea_other" if name else "nmea_damaged"] += 1
            self._unreadable_ns = self._unreadable_ns if name else item.t_ns
            return None
        if self._talkers.get(name, talker) != talker:
            self._counters["nmea_other"] += 1
            return None
        try:
            return self._use(sentence.parse(line), item.t_ns)
        except NoChecksumError:
            self._counters["nmea_no_checksum"] += 1
            self._dropped[name] = item.t_ns, BARE
        except BadSentenceError:
            self._counters["nmea_damaged"] += 1
            self._dropped[name] = item.t_ns, DAMAGED
        except NotValidError as error:
            self._counters["nmea_not_valid"] += 1
            self._hear(name, talker, item.t_ns)
            self._refuse(name, item.t_ns, str(error))
        return None

    def _refuse(self, name: str, t_ns: int, why: str) -> None:
        if name == DATE:
            self._utc.take(None)
        elif name == self._pace:
            self._refused = t_ns, why
        else:
            self._slots[name].refuse(t_ns, why)

    def _use(self, found: sentence.Sentence, t_ns: int) -> Pose | None:
        if found.name == DATE:
            self._reported_utc.take(sentence.utc_of(found), t_ns)
            self._utc.take(self._reported_utc.ahead_ns)
            return None
        read = sentence.read(found)
        if read.invalid is not None:
            self._seapath_invalid = read.invalid
        if not read.values:
            self._counters["nmea_other"] += 1
            return None
        sigma_m = self._accepted(read.kind)
        wanted = self._fields[found.name]
        if found.name == sentence.PSXN and not self._seapath_invalid.isdisjoint(wanted):
            raise NotValidError("PSXN 20 flags the data as invalid")
        values = {name: value for name, value in read.values.items() if name in wanted}
        for name in ATTITUDE_SIGMAS[0]:
            if name in wanted:
                values.setdefault(name, self._usual_sigma)
        if len(values) < len(wanted):
            missing = [
                part for part in self._parts_of(found.name) if not values.keys() & set(_fields_of(part, found.name))
            ]
            raise NotValidError(f"no {' and no '.join(missing)}" if missing else "")
        self._counters["nmea_sentences"] += 1
        self._hear(found.name, found.talker, t_ns)
        if found.name == self._pace:
            self._refused = None
            return self._pose(values, self._instant(read, t_ns), t_ns)
        slot = self._slots[found.name]
        worse_m = read.corrections_s * slot.growth_m_s
        slot.take(values, self._placed(read, t_ns) - round(read.age_s * NS), math.hypot(sigma_m, worse_m))
        return None

    def _accepted(self, kind: str) -> float:
        """Return what a place that is no fix adds to the standard deviation, m. Raises NotValidError where refused.

        A dead reckoning's error is in the accuracy sentence, where one is used: it is not counted twice.
        """
        if not kind:
            return 0.0
        if kind not in self._accept:
            raise NotValidError(f"it is {kind}, which nav.nmea.accept excludes")
        if not self._counters["nmea_no_fix"]:
            log.warning("positions or velocities are %s (logged once, then counted as nmea_no_fix)", kind)
        self._counters["nmea_no_fix"] += 1
        return 0.0 if kind == "estimated" and "accuracy" in self._parts else self._accept[kind]

    def _parts_of(self, name: str) -> list[str]:
        return [part for part, part_of in self._parts.items() if TALKER.sub("", part_of) == name]

    def _hear(self, name: str, talker: str, t_ns: int) -> None:
        """Take note of who talks."""
        self._dropped.pop(name, None)
        self._undamaged_ns = t_ns
        times = self._talker_times.setdefault(name, {})
        times[talker] = t_ns
        complaint = _two_talkers(name, times, t_ns)
        if complaint:
            if not self._counters["nmea_talkers"]:
                log.warning("%s (logged once, then counted as nmea_talkers)", complaint)
            self._counters["nmea_talkers"] += 1

    def _pose(self, values: dict[str, float], instant_ns: int, t_ns: int) -> Pose | None:
        ages = self._held.add_to(values, instant_ns)
        if ages is None:
            self._counters["epoch_aged"] += 1
            return None
        return self._maker.make(values, instant_ns, t_ns, ages)

    def _instant(self, read: SentenceFields, t_ns: int) -> int:
        """Return the instant of the sentence that poses keep pace with."""
        if read.day_ms is None:
            self._counters["epoch_untimed"] += 1
            return t_ns
        instant_ns = self._clock.instant(read.day_ms, t_ns)
        self._newest = read.day_ms, instant_ns
        return instant_ns

    def _placed(self, read: SentenceFields, t_ns: int) -> int:
        """Return the instant of another sentence, by the clock of the newest with pace."""
        if read.day_ms is None or self._newest is None:
            return t_ns
        day_ms, instant_ns = self._newest
        step_ms = (read.day_ms - day_ms + DAY_MS / 2) % DAY_MS - DAY_MS / 2
        return min(instant_ns + round(step_ms * MS), t_ns)

    def unusable(self) -> dict[str, str]:
        """Return the sentences that come but were never undamaged, and what is wrong with them."""
        return {name: why for name, (_, why) in self._dropped.items() if name not in self._talker_times}

    def _complaints(self, now_ns: int) -> list[str]:
        dropped = {name: why for name, (t_ns, why) in self._dropped.items() if now_ns - t_ns < NS}
        if now_ns - self._undamaged_ns > NS:  # nothing else comes: one cause for all of them
            if len(set(dropped.values())) == 1:
                return [f"all useful sentences are {min(dropped.values())}"]
            if not dropped and now_ns - self._unreadable_ns < NS:
                return [f"the data received are not NMEA: {self._look_at}"]
        found = [self._maker.disbelief] if self._maker.disbelief else []
        if now_ns - self._start_ns > self._stale_ns:
            found += self._never(dropped)
        found += filter(None, (_two_talkers(name, times, now_ns) for name, times in self._talker_times.items()))
        if self._pace in dropped and self._pace in self._talker_times:
            found.append(f"{self._pace} comes {dropped[self._pace]}")
        elif self._refused is not None and now_ns - self._refused[0] < NS:
            why = self._refused[1]
            found.append(f"{self._pace}: flagged as not valid" + (f" ({why})" if why else ""))
        return [*found, *self._held.too_old(now_ns)]

    def _never(self, dropped: dict[str, str]) -> Iterator[str]:
        """Say of each sentence that a pose needs and that was never good, whether it comes at all."""
        for name, fields in self._fields.items():
            if name not in self._talker_times and not set(fields) <= OPTIONAL:
                comes = f"comes {dropped[name]}" if name in dropped else "has never come"
                yield f"{name} ({self.expects()[name]}) {comes}"


def _two_talkers(name: str, times: dict[str, int], now_ns: int) -> str:
    """Return a text that a sentence comes of more than one talker, by when each was received last; "" where it does
    not."""
    talkers = sorted(talker for talker, t_ns in times.items() if now_ns - t_ns <= TALKER_NS)
    if len(talkers) < 2:
        return ""
    several = f"{name} comes from several talkers, {' and '.join(talkers)}"
    return f"{several}: name one in nav.nmea, such as {talkers[0]}{name}"


def _parts(settings: NmeaSettings) -> dict[str, str]:
    """Return the sentence of each part of a pose."""
    named = {part: getattr(settings, part) for part in NMEA_CHOICES}
    return {part: name for part, name in named.items() if name is not None}


def _fields(parts: dict[str, str]) -> dict[str, tuple[str, ...]]:
    """Return the pose fields of each sentence by name; deviations of the angles where all are in one."""
    fields: dict[str, tuple[str, ...]] = {}
    for part, named in parts.items():
        name = TALKER.sub("", named)
        fields[name] = fields.get(name, ()) + _fields_of(part, name)
    if parts["attitude"] == parts["heading"] == sentence.PASHR:
        fields[sentence.PASHR] += ATTITUDE_SIGMAS[0]
    return fields


def _fields_of(part: str, name: str) -> tuple[str, ...]:
    """Return the pose fields of a part that a sentence carries."""
    return FIELDS.get(part, BODY if name == "BS" else OVER_GROUND)
