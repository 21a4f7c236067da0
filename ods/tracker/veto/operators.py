"""The socket for operators' requests: on board, by CURVE, and for the keys of the list of operators only.

The author of a request is the name of the key by which it came, nothing that its sender says. Without a list of
operators there is no socket.
"""

from collections import Counter
from pathlib import Path
from typing import NamedTuple

import zmq

from ods.messages import VetoAnswer, VetoOrder, VetoRequest
from ods.runtime.bus import BusError, Responder
from ods.runtime.keys.admission import Admission
from ods.runtime.keys.key_files import KeyFileError
from ods.runtime.keys.key_folder import OPERATORS, KeyFolder
from ods.runtime.keys.key_list import KeyList

NAME = "veto-requests"


class Asked(NamedTuple):
    """A request, whose it is, and whom to answer."""

    peer: list[bytes]
    request: VetoRequest
    author: str


class Operators:
    """Takes requests. Never waits. `counters`: refused_operators, bad_veto-requests."""

    def __init__(self, keys: Path | None, run_dir: Path) -> None:
        """`keys`: the folder of keys; None: there are no operators."""
        self.counters: Counter[str] = Counter()
        self.problem = ""
        """Why no operator can ask, though there is a list."""
        self._run_dir = run_dir
        self._folder = None if keys is None else KeyFolder(keys, OPERATORS)
        self._listed = None if self._folder is None else KeyList(self._folder)
        self._context: zmq.Context[zmq.Socket[bytes]] | None = None
        self._admission: Admission | None = None
        self._responder: Responder | None = None

    def asked(self) -> list[Asked]:
        """Let in who has come, and return what operators ask. A key that was taken from the list asks in vain."""
        if self._listed is None:
            return []
        if self._listed.follow() or self._responder is None:
            self._open()
        names = self._listed.names
        if self._responder is None or self._admission is None:
            return []
        self.counters["refused_operators"] += sum(not one.name for one in self._admission.answer(names))
        found = []
        for peer, request, key in self._responder.receive_keyed():
            if key in names:
                found.append(Asked(peer, request, names[key]))
            else:
                self.counters["refused_operators"] += 1
                self._responder.answer(peer, VetoAnswer(ok=False, reason="this key is no longer an operator's"))
        return found

    def answer(self, asked: Asked, answer: VetoAnswer) -> None:
        """Answer a request."""
        if self._responder is not None:
            self._responder.answer(asked.peer, answer)

    def _open(self) -> None:
        """Bind where there is a list of operators, and stay reachable."""
        if self._folder is None or self._listed is None:
            return
        problem = self._listed.problem
        try:
            if self._responder is not None:
                self._responder.restore()
            elif self._listed.names:
                pair = self._folder.server()
                self._context = self._context or zmq.Context(1)
                self._admission = self._admission or Admission(self._context)
                self._responder = Responder(self._context, self._run_dir, NAME, pair)
                self._responder.counters = self.counters
        except (KeyFileError, BusError) as error:
            problem = str(error)
        self.problem = f"operators cannot veto: {problem}" if problem else ""

    def close(self) -> None:
        """Close the socket."""
        for each in (self._responder, self._admission):
            if each is not None:
                each.close()
        self._responder = self._admission = None
        if self._context is not None:
            self._context.term()


def in_words(order: VetoOrder) -> str:
    """Return an order as a line of the log."""
    request = order.request
    meant = f"obstacle {request.id}" if request.id is not None else f"veto {request.number}"
    if request.region is not None:
        meant = "a region"
    wanted = f"{order.author}: {request.do} {meant}"
    if request.for_s is not None:
        wanted += f" for {request.for_s:g} s"
    outcome = f"; refused: {order.refused}" if order.refused else ""
    return f"veto by {wanted} ({request.reason!r}){outcome}"
