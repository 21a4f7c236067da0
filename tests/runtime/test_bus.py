"""The bus over real ZeroMQ sockets: newest kept, losses counted, bad messages dropped, no stolen addresses."""

import os
import time
from collections.abc import Iterator
from pathlib import Path

import msgpack
import pytest
import zmq

from ods.messages import Pose, SonarAnswer, SonarRequest
from ods.runtime import bus
from ods.runtime.run_dir import RunDirError

Context = zmq.Context[zmq.Socket[bytes]]
NESTED = b"\x81\xa1x" + b"\x91" * 60_000 + b"\xc0"
"""An unknown field, nested too deep to be skipped."""
NO_TEXT = b"\x81\xa2\xec\xec\x01"
"""A field whose name is not UTF-8."""


@pytest.fixture
def context() -> Iterator[Context]:
    context: Context = zmq.Context()
    yield context
    context.destroy(linger=0)


def pose(seq: int) -> Pose:
    return Pose(seq, seq, seq, (1.0, 2.0, 3.0), (1.0, 0.0, 0.0, 0.0), (0.0,) * 3, (0.1,) * 3, (0.01,) * 3)


def connected(publisher: bus.Publisher, subscriber: bus.Subscriber) -> None:
    """Publish until the subscriber receives it, then read everything."""
    for _ in range(100):
        publisher.publish("pose", pose(0))
        if subscriber.receive(0.05)[0]:
            break
    time.sleep(0.05)
    subscriber.receive(0.0)


def test_a_lagging_subscriber_gets_the_newest_and_counts_the_rest(context: Context, tmp_path: Path) -> None:
    publisher = bus.Publisher(context, tmp_path, "nav")
    subscriber = bus.Subscriber(context, tmp_path, ["pose"])
    connected(publisher, subscriber)
    queue = bus.TOPICS["pose"].queue
    for number in range(queue + 30):
        publisher.publish("pose", pose(number))
    time.sleep(0.2)
    received, _ = subscriber.receive(1.0)
    assert [message.seq for _, message in received] == list(range(30, queue + 30))
    assert subscriber.subscriptions[0].counters["dropped_pose"] == 30
    assert subscriber.subscriptions[0].longest == queue + 30


def test_bad_messages_are_dropped_and_counted(context: Context, tmp_path: Path) -> None:
    publisher = bus.Publisher(context, tmp_path, "nav")
    subscriber = bus.Subscriber(context, tmp_path, ["pose"])
    connected(publisher, subscriber)
    for body in (b"", b"\xc1", msgpack.packb({"seq": -1}), msgpack.packb([1, 2]), b"\xdf\xff\xff\xff\xff", NESTED):
        publisher._socket.send_multipart([b"pose", body])
    publisher.publish("pose", pose(5))
    time.sleep(0.1)
    received, _ = subscriber.receive(1.0)
    assert [message.seq for _, message in received] == [5]
    assert subscriber.subscriptions[0].counters["bad_pose"] == 6


def test_a_text_that_is_not_utf_8_ends_no_process_that_reads_it(context: Context, tmp_path: Path) -> None:
    publisher = bus.Publisher(context, tmp_path, "nav")
    subscriber = bus.Subscriber(context, tmp_path, ["pose"], health_of=["nav"])
    connected(publisher, subscriber)
    publisher._socket.send_multipart([b"health", b"\x81\xa7process\xa2\xec\xec"])
    publisher.publish("pose", pose(5))
    time.sleep(0.1)
    received, _ = subscriber.receive(1.0)
    assert [message.seq for _, message in received] == [5]
    assert [each.counters for each in subscriber.subscriptions] == [{}, {"bad_health": 1}]


def test_garbage_subscriptions_hold_up_nothing_that_is_published(context: Context, tmp_path: Path) -> None:
    """20 000 of 200 bytes made poses 0.4 s late. By the time that this thread works: others' load is not counted."""
    publisher = bus.Publisher(context, tmp_path, "nav")
    with bus.Subscriber(context, tmp_path, ["pose"]) as subscriber, zmq.Context() as elsewhere:
        connected(publisher, subscriber)
        garbage: zmq.Socket[bytes] = elsewhere.socket(zmq.SUB)
        garbage.setsockopt(zmq.SNDHWM, 0)
        garbage.setsockopt(zmq.LINGER, 0)
        for _ in range(20_000):
            garbage.setsockopt(zmq.SUBSCRIBE, os.urandom(200))
        garbage.connect(bus.endpoint(tmp_path, "nav"))
        longest_s = 0.0
        for number in range(100):
            time.sleep(0.01)
            begun_s = time.thread_time()
            publisher.publish("pose", pose(number))
            longest_s = max(longest_s, time.thread_time() - begun_s)
        garbage.close()
        assert longest_s < 0.05
        connected(publisher, subscriber)
        publisher.publish("pose", pose(1000))
        assert [message.seq for _, message in subscriber.receive(1.0)[0]] == [1000]


