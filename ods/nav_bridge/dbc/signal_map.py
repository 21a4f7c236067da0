"""The signal map: which signals of a DBC file make which pose fields, resolved once at start."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TypeVar

from cantools.database.can import Message, Signal

from ods.base.choices import meant, none_of
from ods.base.clock import NS
from ods.nav_bridge.can.frame import MAX_DATA_BYTES, CanId
from ods.nav_bridge.dbc.file import DbcError, DbcText
from ods.nav_bridge.dbc.no_value import ReservedValues, no_value_of
from ods.nav_bridge.dbc.units import conversion
from ods.nav_bridge.pose_fields import OPTIONAL, UNITS
from ods.nav_bridge.settings import (
    DbcSettings,
    HeldSettings,
    PartSettings,
    SignalSettings,
    TimeSettings,
    ValiditySettings,
)

SettingsT = TypeVar("SettingsT", PartSettings, SignalSettings, TimeSettings)
LEAST_COUNTS = 2
"""A clock that wraps sooner shows nothing."""
J1939 = "j1939"
NO_SENDER = 0xFE
"""Stands in J1939's files where the sender's address is."""
FIRST_BROADCAST = 240
"""PDU format from which on the next byte belongs to the parameter group [SAE J1939-21]; below it is the receiver."""
BROADCAST_MASK, ADDRESSED_MASK, SENDER_MASK = 0x03FFFF00, 0x03FF0000, 0xFF


@dataclass(frozen=True)
class Reading:
    """One pose field, or a part of it, in a message: scale x raw count + offset, in the unit of `pose_fields.UNITS`."""

    field: str
    signal: str
    scale: float
    offset: float
    no_value: ReservedValues


@dataclass(frozen=True)
class Clock:
    """The INS's clock in a message, in raw counts."""

    signal: str
    tick_ns: float
    wraps_at: float | None
    """Counts; None: it never starts again from 0."""


@dataclass(frozen=True)
class Condition:
    """A status that must hold."""

    signal: str
    mask: int | None
    accept: frozenset[int]
    says: str
    holds_ns: int

    def met(self, count: float) -> bool:
        """Return whether the raw count of the signal is good."""
        value = int(count)
        return (value if self.mask is None else value & self.mask) in self.accept


@dataclass
class DbcMessage:
    """One message of the map."""

    layout: Message
    in_epoch: bool = False
    """It is one of the messages of an instant."""
    sequence: str | None = None
    """Signal that all messages of an instant share."""
    hold: HeldSettings | None = None
    """It comes at a rate of its own."""
    sender: int | None = None
    """Of a J1939 message: the one that is listened to; None: any."""
    readings: list[Reading] = field(default_factory=list)
    clock: Clock | None = None
    conditions: list[Condition] = field(default_factory=list)

    @cached_property
    def can_id(self) -> CanId:
        """Identifier; the DBC distinguishes standard and extended ones. Of J1939 priority and sender do not count."""
        number = self.layout.frame_id
        if not self.is_j1939:
            return CanId(number, self.layout.is_extended_frame)
        mask = BROADCAST_MASK if number >> 16 & 0xFF >= FIRST_BROADCAST else ADDRESSED_MASK
        if self.sender is None:
            return CanId(number & mask, True, mask)
        return CanId(number & mask | self.sender, True, mask | SENDER_MASK)

    @cached_property
    def is_j1939(self) -> bool:
        """The file says so, or leaves the sender open, or the settings name one."""
        layout = self.layout
        addressed = layout.protocol == J1939 or layout.frame_id & SENDER_MASK == NO_SENDER or self.sender is not None
        return layout.is_extended_frame and addressed

    def absent(self, counts: Mapping[str, float]) -> list[str]:
        """Return a text for each signal without a measurement, with what it reports instead."""
        found = ((item.signal, item.no_value.why(counts[item.signal])) for item in self.readings)
        return [f"{self.layout.name}.{signal} is {why}" for signal, why in found if why]

    @cached_property
    def optional(self) -> bool:
        """It comes at a rate of its own, and a pose is as good without it."""
        return self.hold is not None and OPTIONAL.issuperset(item.field for item in self.readings)

    @property
    def label(self) -> str:
        """What people call it: name and identifier."""
        return f"{self.layout.name} (0x{self.layout.frame_id:X})"

    def counts(self, data: bytes) -> dict[str, float] | None:
        """Return the raw counts of all signals, None when one that is needed is not finite; `data` is long enough."""
        counts: dict[str, float] = self.layout.decode(data, decode_choices=False, scaling=False)  # type: ignore[assignment]
        return counts if all(math.isfinite(counts[name]) for name in self._needed) else None

    def add_to(self, values: dict[str, float], counts: Mapping[str, float]) -> None:
        """Add the pose fields, or their parts, to those of the same instant."""
        for item in self.readings:
            values[item.field] = values.get(item.field, 0.0) + item.scale * counts[item.signal] + item.offset

    @cached_property
    def _needed(self) -> tuple[str, ...]:
        clock = [self.clock.signal] if self.clock is not None else []
        shared = [self.sequence] if self.sequence is not None else []
        readings = (item.signal for item in self.readings if self.optional or item.field not in OPTIONAL)
        return (*readings, *(item.signal for item in self.conditions), *clock, *shared)


