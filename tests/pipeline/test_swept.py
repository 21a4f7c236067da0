"""Beams of a turning head: bodies are told once a sweep, whole, where they are, whichever way vehicle and head move."""

import math
from collections.abc import Callable, Iterator
from itertools import pairwise

import msgspec
import numpy as np
import pytest

from ods.base.arrays import Floats
from ods.base.clock import NS
from ods.base.frames.quaternion import from_euler
from ods.messages import Detections, Ping, Pose, Sweep
from ods.pipeline.chain import Chain
from ods.pipeline.prepared.plan import PingError
from ods.pipeline.processor import PingProcessor
from ods.pipeline.settings import PipelineConfig, PipelineSettings
from ods.pose.buffer import PoseSettings

STEP = math.radians(0.9)
BEAM_S = 0.08
DR_M = 0.05
SAMPLES = 800
WIDTH = math.radians(2.0)
STAGES = ({"use": "equalize.mean_range"}, {"use": "filter.fir"}, {"use": "detect.two_level", "high": 6.0})
Place = tuple[float, float]


def at_rest(_: float) -> tuple[float, float, float]:
    return 0.0, 0.0, 0.0


class Sea:
    """Round bodies of 0.5 m, and a vehicle; `motion`: north, east and heading at a time."""

    def __init__(self, bodies: list[Place], motion: Callable[[float], tuple[float, float, float]] = at_rest) -> None:
        self.bodies, self.motion, self.rng = bodies, motion, np.random.default_rng(3)

    def beam(self, bearing: float, t_s: float) -> Floats:
        """Return (SAMPLES,) amplitudes."""
        north, east, heading = self.motion(t_s)
        range_m = DR_M * (1 + np.arange(SAMPLES))
        level = np.full(SAMPLES, 6.0)
        for body in self.bodies:
            away_n, away_e = body[0] - north, body[1] - east
            distance = math.hypot(away_n, away_e)
            off = math.remainder(math.atan2(away_e, away_n) - heading - bearing, 2.0 * math.pi)
            half = 0.5 / distance
            beyond = max(abs(off) - half, 0.0)
            loud = 80.0 * math.exp(-2.77 * (beyond / WIDTH) ** 2)
            level += loud * (np.abs(range_m - distance) < 0.5)
        return np.asarray(self.rng.rayleigh(level / math.sqrt(2.0)))

    def pose(self, t_s: float, seq: int) -> Pose:
        north, east, heading = self.motion(t_s)
        attitude = from_euler(0.0, 0.0, heading)
        zeros = (0.0, 0.0, 0.0)
        return Pose(seq, round(t_s * NS), 0, (north, east, 0.0), attitude, zeros, (0.01,) * 3, (0.001,) * 3)

    def pings(self, sweeps: list[list[int]], sector: tuple[int, int], every: int) -> Iterator[Ping]:
        """Yield the pings of beams at these angles, in steps; `every`: beams a ping."""
        number = 0
        turn = sector[1] - sector[0] == 399
        for angles in sweeps:
            waiting: list[tuple[int, float]] = []
            rising = (angles[1] - angles[0]) % 400 < 200
            for place, angle in enumerate(angles):
                waiting.append((angle, BEAM_S * number))
                number += 1
                last = place + 1 == len(angles)
                if len(waiting) == every or last or (turn and angle == sector[1]):
                    sweep = Sweep(sector[0] * STEP, sector[1] * STEP, STEP, 9.0, rising, last and not turn)
                    yield self.ping(waiting, sweep, number)
                    waiting = []

    def ping(self, beams: list[tuple[int, float]], sweep: Sweep, number: int) -> Ping:
        rows = {angle: (self.beam(angle * STEP, t_s), t_s) for angle, t_s in beams}
        order = sorted(rows)
        times = [round(rows[angle][1] * NS) for angle in order]
        data = np.minimum([rows[angle][0] for angle in order], 255.0).astype(np.uint8)
        return Ping(
            seq=number, ping_number=number, t_ns=max(times), t_rx_ns=max(times), utc_ns=max(times), beams=len(order),
            samples=SAMPLES, dtype="u1", data=data.tobytes(), bearing_rad=[angle * STEP for angle in order],
            range0_m=DR_M, dr_m=DR_M, sound_speed=1500.0, beam_width_rad=[WIDTH] * len(order), beam_t_ns=times,
            sweep=sweep,
        )  # fmt: skip


def processor(settings: PipelineSettings | None = None) -> PingProcessor:
    return PingProcessor(PipelineConfig(PoseSettings(capacity=10_000), settings or PipelineSettings(stage=STAGES)))


def run(sea: Sea, sweeps: list[list[int]], sector: tuple[int, int], every: int = 10) -> list[Detections]:
    """Return what is found; the poses of all beams are known, as far back as the chain looks."""
    chain, seq, found = processor(), 0, []
    for ping in sea.pings(sweeps, sector, every):
        while 0.02 * seq <= ping.t_ns / NS + 0.1:
            chain.add_pose(sea.pose(0.02 * seq, seq))
            seq += 1
        found.append(chain.process(ping))
    return found


def places(sea: Sea, found: list[Detections]) -> list[tuple[float, float, float]]:
    """Return north, east and radius of all echoes."""
    told = []
    for each in found:
        north, east, heading = sea.motion(each.t_ns / NS)
        for echo in each.detections:
            azimuth = heading + echo.bearing_rad
            told.append(
                (north + echo.range_m * math.cos(azimuth), east + echo.range_m * math.sin(azimuth), echo.radius_m)
            )
    return told