def test_a_second_process_cannot_steal_the_address(context: Context, tmp_path: Path) -> None:
    first = bus.Publisher(context, tmp_path, "nav")
    with pytest.raises(RunDirError, match="another `ods nav` already runs"):
        bus.Publisher(context, tmp_path, "nav")
    first.close()
    bus.Publisher(context, tmp_path, "nav").close()


def test_plain_zmq_and_msgpack_read_everything(context: Context, tmp_path: Path) -> None:
    publisher = bus.Publisher(context, tmp_path, "nav")
    plain = context.socket(zmq.SUB)
    plain.connect(f"ipc://{tmp_path}/nav.sock")
    plain.subscribe("pose")
    for _ in range(100):
        publisher.publish("pose", pose(3))
        if plain.poll(20):
            break
    topic, body = plain.recv_multipart()
    assert topic == b"pose"
    assert msgpack.unpackb(body)["position_ned"] == [1.0, 2.0, 3.0]


def test_waiting_for_nothing_does_not_spin(context: Context, tmp_path: Path) -> None:
    begun = time.process_time()
    assert bus.Subscriber(context, tmp_path, []).receive(0.2) == ([], [])
    assert time.process_time() - begun < 0.1


def test_every_topic_has_one_publisher_in_the_process_table() -> None:
    from ods.runtime.processes import PROCESSES

    for topic in bus.TOPICS.values():
        publishers = [process.name for process in PROCESSES.values() if topic.name in process.publishes]
        assert publishers == [topic.publisher]
    for process in PROCESSES.values():
        assert set(process.reads) <= set(bus.TOPICS)
    of_processes = {row.name: row.process for row in bus.REQUESTS.values() if row.process != "replay" and not row.keyed}
    assert of_processes == {process.answers: process.name for process in PROCESSES.values() if process.answers}


def test_a_responder_answers_in_any_order_and_never_blocks_for_one_that_has_gone(
    context: Context, tmp_path: Path
) -> None:
    responder = bus.Responder(context, tmp_path, "sonar-requests")
    first, second, gone = (context.socket(zmq.REQ) for _ in range(3))
    asked: list[tuple[list[bytes], SonarRequest]] = []
    for number, client in enumerate((first, second, gone)):
        client.setsockopt(zmq.RCVTIMEO, 5000)
        client.setsockopt(zmq.LINGER, 0)
        client.connect(bus.endpoint(tmp_path, "sonar-requests"))
        client.send(msgpack.packb({"range_m": 10.0 + number}))
        while not asked or len(asked) <= number:
            asked += responder.receive()
    gone.close()
    assert [request.range_m for _, request in asked] == [10.0, 11.0, 12.0]
    for peer, request in reversed(asked):
        responder.answer(peer, SonarAnswer(ok=True, reason="", range_m=request.range_m))
    assert [msgpack.unpackb(client.recv())["range_m"] for client in (first, second)] == [10.0, 11.0]
    responder.close()


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        (b"\xc1", "bad request: "),
        (NESTED, "bad request: "),
        (NO_TEXT, "bad request: "),
        (bytes(1_000_000), f"bad request: 1000000 bytes are more than {bus.LONGEST_REQUEST_BYTES}"),
        (bytes(bus.LONGEST_REQUEST_BYTES + 1), "bad request: "),
        *(
            (msgpack.packb({name: value}), "bad request: ")
            for name in ("range_m", "power_db", "gain_db")
            for value in (1e39, -1e300, 1e300, float("nan"), float("-inf"), 2**63)
        ),
    ],
)
def test_what_is_no_request_is_counted_and_answered(context: Context, tmp_path: Path, body: bytes, reason: str) -> None:
    responder = bus.Responder(context, tmp_path, "sonar-requests")
    client = context.socket(zmq.REQ)
    client.setsockopt(zmq.RCVTIMEO, 5000)
    client.connect(bus.endpoint(tmp_path, "sonar-requests"))
    client.send(body)
    while not responder.counters:
        assert responder.receive() == []
    answer = msgpack.unpackb(client.recv())
    assert answer["ok"] is False
    assert answer["reason"].startswith(reason)
    assert responder.counters == {"bad_sonar-requests": 1}
    responder.close()