@dataclass(frozen=True)
class DbcMap:
    """What is wanted of a DBC file."""

    messages: Mapping[CanId, DbcMessage]
    epoch: tuple[DbcMessage, ...]
    """Those of one instant, in the order of sending where that is known."""
    order_specified: bool
    shares_number: bool
    """All of `epoch` have a `sequence`."""
    clock: Clock | None


def load_dbc_map(settings: DbcSettings) -> DbcMap:
    """Read the DBC file and resolve the map. Raises DbcError."""
    resolver = _Resolver(settings.file, settings.source_address)
    for name, mapped in settings.signals.items():
        resolver.add_field(name, _as_table(mapped, SignalSettings))
    clock = None
    if settings.time is not None:
        clock = resolver.add_clock(_as_table(settings.time, TimeSettings))
    resolver.hold(settings.held)
    epoch = resolver.order(settings.epoch)
    resolver.add_sequence(settings.sequence, epoch)
    for number, validity in enumerate(settings.valid):
        resolver.add_condition(f"nav.dbc.valid[{number}]", validity)
    messages = resolver.messages.values()
    by_id = {message.can_id: message for message in messages}
    if len(by_id) < len(messages):
        raise DbcError(f"{settings.file}: two of the mapped messages have the same identifier")
    return DbcMap(by_id, epoch, settings.epoch is not None, bool(settings.sequence), clock)


def _as_table(mapped: str | SettingsT, kind: type[SettingsT]) -> SettingsT:
    return kind(signal=mapped) if isinstance(mapped, str) else mapped


