"""Joining records into pings: what belongs together, what changes when, what is counted."""

import dataclasses
import struct

import msgspec
import pytest

from ods.messages import Ping
from ods.sonar_link.s7k import records
from ods.sonar_link.s7k.assembler import Assembler
from ods.sonar_link.s7k.drf import DeviceId, S7kRecord
from ods.sonar_link.s7k.framer import RecordFramer
from tests.sonar_link.sonar_samples import UTC_NS, link, make_ping


def records_of(ping: Ping, first_ns: int = 0, device: int = 7000) -> list[S7kRecord]:
    return [
        dataclasses.replace(record, first_ns=first_ns, last_ns=first_ns + 10)
        for record in RecordFramer().feed(records.encode_ping(ping, DeviceId(device)))
    ]


def feed(assembler: Assembler, *groups: list[S7kRecord]) -> list[Ping]:
    fed = [assembler.feed(record, records.decode(record)) for group in groups for record in group]
    return [ping for ping in fed if ping is not None]


def test_changes_take_effect_at_their_ping() -> None:
    changed = make_ping(2, beams=4, samples=8, dr_m=0.5, range0_m=2.0)
    changed = msgspec.structs.replace(changed, sound_speed=1450.0, frequency_hz=200e3)
    pings, _ = link(records.encode_ping(ping) for ping in (make_ping(1), changed, make_ping(3)))
    assert [(p.beams, p.samples, p.sound_speed, p.frequency_hz) for p in pings] == [
        (6, 40, 1500.0, 455e3), (4, 8, 1450.0, 200e3), (6, 40, 1500.0, 455e3)
    ]  # fmt: skip
    assert [p.range0_m for p in pings] == pytest.approx([0.5, 2.0, 0.5])
    assert [p.dr_m for p in pings] == pytest.approx([0.25, 0.5, 0.25])
    assert [p.seq for p in pings] == [0, 1, 2]


def test_the_next_ping_may_be_announced_before_this_ones_samples() -> None:
    now = records_of(make_ping(1, beams=4))
    later = records_of(make_ping(2, beams=6, utc_ns=UTC_NS + 150_000_000))
    assembler = Assembler()
    pings = feed(assembler, now[:2], later[:2], now[2:], later[2:])
    assert [(p.ping_number, p.beams) for p in pings] == [(1, 4), (2, 6)]
    assert assembler.counters == {"pings": 2}


def test_a_beam_table_stands_until_the_next_one_and_over_a_clock_set_back() -> None:
    assembler = Assembler()
    settings, _, samples = records_of(make_ping(2, utc_ns=UTC_NS - 3_600_000_000_000))
    assert len(feed(assembler, records_of(make_ping(1)), [settings, samples])) == 2


def test_a_lost_beam_table_costs_its_ping_where_each_ping_has_its_own() -> None:
    """The fan becomes narrower at a ping whose beam table is lost."""
    assembler = Assembler()
    sent = [make_ping(n, utc_ns=UTC_NS + n * 150_000_000) for n in range(20)]
    narrow = [msgspec.structs.replace(p, bearing_rad=[0.5 * b for b in p.bearing_rad]) for p in sent]
    groups = [records_of(p) for p in [*sent[:4], *narrow[4:]]]
    for lost in (4, 9, 10, 15):
        del groups[lost][1]
    pings = feed(assembler, *groups)
    assert [p.ping_number for p in pings] == [n for n in range(20) if n not in (4, 9, 10, 15)]
    assert all(p.bearing_rad == (sent if p.ping_number < 4 else narrow)[p.ping_number].bearing_rad for p in pings)
    assert assembler.counters == {"pings": 16, "lost_pings": 4, "data_without_geometry": 4}


@pytest.mark.parametrize("own", [1, 2, 20])
def test_a_sonar_that_sends_its_beam_table_at_the_start_or_stops_to_send_it_goes_on(own: int) -> None:
    assembler = Assembler()
    groups = [records_of(make_ping(n, utc_ns=UTC_NS + n * 150_000_000)) for n in range(60)]
    for group in groups[own:]:
        del group[1]
    pings = feed(assembler, *groups)
    lost = 4 if own == 20 else 0  # until it is clear that it has stopped
    assert [p.ping_number for p in pings] == [*range(own), *range(own + lost, 60)]
    assert assembler.counters["data_without_geometry"] == lost


def test_a_table_sent_ahead_is_not_for_the_ping_before() -> None:
    """Of a sonar that sends tables at changes only, with another number of samples and the same of beams."""
    first, second = (make_ping(n, utc_ns=UTC_NS + n * 150_000_000) for n in (1, 2))
    narrow = msgspec.structs.replace(second, bearing_rad=[0.5 * b for b in second.bearing_rad])
    now, later = records_of(first), records_of(narrow)
    pings = feed(Assembler(), now[:2], later[1:2], now[2:], later[:1], later[2:])
    assert [p.bearing_rad for p in pings] == [first.bearing_rad, narrow.bearing_rad]