def seen_of(found: Detections) -> list[tuple[float, float]]:
    """Return the bearings that a ping looked at."""
    ends = [found.sector.bearing_min_rad]
    for part in sorted(found.unseen, key=lambda part: part.bearing_min_rad):
        if part.why == "not swept":
            ends += [part.bearing_min_rad, part.bearing_max_rad]
    ends.append(found.sector.bearing_max_rad)
    return [(low, high) for low, high in zip(ends[::2], ends[1::2], strict=True) if high - low > 1e-9]


SECTOR = (-50, 50)
THERE = list(range(-50, 51))
BACK = THERE[::-1]
BODIES = [(25.0, -15.0), (30.0, 2.0), (16.0, 8.0)]


def turning(t_s: float) -> tuple[float, float, float]:
    return 0.15 * t_s, 0.1 * t_s, math.radians(8.0) * math.sin(2.0 * math.pi * t_s / 12.0)


@pytest.mark.parametrize("every", [3, 10, 17, 50])
@pytest.mark.parametrize("motion", [at_rest, turning])
def test_each_body_is_told_once_a_sweep_where_it_is(
    every: int, motion: Callable[[float], tuple[float, float, float]]
) -> None:
    sea = Sea(BODIES, motion)
    found = run(sea, [THERE, BACK, THERE], SECTOR, every)
    told = places(sea, found)
    for north, east in BODIES:
        mine = [each for each in told if math.dist(each[:2], (north, east)) < 1.5]
        assert len(mine) == 3
        assert all(math.dist(each[:2], (north, east)) < 0.6 for each in mine)
    assert len(told) <= 11  # noise
    times = [each.t_ns for each in found]
    assert all(later > earlier for earlier, later in pairwise(times))


def test_what_is_looked_at_makes_up_the_sector_and_holds_what_is_told() -> None:
    found = run(Sea(BODIES), [THERE, BACK], SECTOR)
    looked = [span for each in found for span in seen_of(each)]
    assert sum(high - low for low, high in looked) == pytest.approx(2 * 101 * STEP)
    assert {each.turn_s for each in found} == {9.0}
    assert not any(each.unseen_why or each.unseen_share for each in found)
    slack = 3.0 * STEP
    for each in found:
        for echo in each.detections:
            assert any(low - slack <= echo.bearing_rad <= high + slack for low, high in seen_of(each))


def test_a_turn_without_end_tells_bodies_astern_whole_and_each_time() -> None:
    turn = [(angle + 200) % 400 - 200 for angle in range(-100, 900)]
    sea = Sea([(-20.0, 0.0), (20.0, 10.0)])
    told = places(sea, run(sea, [turn], (-200, 199)))
    astern = [each for each in told if math.dist(each[:2], (-20.0, 0.0)) < 1.0]
    assert len(astern) == 2
    assert all(radius > 0.4 for _, _, radius in astern)
    assert len(told) == 5 or len(told) == 4


def test_a_body_wider_than_the_guard_is_told_under_way_and_whole_behind_it() -> None:
    sea = Sea([(2.3, 0.0)])
    found = run(sea, [THERE], SECTOR, 3)
    echoes = [echo for each in found for echo in each.detections]
    assert len(echoes) >= 2
    widest = max(echoes, key=lambda echo: echo.bearing_extent_rad)
    assert abs(widest.bearing_rad) < math.radians(4.0)
    assert widest.bearing_extent_rad > math.radians(22.0)


def test_without_poses_the_head_is_taken_to_have_been_at_rest_and_that_is_counted() -> None:
    sea = Sea(BODIES)
    chain = processor()
    found = [chain.process(ping) for ping in sea.pings([THERE], SECTOR, 10)]
    assert chain.counters["beams_without_pose"] == 101
    assert len(places(sea, found)) == 3


def test_what_makes_no_sense_is_a_bad_ping() -> None:
    ping = next(iter(Sea(BODIES).pings([THERE], SECTOR, 10)))
    assert ping.sweep is not None
    changes: list[dict[str, object]] = [
        {"beam_t_ns": ping.beam_t_ns[1:]},
        {"bearing_rad": ping.bearing_rad[1:]},
        {"sweep": msgspec.structs.replace(ping.sweep, step_rad=0.0)},
        {"sweep": msgspec.structs.replace(ping.sweep, step_rad=math.nan)},
        {"sweep": msgspec.structs.replace(ping.sweep, bearing_min_rad=4.0)},
        {"bearing_rad": [*ping.bearing_rad[:-1], 1.0]},
        {"no_data": [(0, 0, 3)]},
    ]
    for change in changes:
        with pytest.raises(PingError, match="sweep"):
            processor().process(msgspec.structs.replace(ping, **change))


def test_a_chain_by_itself_takes_no_beams_for_an_image() -> None:
    with pytest.raises(PingError, match="`ods track` joins them"):
        Chain(PipelineSettings()).process(next(iter(Sea(BODIES).pings([THERE], SECTOR, 10))))


def test_stages_that_compare_pings_are_refused_by_name() -> None:
    settings = PipelineSettings(stage=({"use": "filter.ping_iir"}, *STAGES))
    ping = next(iter(Sea(BODIES).pings([THERE], SECTOR, 10)))
    with pytest.raises(PingError, match="compares successive pings"):
        processor(settings).process(ping)
