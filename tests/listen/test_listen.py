"""Who receives what: keys that are allowed, named topics, and nothing else; who is revoked or slow is cut."""

import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest
import zmq
from zmq.utils.monitor import recv_monitor_message

from ods.client import Obstacles
from ods.listen import topic_server
from ods.runtime.keys.key_files import ClientKey, KeyPair, read_client_key
from tests.listen.played import PATIENCE_S, Socket, Vehicle, drained, free_port, vehicle

ROOT = Path(__file__).parents[2]


@pytest.fixture
def folder() -> Iterator[Path]:
    with tempfile.TemporaryDirectory(prefix="ods-") as made:
        yield Path(made)


def stranger(server: str) -> ClientKey:
    public, secret = zmq.curve_keypair()
    return ClientKey(KeyPair(public.decode(), secret.decode()), server)


def received(running: Vehicle, client: Socket) -> bool:
    return bool(drained(client))


def test_who_has_a_key_hears_the_named_topics_only(folder: Path) -> None:
    with vehicle(folder, "clearance") as running:
        client, other = running.client(running.key()), running.client(running.key(), "obstacles")
        got: list[tuple[str, int]] = []

        def enough() -> bool:
            got.extend(drained(client))
            return len(got) > 20

        running.until(enough)
        assert {topic for topic, _ in got} == {"clearance"}
        assert drained(other) == []
        numbers = [number for _, number in got]
        assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
        assert running.counters["admitted_clients"] == 2


def test_who_has_no_key_or_a_wrong_one_hears_nothing(folder: Path) -> None:
    with vehicle(folder) as running:
        own = running.key()
        wrong = {
            "none": running.client(None),
            "a stranger's": running.client(stranger(own.server)),
            "for another vehicle": running.client(ClientKey(own.own, zmq.curve_keypair()[0].decode())),
        }
        good = running.client(own)
        running.until(lambda: received(running, good) and running.counters.get("refused_clients", 0) > 0)
        for _ in range(100):
            running.step()
        assert received(running, good)
        assert {name: drained(client) for name, client in wrong.items()} == {name: [] for name in wrong}
        assert running.counters["admitted_clients"] == 1


def test_a_revoked_key_hears_nothing_more_and_others_go_on(folder: Path) -> None:
    with vehicle(folder) as running:
        running.keys.make("display")
        display_key = running.key("display")
        planner, display = running.client(running.key()), running.client(display_key)
        running.until(lambda: received(running, planner))
        running.until(lambda: received(running, display))
        running.keys.revoke("display")
        running.worker.tick()
        assert running.counters["hang_ups"] == 1
        first_after = running._seq
        got: list[tuple[str, int]] = []

        def goes_on() -> bool:
            got.extend(drained(planner))
            return any(number > first_after + 20 for _, number in got)

        running.until(goes_on)
        late = running.client(display_key)
        running.until(lambda: running.counters.get("refused_clients", 0) >= 2)  # the open one that came back, and this
        assert all(number < first_after for _, number in drained(display))
        assert drained(late) == []
        assert not running.keys.secret_of("display").exists()
        running.keys.allow("display", display_key.own.public)
        again = running.client(display_key)
        running.until(lambda: received(running, again))


def test_a_list_of_keys_that_is_wrong_lets_nobody_in(folder: Path) -> None:
    with vehicle(folder) as running:
        client = running.client(running.key())
        running.until(lambda: received(running, client))
        allowed = running.keys.path / "allowed"
        good = allowed.read_text()
        allowed.write_text(good + "thief\n")
        running.worker.tick()
        running.until(lambda: running.counters.get("refused_clients", 0) > 0)
        (said,) = running.worker.problems()
        wanted = "line 3: expected a name and a public key of 40 characters: no listener is admitted"
        assert said == f"bus.keys: {allowed}: {wanted}"
        drained(client)
        for _ in range(20):
            running.step()
        assert drained(client) == []
        allowed.write_text(good)
        back = running.client(running.key())
        running.until(lambda: received(running, back))
        assert running.worker.problems() == []