def test_settings_of_another_ping_are_not_used() -> None:
    first = make_ping(1)
    second = msgspec.structs.replace(make_ping(2, utc_ns=UTC_NS + 150_000_000), sound_speed=1450.0, frequency_hz=2e5)
    now, later = records_of(first), records_of(second)
    assembler = Assembler()
    pings = feed(assembler, now[:2], later[:2], now[2:], later[2:])
    assert [(p.sound_speed, p.frequency_hz) for p in pings] == [(1500.0, 455e3), (1450.0, 2e5)]
    lost = records_of(make_ping(3, utc_ns=UTC_NS + 300_000_000))[1:]
    assert feed(assembler, lost) == []
    assert assembler.counters["data_without_settings"] == 1


def test_samples_of_fewer_than_the_sonar_takes_have_the_spacing_of_their_own_record() -> None:
    """7000 tells the sonar's sampling rate, 7042 the one behind its down-sampling, here by 4."""
    ping = make_ping(1, range0_m=1.0, dr_m=0.25)
    settings, geometry, samples = records_of(ping)
    body = bytearray(settings.body)
    struct.pack_into("<f", body, 18, 4 * 0.5 * 1500.0 / 0.25)
    (back,) = feed(Assembler(), [dataclasses.replace(settings, body=bytes(body)), geometry, samples])
    assert (back.dr_m, back.range0_m) == (0.25, 1.0)


def test_gaps_duplicates_and_restarts_are_counted() -> None:
    assembler = Assembler()
    numbers = [2**32 - 2, 2**32 - 1, 2, 2, 3, 0]
    pings = feed(assembler, *(records_of(msgspec.structs.replace(make_ping(0), ping_number=n)) for n in numbers))
    assert [p.ping_number for p in pings] == [2**32 - 2, 2**32 - 1, 2, 3, 0]
    counters = assembler.counters
    assert (counters["lost_pings"], counters["duplicate_pings"], counters["ping_number_restarts"]) == (2, 1, 1)


@pytest.mark.parametrize("numbers", [[0, 0, 0, 0], [1, 1, 2, 2]])
def test_pings_of_one_number_are_distinguished_by_their_times(numbers: list[int]) -> None:
    assembler = Assembler()
    pings = [make_ping(0, utc_ns=UTC_NS + k * 250_000_000) for k in range(4)]
    numbered = [msgspec.structs.replace(ping, ping_number=n) for ping, n in zip(pings, numbers, strict=True)]
    assert [p.utc_ns for p in feed(assembler, *map(records_of, numbered))] == [p.utc_ns for p in pings]
    assert assembler.counters["duplicate_pings"] == 0
    assert feed(assembler, records_of(numbered[-1])) == []
    assert assembler.counters["duplicate_pings"] == 1


def test_samples_without_settings_or_beam_table_are_counted() -> None:
    settings, geometry, samples = records_of(make_ping(1))
    for given_records, counter in (([geometry], "data_without_settings"), ([settings], "data_without_geometry")):
        assembler = Assembler()
        assert feed(assembler, [*given_records, samples]) == []
        assert assembler.counters == {counter: 1}


def test_sonars_are_distinguished_and_their_number_is_bounded() -> None:
    assembler = Assembler()
    a, b = records_of(make_ping(1, beams=4), device=1), records_of(make_ping(1, beams=6), device=2)
    assert [p.beams for p in feed(assembler, a[:2], b[:2], a[2:], b[2:])] == [4, 6]
    for device in range(10, 300):
        feed(assembler, records_of(make_ping(1), device=device))
    assert assembler.counters["pings"] == 292


def test_some_beams_of_a_table_by_their_numbers() -> None:
    whole = make_ping(1)
    settings, geometry, samples = records_of(whole)
    size = 6 + whole.samples  # beam number, count, samples
    body = bytearray(samples.body[:44] + samples.body[44 + 2 * size : 44 + 5 * size])
    body[14:16] = (3).to_bytes(2, "little")
    (part,) = feed(Assembler(), [settings, geometry, dataclasses.replace(samples, body=bytes(body))])
    assert part.bearing_rad == whole.bearing_rad[2:5]
    assert part.data == whole.data[2 * whole.samples : 5 * whole.samples]


def test_a_sonar_without_a_clock() -> None:
    timeless = [dataclasses.replace(record, time_ns=None) for record in records_of(make_ping(1), first_ns=10**9)]
    assembler = Assembler()
    (ping,) = feed(assembler, timeless)
    assert ping.t_ns == 10**9 - round(2 * (0.5 + 39 * 0.25) / 1500.0 * 1e9)
    assert (ping.utc_ns, assembler.counters["no_device_time"]) == (0, 1)
