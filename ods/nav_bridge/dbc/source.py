"""A navigation system whose frames a DBC file describes. It is only listened to."""

from collections.abc import Iterator
from itertools import combinations

from ods.base.clock import NS
from ods.base.errors import OdsError
from ods.messages import Pose
from ods.nav_bridge.can.frame import EXTENDED_MASK, CanId, Frame
from ods.nav_bridge.can.source import CanSource
from ods.nav_bridge.clocks.ins_clock import InsClock
from ods.nav_bridge.dbc.epoch import DbcEpochAssembler
from ods.nav_bridge.dbc.file import DbcError
from ods.nav_bridge.dbc.shared_number import SharedNumberAssembler
from ods.nav_bridge.dbc.signal_map import SENDER_MASK, DbcMessage, load_dbc_map
from ods.nav_bridge.held import HeldSlot, HeldValues
from ods.nav_bridge.pose_fields import PoseMaker
from ods.nav_bridge.settings import DbcSettings, HeldSettings, NavSettings
from ods.nav_bridge.source import SourceHost

SENDER_NS = 10 * NS
"""Time without a frame after which a sender counts as gone, ns."""


class DbcSource(CanSource):
    """One INS by its DBC file and a signal map.

    Counts `frame_twin` (a mapped number with the other kind of identifier), `frame_short`, `frame_not_finite`,
    `frame_other_sender` (of J1939, a second one), `epoch_invalid` (a status that must hold does not, or a signal
    reports no measurement), and `epoch_aged` (something held is too old).
    """

    def __init__(self, nav: NavSettings, settings: DbcSettings, host: SourceHost) -> None:
        """Read the DBC file and resolve the map. Raises DbcError."""
        super().__init__(nav, host.now_ns)
        counters = host.counters
        self._file = settings.file
        self._window_ns = round(settings.window_s * NS)
        self._start_ns = host.now_ns
        self._counters = counters
        self._map = load_dbc_map(settings)
        try:
            self._maker = PoseMaker(settings.signals, host.frame, nav.limits, nav.sigma, host.utc, counters)
        except OdsError as error:
            raise DbcError(f"{settings.file}: nav.dbc.signals: {error}") from error
        clock, jump_ns = self._map.clock, round(nav.clock_jump_s * NS)
        self._clock = InsClock(jump_ns, counters, clock.wraps_at, clock.tick_ns) if clock else None
        kind = SharedNumberAssembler if self._map.shares_number else DbcEpochAssembler
        self._assembler = kind(self._map, self._window_ns, self._clock, counters)
        self._slots = {
            can_id: _slot(message, message.hold)
            for can_id, message in self._map.messages.items()
            if message.hold is not None
        }
        self._held = HeldValues(self._slots.values())
        self._received_ns: dict[CanId, int] = {}
        self._unmet: dict[CanId, list[str]] = {}
        """What each message says is not valid, or not there."""
        self._groups = [can_id for can_id in self._map.messages if can_id.mask != EXTENDED_MASK]
        self._senders: dict[CanId, tuple[int, int]] = {}
        """Who sends each group, and when it last did;"""
        self._others: dict[CanId, tuple[int, int]] = {}
        """who else does, likewise."""

    @property
    def ids(self) -> frozenset[CanId]:
        """Those of the mapped messages."""
        return frozenset(self._map.messages)

    def expects(self) -> dict[str, str]:
        """Return the mapped messages by name."""
        return {str(can_id): message.layout.name for can_id, message in self._map.messages.items()}

    def objections(self) -> list[str]:
        """Return a text for each signal that is two parts of a pose, as after a line was copied."""
        return [
            f"nav.dbc.signals.{other.field}: is {message.layout.name}.{one.signal}, as {one.field} is"
            for message in self._map.messages.values()
            for one, other in combinations(message.readings, 2)
            if one.signal == other.signal and one.field != other.field and not _is_sigma(one.field, other.field)
        ]

    @property
    def late_ns(self) -> int:
        """How late the newest epoch was, 0 without a clock."""
        return self._clock.late_ns if self._clock else 0

    def name_of(self, item: Frame) -> str:
        """Return the frame's identifier, or that of its group."""
        can_id = self._id_of(item)
        return super().name_of(item) if can_id is None else str(can_id)

    def _id_of(self, item: Frame) -> CanId | None:
        """Return the mapped identifier that a frame has, None where there is none."""
        exact = CanId(item.can_id, item.extended)
        if exact in self._map.messages:
            return exact
        return next((group for group in self._groups if group.matches(item.can_id, item.extended)), None)

    def _is_another_senders(self, can_id: CanId, item: Frame) -> bool:
        """Return whether a group comes of a second sender: two measure, or stand, otherwise."""
        if can_id.mask & SENDER_MASK:
            return False
        sender = item.can_id & SENDER_MASK
        first, received_ns = self._senders.get(can_id, (sender, item.t_ns))
        if first == sender or item.t_ns - received_ns > SENDER_NS:
            self._senders[can_id] = sender, item.t_ns
            return False
        self._others[can_id] = sender, item.t_ns
        return True

    def _take(self, item: Frame) -> Pose | None:
        can_id = self._id_of(item)
        message = None if can_id is None else self._map.messages[can_id]
        if can_id is None or message is None:
            self._counters["frame_twin"] += CanId(item.can_id, not item.extended) in self._map.messages
            return None
        if len(item.data) < message.layout.length:
            self._counters["frame_short"] += 1
            return None
        if self._is_another_senders(can_id, item):
            self._counters["frame_other_sender"] += 1
            return None
        counts = message.counts(item.data)
        if counts is None:
            self._counters["frame_not_finite"] += 1
            return None
        self._received_ns[can_id] = item.t_ns
        unmet = [
            f"the INS says that its {condition.says} is not valid"
            for condition in message.conditions
            if not condition.met(counts[condition.signal])
        ] + message.absent(counts)
        if message.optional and unmet:
            return None
        self._unmet[can_id] = unmet
        if message.hold is not None and not unmet:
            values: dict[str, float] = {}
            message.add_to(values, counts)
            self._slots[can_id].take(values, item.t_ns)
        return self._pose(message, counts, item.t_ns) if message.in_epoch else None

    def _pose(self, message: DbcMessage, counts: dict[str, float], t_ns: int) -> Pose | None:
        epoch = self._assembler.take(message, counts, t_ns)
        if epoch is None:
            return None
        if any(self._unmet.values()) or self._status_missing(t_ns):
            self._counters["epoch_invalid"] += 1
            return None
        ages = self._held.add_to(epoch.values, epoch.t_ns)
        if ages is None:
            self._counters["epoch_aged"] += 1
            return None
        return self._maker.make(epoch.values, epoch.t_ns, t_ns, ages)

    def _status_missing(self, now_ns: int) -> bool:
        """Return whether a status that must hold is unknown or too old."""
        return any(
            now_ns - self._received_ns.get(message.can_id, -item.holds_ns) > item.holds_ns
            for message in self._map.messages.values()
            for item in message.conditions
            if not message.optional
        )

    def _complaints(self, now_ns: int) -> list[str]:
        silent = [message for message in self._map.messages.values() if self._is_silent(message, now_ns)]
        if len(silent) == len(self._map.messages) and not self._received_ns:
            return [f"none of the {len(silent)} messages mapped from {self._file.name} has come"]
        not_valid = [says for unmet in self._unmet.values() for says in unmet]
        dropped = [self._maker.disbelief] if self._maker.disbelief else []
        return [
            *dropped,
            *not_valid,
            *(self._silence(message, now_ns) for message in silent),
            *self._two_senders(now_ns),
            *self._held.too_old(now_ns),
            *self._broken(now_ns, silent),
        ]

    def _two_senders(self, now_ns: int) -> Iterator[str]:
        for can_id, (other, received_ns) in self._others.items():
            if now_ns - received_ns < SENDER_NS:
                name, first = self._map.messages[can_id].layout.name, self._senders[can_id][0]
                yield f"{name} is sent by 0x{first:02X} and 0x{other:02X}: choose one with nav.dbc.source_address"

    def _is_silent(self, message: DbcMessage, now_ns: int) -> bool:
        if message.optional:
            return False
        received_ns = self._received_ns.get(message.can_id)
        limit_ns = self._stale_ns
        if received_ns is not None and message.hold is not None:
            return False  # its slot reports it
        if received_ns is not None and not message.in_epoch:
            limit_ns = min(item.holds_ns for item in message.conditions)
        return now_ns - (self._start_ns if received_ns is None else received_ns) > limit_ns

    def _silence(self, message: DbcMessage, now_ns: int) -> str:
        received_ns = self._received_ns.get(message.can_id)
        if received_ns is None:
            return f"{message.label} has never come"
        return f"{message.label} has not come for {(now_ns - received_ns) / NS:.1f} s"

    def _broken(self, now_ns: int, silent: list[DbcMessage]) -> Iterator[str]:
        """Yield why epochs do not become poses though all their messages come."""
        if now_ns - self._pose_ns > self._stale_ns and not silent:
            yield from self._assembler.objections()
        period_ns = self._assembler.period.ns
        if self._map.clock is not None and 0 < period_ns < self._window_ns:
            yield f"epochs come every {1e3 * period_ns / NS:.1f} ms: nav.dbc.window_s must be shorter"


def _slot(message: DbcMessage, settings: HeldSettings) -> HeldSlot:
    name = message.layout.name
    return HeldSlot(message.label, f"nav.dbc.held.{name}", settings, {item.field for item in message.readings})


def _is_sigma(*fields: str) -> bool:
    """Return whether all are standard deviations, of which several may be one signal."""
    return all(field.startswith("sigma_") for field in fields)
