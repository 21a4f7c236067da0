"""The truth of pings without numbers of the sonar's own."""

import msgspec

from ods.base.clock import MS
from ods.bench.collector import TruthsByTime
from ods.messages import Ping, Truth
from ods.pipeline.warm_up import made_up_ping


def truth(t_ns: int) -> Truth:
    return Truth(t_ns // (90 * MS), t_ns, t_ns, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), [])


def ping(number: int, t_ns: int) -> Ping:
    made = made_up_ping("u1", "linear", 0.5, 0.05)
    return msgspec.structs.replace(made, ping_number=number, t_ns=t_ns)


def test_it_is_that_of_the_newest_beam_whichever_is_reported_first() -> None:
    by_time, found = TruthsByTime(), []
    for k in range(1, 30):
        if k % 10 == 0:
            by_time.ping(ping(k // 10, k * 90 * MS + MS))
        found += by_time.truth(truth(k * 90 * MS))
    assert [(each.ping_number, each.t_ns) for each in found] == [(1, 10 * 90 * MS), (2, 20 * 90 * MS)]
    late = ping(3, 29 * 90 * MS - MS)
    by_time.ping(late)
    (third,) = by_time.truth(truth(30 * 90 * MS))
    assert (third.ping_number, third.t_ns) == (3, 29 * 90 * MS)
