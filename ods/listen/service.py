"""The process `listen`: passes topics on to other computers that have a key.

It stands apart from those on board: readers elsewhere, however slow or hostile, cost them neither memory nor time.
"""

import time

import zmq

from ods.listen.settings import ListenConfig
from ods.listen.tap import Tap
from ods.listen.topic_server import TopicServer
from ods.runtime.keys.admission import Admission, Asked
from ods.runtime.keys.key_files import KeyFileError
from ods.runtime.keys.key_folder import KeyFolder
from ods.runtime.keys.key_list import KeyList
from ods.runtime.service import Service, StartError, Worker


class ListenWorker(Worker[ListenConfig]):
    """Passes topics on, lets clients in by their keys, hangs up when one is revoked.

    Counters: passed_messages, admitted_clients, refused_clients, hang_ups, listen_errors.
    """

    def __init__(self, service: Service, settings: ListenConfig) -> None:
        super().__init__(service, settings)
        if settings.bus.keys is None or not settings.bus.listen:
            raise StartError("bus.listen: missing: set `at` (address) and `topics` (the topics served there)")
        folder = KeyFolder(settings.bus.keys)
        try:
            pair = folder.server()
        except KeyFileError as error:
            raise StartError(f"bus.keys: {error} (`ods keys make` makes keys)") from error
        self._allowed = KeyList(folder)
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context(1)
        self._admission = Admission(self._context)
        self._doors = [TopicServer(self._context, each, pair) for each in settings.bus.listen]
        wanted = frozenset(name for door in self._doors for name in door.topics)
        self._tap = Tap(self._context, service.run_dir, wanted)
        service.subscriber.watch_fd(self._tap.fd)

    def readable(self, fd: int) -> None:
        """Pass on received messages."""
        self._pass_on()

    def tick(self) -> None:
        """Look after the list of keys and the doors.

        Who comes in is let in last: he gets nothing that was held up before.
        """
        self._look_at_keys()
        now_s = time.monotonic()
        for door in self._doors:
            if door.step(now_s):
                self.service.log_once("listen_errors", door.problem)
        self._pass_on()
        for asked in self._admission.answer(self._allowed.names):
            self._note(asked)

    def _look_at_keys(self) -> None:
        """Disconnect listeners that are no longer in the list. An invalid list counts as empty."""
        if not self._allowed.follow():
            return
        for door in self._doors:
            if door.admitted - self._allowed.names.keys():
                door.hang_up()
                self.service.counters["hang_ups"] += 1

    def _pass_on(self) -> None:
        for topic, body in self._tap.receive():
            name = topic.decode()
            for door in self._doors:
                if name in door.topics:
                    self.service.counters["passed_messages"] += door.publish(topic, body)

    def _note(self, asked: Asked) -> None:
        if not asked.name:
            self.service.log_once("refused_clients", f"{asked.address} has no allowed key: {asked.key}")
            return
        self.service.counters["admitted_clients"] += 1
        for door in self._doors:
            if door.domain == asked.domain:
                door.admitted.add(asked.key)

    def problems(self) -> list[str]:
        """Return the topics that cannot be received, and why, a text each."""
        found = [f"bus.listen[{number}].at: {door.problem}" for number, door in enumerate(self._doors) if door.problem]
        problem = self._allowed.problem
        return [*found, *([f"bus.keys: {problem}: no listener is admitted"] if problem else [])]

    def stop(self) -> None:
        """Give the sockets back."""
        self.service.subscriber.unwatch_fd(self._tap.fd)
        self._tap.close()
        for door in self._doors:
            door.close()
        self._admission.close()
        self._context.term()
