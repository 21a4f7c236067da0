"""The record process: all messages to files. Its loop only receives messages; a separate thread writes them."""

import os
import signal

from ods.base import clock
from ods.recording.errors import RecordingError
from ods.recording.inbox import Inbox, Received
from ods.recording.recording_writer import RecordingWriter
from ods.recording.settings import RecordConfig
from ods.runtime.service import Service, Worker

STALLED_NS = 3 * clock.NS
"""Duration of a write from which on the disk is reported as slow, s."""
AT_THE_END_S = 1.2
"""For the disk to take what waits; the supervisor gives 1.5 s."""


class RecordWorker(Worker[RecordConfig]):
    """Passes received messages to the writing thread."""

    def __init__(self, service: Service, settings: RecordConfig) -> None:
        super().__init__(service, settings)
        self._inbox = Inbox(round(settings.record.queue_mb * 1e6))
        self._ending = False
        self.scribe = RecordingWriter(settings, self._inbox, lambda: self._ending)
        self._round: list[Received] = []
        seconds = settings.seconds
        self._end_ns = None if seconds is None else clock.monotonic_ns() + round(seconds * clock.NS)

    def start(self) -> None:
        """Open the recording."""
        self.scribe.start()

    def handle(self, topic: str, message: bytes) -> None:
        """Take one message, as it was on the wire."""
        self._round.append(Received(topic, clock.monotonic_ns(), message))

    def tick(self) -> None:
        """Hand over what came in this round."""
        if self._round:
            self._inbox.put(self._round)
            self._round = []
        if self._end_ns is not None and clock.monotonic_ns() >= self._end_ns:
            os.kill(os.getpid(), signal.SIGTERM)

    def ready(self) -> bool:
        """Return whether there is a folder to write to."""
        return self.scribe.folder is not None

    def problems(self) -> list[str]:
        """Return why nothing is written, and that messages were lost."""
        counters = self.service.counters
        counters.update({name: count - counters[name] for name, count in dict(self.scribe.counters).items()})
        counters["dropped_messages"] = self.scribe.counters["dropped_messages"] + self._inbox.dropped
        said = self.scribe.problem
        since_ns = self.scribe.busy_since_ns
        if not said and since_ns and clock.monotonic_ns() - since_ns > STALLED_NS:
            said = f"the disk has not responded for {(clock.monotonic_ns() - since_ns) / clock.NS:.0f} s: not recorded"
        if said and counters["dropped_messages"]:
            said += f"; {counters['dropped_messages']} messages lost"
        return [said] if said else []

    def stop(self) -> None:
        """Write what waits, and complete the file, as far as the disk lets us. Raises RecordingError: not at all."""
        self._inbox.put(self._round)
        self._ending = True
        self._inbox.close()
        self.scribe.join(AT_THE_END_S)
        if self.scribe.problem:
            raise RecordingError("; ".join(self.problems()))