class _Resolver:
    """Looks names of the configuration up in the DBC file and gathers what is wanted of each message."""

    def __init__(self, file: Path, sender: int | None) -> None:
        self.messages: dict[str, DbcMessage] = {}
        self._file, self._sender = file, sender
        self._text = DbcText(file)

    def add_field(self, name: str, mapped: SignalSettings) -> None:
        key = f"nav.dbc.signals.{name}"
        if name not in UNITS:
            raise self._error(key, f"not a pose field: {none_of(name, UNITS)}")
        self._add_part(key, name, mapped, mapped.offset)
        if mapped.plus is not None:
            self._add_part(f"{key}.plus", name, _as_table(mapped.plus, PartSettings), 0.0)

    def _add_part(self, key: str, name: str, mapped: PartSettings, offset: float) -> None:
        message, signal = self._find(key, mapped.signal)
        factor = mapped.factor or self._unit(key, mapped.unit, signal, UNITS[name])
        factor *= mapped.sign
        scale, offset = factor * float(signal.scale), factor * float(signal.offset) + offset
        no_value = no_value_of(
            signal, extended=message.layout.is_extended_frame, j1939=message.is_j1939, any_value=mapped.any_value
        )
        message.readings.append(Reading(name, signal.name, scale, offset, no_value))

    def add_clock(self, mapped: TimeSettings) -> Clock:
        key = "nav.dbc.time"
        message, signal = self._find(key, mapped.signal)
        seconds = float(signal.scale) * self._unit(key, mapped.unit, signal, "s")
        wraps_at: float | None = None if signal.is_float else 1 << signal.length
        if mapped.wraps_at is not None:
            wraps_at = mapped.wraps_at / float(signal.scale)
            wraps_at = round(wraps_at) if not signal.is_float else wraps_at
            if wraps_at < LEAST_COUNTS:
                raise self._error(key, f"wraps_at: {mapped.wraps_at:g} is hardly more than the signal's step")
        message.clock = Clock(signal.name, seconds * NS, wraps_at)
        return message.clock

    def add_condition(self, key: str, validity: ValiditySettings) -> None:
        message, signal = self._find(key, validity.signal)
        if signal.is_float or signal.is_signed:
            raise self._error(key, f"{validity.signal} is not an unsigned integer")
        accept = [validity.mask or 0] if validity.accept is None else validity.accept
        for name, numbers in (("mask", [validity.mask or 0]), ("accept", accept)):
            if max(numbers) >> signal.length:
                raise self._error(key, f"{name}: {validity.signal} has {signal.length} bits only")
        holds_ns = round(validity.holds_s * NS)
        message.conditions.append(Condition(signal.name, validity.mask, frozenset(accept), validity.says, holds_ns))

    def order(self, names: Iterable[str] | None) -> tuple[DbcMessage, ...]:
        """Return the messages of an epoch, those mapped and not held, in the order of sending where that is known."""
        carrying = {name: message for name, message in self.messages.items() if message.hold is None}
        names = list(carrying if names is None else names)
        if len(set(names)) < len(names):
            raise self._error("nav.dbc.epoch", "lists a message twice")
        missing = set(carrying) - set(names)
        if missing:
            raise self._error("nav.dbc.epoch", f"must also list {', '.join(sorted(missing))}, which carries a signal")
        epoch = tuple(self._message("nav.dbc.epoch", name) for name in names)
        if any(message.hold is not None for message in epoch):
            raise self._error("nav.dbc.epoch", "lists a message that nav.dbc.held also lists")
        for message in epoch:
            message.in_epoch = True
        return epoch

    def hold(self, held: Mapping[str, HeldSettings]) -> None:
        """Take messages out of the epoch."""
        for name, settings in held.items():
            key = f"nav.dbc.held.{name}"
            message = self._message(key, name)
            if not message.readings or message.clock is not None:
                carries = (
                    "carries nav.dbc.time" if message.clock is not None else "carries no signal of nav.dbc.signals"
                )
                raise self._error(key, f"cannot be held, as it {carries}")
            message.hold = settings
        homes: dict[str, list[DbcMessage]] = {}
        for message in self.messages.values():
            for field_name in dict.fromkeys(item.field for item in message.readings):
                homes.setdefault(field_name, []).append(message)
        for field_name, messages in homes.items():
            if len(messages) > 1 and any(message.hold is not None for message in messages):
                raise self._error(
                    f"nav.dbc.signals.{field_name}",
                    "its two signals belong to one instant only if neither message is held",
                )
        if held and all(message.hold is not None for message in self.messages.values()):
            raise self._error("nav.dbc.held", "at least one message must not be held: its arrival triggers a pose")

    def add_sequence(self, names: Iterable[str], epoch: tuple[DbcMessage, ...]) -> None:
        key = "nav.dbc.sequence"
        for name in names:
            message, signal = self._find(key, name)
            if not message.in_epoch:
                raise self._error(key, f"{message.label} carries no signal of an epoch")
            message.sequence = signal.name
        lacking = [message.layout.name for message in epoch if message.sequence is None]
        if names and lacking:
            raise self._error(key, f"must have a signal of {', '.join(lacking)} too, as it carries a signal")

    def _find(self, key: str, name: str) -> tuple[DbcMessage, Signal]:
        """Return message and signal of the text MESSAGE.SIGNAL."""
        message_name, dot, signal_name = name.partition(".")
        if not dot:
            raise self._error(key, f"must be MESSAGE.SIGNAL, got {name!r}")
        message = self._message(key, message_name)
        for signal in message.layout.signals:
            if signal.name == signal_name:
                if signal.is_multiplexer or signal.multiplexer_ids:
                    raise self._error(key, f"{name} is multiplexed, which is not supported")
                return message, signal
        there = [signal.name for signal in message.layout.signals]
        raise self._error(key, f"message {message_name} has no signal {signal_name!r}{meant(signal_name, there)}")

    def _message(self, key: str, name: str) -> DbcMessage:
        if name in self.messages:
            return self.messages[name]
        if name not in self._text.names:
            raise self._error(key, f"no message {name!r} in the DBC{meant(name, self._text.names)}")
        layout = self._text.message(name, key)
        if layout.is_multiplexed() or layout.is_container:
            raise self._error(key, f"message {name} is multiplexed, which is not supported")
        if layout.length > MAX_DATA_BYTES:
            raise self._error(key, f"message {name} has {layout.length} bytes, more than a CAN frame holds")
        self.messages[name] = DbcMessage(layout, sender=self._sender)
        return self.messages[name]

    def _unit(self, key: str, unit: str | None, signal: Signal, wanted: str) -> float:
        try:
            return conversion(unit if unit is not None else signal.unit or "", wanted)
        except ValueError as error:
            if unit is not None:
                raise self._error(f"{key}.unit", str(error)) from error
            advice = "give unit" if wanted == "s" else "set unit or factor"
            raise self._error(key, f"the DBC's unit {error}; {advice}") from error

    def _error(self, key: str, text: str) -> DbcError:
        return DbcError(f"{self._file}: {key}: {text}")