def test_a_reader_that_stops_reading_is_cut_and_costs_no_memory(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(topic_server, "CUT_S", 1.0)
    with vehicle(folder) as running:
        good, slow = running.client(running.key()), running.client(running.key(), queue=1)
        running.until(lambda: received(running, slow))
        assert running.worker._doors[0]._socket is not None
        seen = running.worker._doors[0]._socket.get_monitor_socket(zmq.EVENT_DISCONNECTED)
        before, sent, cut = psutil.Process().memory_info().rss, 0, 0
        deadline_s = time.monotonic() + PATIENCE_S
        while (not cut or sent < 500_000_000) and time.monotonic() < deadline_s:
            running.flood(bytes(500_000))
            sent += 500_000
            while good.poll(0):
                good.recv_multipart()
            cut += bool(seen.poll(0) and recv_monitor_message(seen))
            time.sleep(0.001)
        seen.close()
        assert cut == 1
        assert sent >= 500_000_000
        assert psutil.Process().memory_info().rss - before < 100_000_000
        running.until(lambda: bool(good.poll(0)))


def test_a_port_that_is_taken_is_said_and_tried_again(folder: Path) -> None:
    with vehicle(folder) as running:
        port = int(running.address.rpartition(":")[2])
        with socket.socket() as other:
            other.bind(("127.0.0.1", port))
            other.listen()
            running.until(lambda: running.counters.get("listen_errors", 0) > 1)
            (said,) = running.worker.problems()
            assert said == f"bus.listen[0].at: cannot listen at {running.address}: address already in use"
        client = running.client(running.key())
        running.until(lambda: received(running, client))
        assert running.worker.problems() == []


def test_the_client_of_planners_takes_a_key_and_looks_at_the_age(folder: Path) -> None:
    with vehicle(folder) as running:
        planner = Obstacles(running.address, stale_s=0.05, key=running.keys.secret_of("planner"))
        running.until(lambda: planner.next().valid)
        for _ in range(300):  # nobody reads meanwhile
            running.step()
        running.until(lambda: planner.next().valid)
        running.late_ns = 2_000_000_000
        said: list[str] = []

        def is_reported() -> bool:
            said.extend(planner.next().reasons)
            return any(text.startswith("tracker: no obstacle list for 2.") for text in said)

        running.until(is_reported)
        running.late_ns = 0
        running.until(lambda: planner.next().valid)
        planner.close()


def test_the_client_says_why_it_hears_nothing(folder: Path) -> None:
    with vehicle(folder) as running:
        key = folder / "stranger.secret"
        own, server = stranger(running.key().server)
        key.write_text(f'public = "{own.public}"\nsecret = "{own.secret}"\nserver = "{server}"\n')
        key.chmod(0o600)
        refused = Obstacles(running.address, stale_s=0.05, key=key)
        running.until(lambda: refused.next().reasons[0].endswith(f": {running.address} refuses this key"))
        nobody = f"tcp://127.0.0.1:{free_port()}"
        alone = Obstacles(nobody, stale_s=0.05, key=running.keys.secret_of("planner"))
        assert alone.next().reasons[0].endswith(f": no answer from {nobody}")
        running.keys.allow("stranger", own.public)
        running.until(lambda: refused.next().valid)  # it connects anew by itself
        refused.close()
        alone.close()


@pytest.mark.slow
def test_as_a_process(folder: Path) -> None:
    config, address = folder / "onboard.toml", f"tcp://127.0.0.1:{free_port()}"
    text = (ROOT / "config" / "onboard.toml").read_text()
    here = f'[bus]\nrun_dir = "{folder}"\nkeys = "keys"\nlisten = [{{at = "{address}", topics = ["health"]}}]'
    config.write_text(text.replace("[bus]", here))
    ods = [sys.executable, "-P", "-m", "ods"]
    for what in ("keys make planner", "listen --is-on"):
        assert subprocess.run([*ods, *what.split(), "--config", str(config)], cwd=ROOT, check=False).returncode == 0
    process = subprocess.Popen([*ods, "listen", "--config", str(config)], cwd=ROOT)
    key, context = read_client_key(folder / "keys" / "planner.secret"), zmq.Context[Socket]()
    client = context.socket(zmq.SUB)
    client.curve_serverkey, client.curve_publickey = key.server.encode(), key.own.public.encode()
    client.curve_secretkey = key.own.secret.encode()
    client.setsockopt(zmq.SUBSCRIBE, b"health")
    client.connect(address)
    try:
        assert client.poll(round(1000 * PATIENCE_S))
        assert client.recv_multipart()[0] == b"health"
    finally:
        process.terminate()
        assert process.wait(10.0) == 0
        context.destroy(linger=0)
