"""Operators' requests to the tracker over real ZeroMQ: with the right key, a wrong one, none, one that was revoked."""

import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest
import zmq

from ods.client import Veto, VetoError, Vetoes, VetoRegion, VetoRequest
from ods.messages import VetoAnswer
from ods.runtime import bus
from ods.runtime.keys.curve import connect_by_key
from ods.runtime.keys.key_files import ClientKey, KeyPair, read_client_key
from ods.runtime.keys.key_folder import CLIENTS, OPERATORS, KeyFolder
from ods.tracker.veto.operators import Operators
from tests.tracker.played import Chain, good, played

LIST = VetoRequest(do="list")
REGION = VetoRegion(centre_ne=(40.0, 0.0), radius_m=10.0)


class Desk:
    """The tracker's socket, which answers with the author's name."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.keys = KeyFolder(folder / "keys", OPERATORS)
        self._operators = Operators(folder / "keys", folder)
        self.authors: list[str] = []
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def _serve(self) -> None:
        while not self._ended.wait(0.002):
            for asked in self._operators.asked():
                self.authors.append(asked.author)
                self._operators.answer(asked, VetoAnswer(ok=True, reason=""))

    def client(self, name: str, timeout_s: float = 30.0) -> Vetoes:
        return Vetoes(self.folder, self.keys.secret_of(name), timeout_s)

    @property
    def counters(self) -> dict[str, int]:
        return dict(self._operators.counters)

    def close(self) -> None:
        self._ended.set()
        self._thread.join()
        self._operators.close()


@pytest.fixture
def desk() -> Iterator[Desk]:
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:
        made = Desk(Path(folder))
        made.keys.make("anna")
        try:
            yield made
        finally:
            made.close()


def socket_of(desk: Desk, context: "zmq.Context[zmq.Socket[bytes]]", key: ClientKey | None) -> "zmq.Socket[bytes]":
    made = context.socket(zmq.REQ)
    made.setsockopt(zmq.LINGER, 0)
    if key is not None:
        connect_by_key(made, key)
    made.connect(bus.endpoint(desk.folder, "veto-requests"))
    return made


def test_the_author_is_the_name_of_the_key(desk: Desk) -> None:
    desk.keys.make("ben")
    for name in ("anna", "ben"):
        client = desk.client(name)
        assert client.ask(LIST) == []
        client.close()
    assert desk.authors == ["anna", "ben"]


def test_who_has_no_key_a_strangers_or_only_a_listeners_is_not_received(desk: Desk) -> None:
    anna = read_client_key(desk.keys.secret_of("anna"))
    listeners = KeyFolder(desk.keys.path, CLIENTS)
    listeners.make("planner")
    public, secret = zmq.curve_keypair()
    wrong = {
        "none": None,
        "a stranger's": ClientKey(KeyPair(public.decode(), secret.decode()), anna.server),
        "for another vehicle": ClientKey(anna.own, zmq.curve_keypair()[0].decode()),
        "a listener's": read_client_key(listeners.secret_of("planner")),
    }
    client = desk.client("anna")
    client.ask(LIST)  # the socket is there
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    sockets = {name: socket_of(desk, context, key) for name, key in wrong.items()}
    for each in sockets.values():
        each.send(msgspec.msgpack.encode(LIST), zmq.DONTWAIT) if each.poll(100, zmq.POLLOUT) else None
    for _ in range(20):
        client.ask(LIST)
    assert {name: each.poll(0) for name, each in sockets.items()} == dict.fromkeys(wrong, 0)
    assert set(desk.authors) == {"anna"}
    assert desk.counters["refused_operators"] >= 2
    context.destroy(linger=0)
    client.close()


def test_a_revoked_key_asks_in_vain_though_its_connection_is_open(desk: Desk) -> None:
    client = desk.client("anna")
    client.ask(LIST)
    desk.keys.revoke("anna")
    with pytest.raises(VetoError, match="no longer an operator's"):
        client.ask(LIST)
    client.close()


def test_a_malformed_request_is_refused_in_one_line_and_counted(desk: Desk) -> None:
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    client = socket_of(desk, context, read_client_key(desk.keys.secret_of("anna")))
    for wrong in (b"garbage", msgspec.msgpack.encode({"do": "ignore", "id": 3, "reason": "r", "for_s": -1.0})):
        client.send(wrong)
        answer = msgspec.msgpack.decode(client.recv(), type=VetoAnswer)
        assert not answer.ok
        assert answer.reason.startswith("bad request: ")
        assert "\n" not in answer.reason
    assert desk.counters["bad_veto-requests"] == 2
    assert desk.authors == []
    context.destroy(linger=0)


def test_without_a_list_of_operators_there_is_no_socket(tmp_path: Path) -> None:
    KeyFolder(tmp_path / "keys", CLIENTS).make("planner")
    operators = Operators(tmp_path / "keys", tmp_path)
    assert operators.asked() == []
    assert operators.problem == ""
    assert not (tmp_path / "veto-requests.sock").exists()
    assert Operators(None, tmp_path).asked() == []


@pytest.mark.slow
def test_a_tracker_is_reported_and_says_so_in_its_lists_and_goes_on_after_a_kill() -> None:
    with played() as chain, zmq.Context() as context:
        keys = KeyFolder(chain.folder / "keys", OPERATORS)
        keys.make("anna")
        chain.until(lambda reported: good(reported) and len(reported.obstacles) == 2)
        near, far = sorted(chain.lists[-1].obstacles, key=lambda each: each.position_ned[0])
        with bus.Subscriber(context, chain.folder, ["veto-orders"]) as orders:
            held = _asked(chain, VetoRequest(do="ignore", id=near.id, reason="our buoy", for_s=600.0))
            assert [(each.id, each.author) for each in held] == [(near.id, "anna")]
            reported = chain.until(lambda each: any(one.ignored_by >= 0 for one in each.obstacles))
            assert {one.id: one.ignored_by for one in reported.obstacles} == {near.id: 0, far.id: -1}
            assert reported.valid
            assert [(each.reason, each.until_ns) for each in reported.vetoes] == [("our buoy", held[0].until_ns)]
            (order,) = [message for _, message in orders.receive(10.0)[0]]
            assert (order.author, order.request.id, order.refused) == ("anna", near.id, "")

        chain.kill()
        seen = len(chain.lists)
        chain.start()
        after = chain.until(lambda _: len(chain.lists) > seen)
        assert [(each.id, each.until_ns) for each in after.vetoes] == [(near.id, held[0].until_ns)]

        _asked(chain, VetoRequest(do="forget", id=far.id, reason="a ghost"))
        chain.until(lambda each: {one.id: one.state for one in each.obstacles}.get(far.id) == "terminated")
        chain.until(lambda each: any(one.id not in (near.id, far.id) for one in each.obstacles))  # it is seen again

        with pytest.raises(VetoError, match="no obstacle 999"):
            _asked(chain, VetoRequest(do="ignore", id=999, reason="a slip", for_s=5.0))
        _asked(chain, VetoRequest(do="restore", id=near.id, reason="it drifts"))
        _asked(chain, VetoRequest(do="ignore", region=REGION, reason="the pier", for_s=600.0))
        chain.until(lambda each: {one.id: one.ignored_by for one in each.obstacles}.get(near.id) == 1)


def _asked(chain: Chain, request: VetoRequest) -> list[Veto]:
    """Ask while the other processes are played."""
    outcome: list[list[Veto] | VetoError] = []

    def ask() -> None:
        client = Vetoes(chain.folder, chain.folder / "keys" / "anna.secret", 30.0)
        try:
            outcome.append(client.ask(request))
        except VetoError as error:
            outcome.append(error)
        finally:
            client.close()

    asking = threading.Thread(target=ask)
    asking.start()
    chain.until(lambda _: not asking.is_alive())
    asking.join()
    if isinstance(outcome[0], VetoError):
        raise outcome[0]
    return outcome[0]
