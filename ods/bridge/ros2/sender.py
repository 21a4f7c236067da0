"""Writes messages by DDS, and survives changes of interface and nodes."""

from collections.abc import Callable
from typing import Any

from cyclonedds.core import DDSException
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from rosbags.typesys.store import Typestore

from ods.base import clock
from ods.bridge.ros2.dds_types import DdsTypes, type_hash
from ods.bridge.ros2.interface import address_of, configuration
from ods.bridge.ros2.topics import LIFESPAN_S, TopicRow, wanted
from ods.bridge.settings import Ros2Settings
from ods.runtime.port.backoff import Backoff

LOOK_NS = clock.NS
FIRST_S, LONGEST_S = 1.0, 10.0
"""Between attempts to start again, s."""
BLOCKING_MS = 10
"""Longest wait for a node that does not keep up."""
STREAM_DEPTH = 10


class DdsSender:
    """A participant with its writers, made again when the interface was away or got another address.

    `log_once`: counts under a name, and logs the text once. Names: `interface_losses`, `unsent_messages`.
    """

    def __init__(self, settings: Ros2Settings, store: Typestore, log_once: Callable[[str, str], None]) -> None:
        self._settings, self._store, self._log_once = settings, store, log_once
        self._types = DdsTypes(store)
        self._backoff = Backoff(FIRST_S, LONGEST_S)
        self._domain: Domain | None = None
        self._participant: DomainParticipant | None = None
        self._writers: dict[str, tuple[DataWriter[Any], Any]] = {}
        self._address = ""
        self._away = ""
        self._refused = ""
        self._look_ns = 0
        self.nodes = 0
        """Subscriptions to what is sent, when that was looked at last."""

    def look(self, now_ns: int) -> None:
        """Start, if it is time; see whether the interface is still there, and who has subscribed."""
        if now_ns < self._look_ns:
            return
        self._look_ns = now_ns + LOOK_NS
        try:
            address = address_of(self._settings.interface)
            if self._writers and address != self._address:
                raise OSError("the interface's address has changed")
            if not self._writers:
                self._open()
                self._address, self._away = address, ""
                self._backoff.worked()
            self.nodes = sum(len(writer.get_matched_subscriptions()) for writer, _ in self._writers.values())
        except (OSError, DDSException) as error:
            self._away = f"{self._settings.interface}: {error}"
            self._log_once("interface_losses", self._away)
            self.close()
            self._look_ns = now_ns + round(self._backoff.failed() * clock.NS)

    def is_received(self, key: str) -> bool:
        """Return whether a node has subscribed to a topic, or nothing can be sent, which `send` then says."""
        return key not in self._writers or bool(self._writers[key][0].get_matched_subscriptions())

    def send(self, key: str, cdr: bytes) -> bool:
        """Write a message of a topic; return whether it was written."""
        if key not in self._writers:
            self._log_once("unsent_messages", self._away or "DDS has not started")
            return False
        writer, sample = self._writers[key]
        try:
            writer.write(sample(cdr))
        except DDSException as error:
            self._refused = str(error)
            self._log_once("unsent_messages", self._refused)
            return False
        self._refused = ""
        return True

    def problem(self) -> str:
        """Return what is wrong now, in plain words, or ""."""
        if self._away or self._refused:
            return self._away or self._refused
        where = f"domain {self._settings.domain} on {self._settings.interface}"
        return "" if self.nodes else f"no node has subscribed in {where}"

    def _open(self) -> None:
        """Raises DDSException."""
        settings = self._settings
        self._domain = Domain(settings.domain, configuration(settings))
        self._participant = DomainParticipant(settings.domain)
        for row in wanted(settings):
            kind = self._types.of(row.kind)
            topic = Topic(self._participant, f"rt{row.name}", kind)
            self._writers[row.key] = DataWriter(self._participant, topic, qos=self._qos(row)), kind

    def _qos(self, row: TopicRow) -> Qos:
        hashed = Policy.Userdata(f"typehash={type_hash(self._store, row.kind)};".encode())
        if row.quality == "image":
            return Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(1), hashed)
        reliable = Policy.Reliability.Reliable(duration(milliseconds=BLOCKING_MS))
        if row.quality == "stream":
            return Qos(reliable, Policy.History.KeepLast(STREAM_DEPTH), hashed)
        lifespan = Policy.Lifespan(duration(seconds=LIFESPAN_S))
        return Qos(reliable, Policy.Durability.TransientLocal, Policy.History.KeepLast(1), lifespan, hashed)

    def close(self) -> None:
        """Leave the domain: what nodes have of it they then know to be ended."""
        self._writers.clear()
        self._participant = self._domain = None
        self.nodes = 0
