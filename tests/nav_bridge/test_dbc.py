"""DBC frames to poses, without I/O: frames are packed here by hand from SBG's manual."""

import itertools
import math
import random
import struct
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import can
import cantools
import msgspec
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.spatial.transform import Rotation

from ods.base.clock import NS
from ods.base.frames.geometry import quat_from_euler, rotation_matrix
from ods.base.geodesy import LocalFrame
from ods.base.settings_file import ConfigError, load
from ods.bench.settings import BenchConfig
from ods.config import OnboardConfig
from ods.messages import Pose
from ods.nav_bridge.can.frame import CanId, Frame
from ods.nav_bridge.dbc.epoch_order import CYCLES
from ods.nav_bridge.dbc.file import DbcError, DbcText
from ods.nav_bridge.dbc.source import DbcSource
from ods.nav_bridge.dbc.units import conversion
from ods.nav_bridge.registry import make_source
from ods.nav_bridge.settings import (
    DbcSettings,
    NavSettings,
    PartSettings,
    SignalSettings,
    TimeSettings,
    ValiditySettings,
)
from ods.nav_bridge.source import SourceHost
from ods.sim_sonar.ins.dbc_ins import SimulatedDbcIns
from tests.nav_bridge.made_up_clock import utc_ahead

CONFIG = Path(__file__).parents[2] / "config"
DBC = CONFIG / "sbg.dbc"


def shipped_map() -> DbcSettings:
    dbc = load(CONFIG / "onboard-sbg.toml", OnboardConfig).nav.dbc
    assert dbc is not None
    return dbc


SBG = shipped_map()
MS = 1_000_000
PERIOD = 10 * MS
SITE = LocalFrame(57.0, 9.9)
STATUS = 0x102
IDS = (0x130, 0x132, 0x133, 0x134, 0x135, 0x136, 0x137)
GAP = 250_000
"""Between the frames of an epoch, ns."""
UTC_OFFSET = 1_700_000_000 * NS
FIRST_US = 5_000_000


class Bench:
    """A source, its counters, and frames made by hand."""

    def __init__(self, dbc: DbcSettings = SBG, status: int | None = 0xF4) -> None:
        self.counters: Counter[str] = Counter()
        nav = NavSettings(source="dbc", dbc=dbc)
        host = SourceHost(SITE, lambda *_: None, self.counters, 0, utc_ahead(UTC_OFFSET))

        self.source = DbcSource(nav, dbc, host)
        self.status = status
        self._knows_order = False

    def take(self, can_id: int, data: bytes, t_ns: int, extended: bool = False) -> Pose | None:
        return self.source.take(Frame(can_id, extended, data, t_ns))

    def epoch(
        self, number: int, places: tuple[int, ...] = (0, 1, 2, 3, 4, 5, 6), late_ns: int = 0, **values: int
    ) -> list[Pose]:
        """Feed the messages at `places` of epoch `number`, sent every 10 ms; return the poses that came of it."""
        t_ns = number * PERIOD + late_ns
        self.learn(number, places)
        if self.status is not None:
            self.take(STATUS, struct.pack("<IH", self.status, 0), t_ns - GAP)
        frames = epoch_frames(number, **values)
        found = [self.take(IDS[place], frames[place], t_ns + step * GAP) for step, place in enumerate(places)]
        return [pose for pose in found if pose is not None]

    def learn(self, number: int, places: tuple[int, ...] = tuple(range(7))) -> None:
        """Feed the instants before `number`, once, that are needed to know the order."""
        if not self._knows_order:
            self._knows_order = True
            for early in range(number - CYCLES, number):
                frames = epoch_frames(early)
                for step, place in enumerate(places):
                    self.take(IDS[place], frames[place], early * PERIOD + step * GAP)
            self.counters.clear()

    def run(self, *numbers: int) -> list[Pose]:
        """Feed whole epochs."""
        return [pose for number in numbers for pose in self.epoch(number)]


def epoch_frames(number: int, **values: int) -> list[bytes]:
    """Return the frames of one epoch as raw counts."""
    v = {
        "us": FIRST_US + number * 10_000, "roll": -523, "pitch": 1047, "yaw": -31000, "lat": 570100000, "lon": 99200000,
        "alt": -4200, "vn": 150, "ve": -20, "vd": 4,
    } | values  # fmt: skip
    return [
        struct.pack("<I", v["us"] % 2**32),
        struct.pack("<hhh", v["roll"], v["pitch"], v["yaw"]),
        struct.pack("<HHH", 20, 30, 123),
        struct.pack("<ii", v["lat"], v["lon"]),
        struct.pack("<ih", v["alt"], 8000),
        struct.pack("<HHH", 25, 26, 4),
        struct.pack("<hhh", v["vn"], v["ve"], v["vd"]),
    ]


def lost(counters: Counter[str]) -> dict[str, int]:
    """Return the counters that tell of trouble."""
    return {name: count for name, count in counters.items() if count}


def test_an_epoch_becomes_a_pose() -> None:
    bench = Bench()
    assert bench.epoch(1) == []  # nothing before it proves that it is whole
    (pose,) = bench.epoch(2)
    assert pose.position_ned == pytest.approx(ned_by_hand(57.01, 9.92, -4.2), abs=1e-6)
    attitude = Rotation.from_euler("ZYX", [-3.1, 0.1047, -0.0523])
    assert abs(float(attitude.as_quat(scalar_first=True) @ pose.attitude)) == pytest.approx(1.0)
    np.testing.assert_allclose(pose.velocity_body, attitude.inv().apply([1.5, -0.2, 0.04]), atol=1e-12)
    assert pose.sigma_position_ned == pytest.approx((0.25, 0.26, 0.04))
    assert pose.sigma_attitude == pytest.approx((0.002, 0.003, 0.0123))
    assert pose.t_ns == pytest.approx(2 * PERIOD, abs=2_000)  # the clock's drift allowance
    assert pose.utc_ns == pose.t_ns + UTC_OFFSET
    assert lost(bench.counters) == {"epoch_unproven": 1}
    assert bench.source.problems(2 * PERIOD + MS) == []


def ned_by_hand(latitude: float, longitude: float, height: float) -> tuple[float, float, float]:
    """Return N, E, D from SITE with earth-centred axes, written out."""

    def ecef(latitude: float, longitude: float, height: float) -> tuple[float, float, float]:
        sine, cosine = math.sin(latitude), math.cos(latitude)
        n = 6378137.0 / math.sqrt(1.0 - 0.0066943799901413165 * sine**2)
        return (
            (n + height) * cosine * math.cos(longitude),
            (n + height) * cosine * math.sin(longitude),
            (n * (1.0 - 0.0066943799901413165) + height) * sine,
        )

    lat0, lon0 = math.radians(57.0), math.radians(9.9)
    here, there = ecef(lat0, lon0, 0.0), ecef(math.radians(latitude), math.radians(longitude), height)
    x, y, z = (b - a for a, b in zip(here, there, strict=True))
    outward = math.cos(lon0) * x + math.sin(lon0) * y
    return (
        math.cos(lat0) * z - math.sin(lat0) * outward,
        math.cos(lon0) * y - math.sin(lon0) * x,
        -math.cos(lat0) * outward - math.sin(lat0) * z,
    )


def test_quaternion_body_velocity_and_undulation_of_sbg_can_be_mapped_too() -> None:
    signals: dict[str, str | SignalSettings] = {
        "latitude": "SBG_ECAN_MSG_EKF_POS.LATITUDE",
        "longitude": "SBG_ECAN_MSG_EKF_POS.LONGITUDE",
        "altitude": "SBG_ECAN_MSG_EKF_ALTITUDE.UNDULATION",
    }
    signals |= {f"q{axis}": f"SBG_ECAN_MSG_EKF_QUAT.Q{n}" for n, axis in enumerate("wxyz")}
    signals |= {name: f"SBG_ECAN_MSG_EKF_VEL_BODY.VELOCITY_{axis}" for name, axis in zip("uvw", "XYZ", strict=True)}
    bench = Bench(DbcSettings(file=DBC, signals=signals), status=None)
    w, x, y, z = 0.5, -0.5, 0.5, -0.5
    poses = []
    for number in range(CYCLES + 2):
        for place, (can_id, data) in enumerate(
            [
                (0x131, struct.pack("<hhhh", *(round(32767 * part) for part in (w, x, y, z)))),
                (0x134, struct.pack("<ii", 570000000, 99000000)),
                (0x135, struct.pack("<ih", 0, -800)),
                (0x139, struct.pack("<hhh", 151, -32, 7)),
            ]
        ):
            poses.append(bench.take(can_id, data, number * PERIOD + place * GAP))
    pose = poses[-1]
    assert pose is not None
    assert pose.attitude == pytest.approx((w, x, y, z))
    assert pose.velocity_body == pytest.approx((1.51, -0.32, 0.07))
    assert pose.position_ned == pytest.approx((0.0, 0.0, 4.0), abs=1e-6)
    assert pose.t_ns == (CYCLES + 1) * PERIOD  # no clock is mapped: arrival of the first frame


# faults


@pytest.mark.parametrize("place", range(7))
def test_a_lost_frame_costs_its_epoch_and_the_next(place: int) -> None:
    bench = Bench()
    assert len(bench.run(1, 2, 3)) == 2
    assert bench.epoch(4, places=tuple(n for n in range(7) if n != place)) == []
    assert bench.epoch(5) == []
    assert len(bench.run(6, 7)) == 2
    assert bench.counters["epoch_torn"] == (1 if place else 0)
    assert bench.counters["epoch_unproven"] == 2


@pytest.mark.parametrize("place", range(7))
def test_a_repeated_frame_costs_two_epochs_at_most(place: int) -> None:
    bench = Bench()
    bench.run(1, 2)
    found = bench.epoch(3, places=tuple(sorted((*range(7), place)))) + bench.epoch(4)
    assert len(found) == (1 if place in (0, 6) else 0)  # at the borders only one epoch is in doubt
    assert len(bench.run(5, 6)) == 2


def test_swapped_frames_cost_their_epoch_and_the_next() -> None:
    bench = Bench()
    bench.run(1, 2)
    assert bench.epoch(3, places=(0, 1, 3, 2, 4, 5, 6)) == []
    assert bench.epoch(4) == []
    assert len(bench.run(5, 6)) == 2
    assert bench.counters["frame_stray"] == 5


def test_the_device_stops_in_mid_epoch_and_goes_on_where_it_stopped() -> None:
    bench = Bench()
    bench.run(1, 2)
    assert bench.epoch(3, places=(0, 1, 2)) == []
    assert bench.epoch(40, places=(3, 4, 5, 6)) == []  # it would complete epoch 3
    assert bench.epoch(41) == []
    assert bench.counters["epoch_parted"] == 1
    assert len(bench.run(42, 43)) == 2


def test_a_late_frame_does_not_slip_into_the_next_epoch() -> None:
    bench = Bench()
    bench.run(1, 2)
    bench.epoch(3, places=(0, 1, 2, 3, 4, 5))
    velocity = epoch_frames(3, vn=-999)[6]
    bench.epoch(4, places=(0, 1, 2, 3, 4, 5))
    assert bench.take(IDS[6], velocity, 4 * PERIOD + 6 * GAP) is None  # in place of epoch 4's own, which is lost
    (pose,) = bench.epoch(5)
    assert np.linalg.norm(pose.velocity_body) < 2.0


def test_a_whole_epoch_lost_but_for_a_late_frame() -> None:
    bench = Bench()
    bench.run(1, 2, 3)
    bench.epoch(5, places=(0, 1, 2, 3, 4, 5))  # epoch 4 is lost but for its velocity
    assert bench.take(IDS[6], epoch_frames(4, vn=-999)[6], 5 * PERIOD + 6 * GAP) is None
    assert len(bench.epoch(6)) == 1


@given(
    st.integers(0, 2**32 - 1),
    st.floats(0.0, 0.4),
    st.sampled_from(["lost", "repeated", "swapped", "late"]),
    st.sampled_from([0, 3_000_000, 30_000_000]),
)
@settings(max_examples=80, deadline=None)
def test_whatever_is_lost_repeated_swapped_or_late_a_pose_is_never_a_mixture(
    seed: int, share: float, kind: str, jitter_ns: int
) -> None:
    """Each frame bears its epoch's number; a frame is late by less than an epoch, one epoch in two."""
    chance = random.Random(seed)
    arrivals: list[tuple[int, int, int]] = []
    for number in range(1, 40):
        for place in range(7):
            t_ns = number * PERIOD + place * GAP
            hit = chance.random() < share
            what = chance.choice([kind, "lost"]) if hit else ""
            if what == "lost":
                continue
            if what == "swapped":
                t_ns += chance.randrange(2 * GAP)
            if what == "late" and number % 2:
                t_ns += PERIOD - chance.choice([chance.randrange(GAP), chance.randrange(PERIOD)]) - 1
            arrivals.append((t_ns, number, place))
            if what == "repeated":
                arrivals.append((t_ns + chance.randrange(2 * GAP), number, place))
    bench = Bench()
    bench.learn(1)
    delay_ns = 0
    for t_ns, number, place in sorted(arrivals):
        delay_ns = max(0, delay_ns - GAP, chance.randrange(jitter_ns + 1))  # of reading: it keeps the order
        bench.take(STATUS, struct.pack("<IH", 0xF4, 0), t_ns)
        pose = bench.take(IDS[place], marked_frames(number)[place], t_ns + delay_ns)
        if pose is not None:
            check_unmixed(pose, PERIOD // 2 + jitter_ns)
    if share == 0.0 and jitter_ns < 2 * MS:
        assert lost(bench.counters).keys() <= {"epoch_unproven"}


def marked_frames(number: int) -> list[bytes]:
    """Return the frames of an epoch, its number in each."""
    lat, lon = 570000000 + number * 100, 99000000 + number * 100
    return epoch_frames(number, roll=number, lat=lat, lon=lon, alt=-1000 * number, vd=number)


def check_unmixed(pose: Pose, slack_ns: int = PERIOD // 2) -> int:
    """Assert that position, attitude, velocity and instant tell of the same epoch; return its number."""
    north, east, down = pose.position_ned
    number = round(down)
    turn = Rotation.from_quat(pose.attitude, scalar_first=True)
    velocity_down = turn.apply(pose.velocity_body)[2]
    assert round(north / 1.1138) == round(east / 0.6079) == number
    assert round(turn.as_euler("ZYX")[2] * 1e4) == number
    assert round(velocity_down * 100.0) == number
    assert abs(pose.t_ns - number * PERIOD) < slack_ns
    return number


def test_a_backlog_becomes_poses_but_where_frames_of_it_are_lost() -> None:
    bench = Bench()
    bench.run(*range(1, 20))
    found = []
    for number in range(20, 60):  # read in one go, up to 0.4 s late, a block of exactly one epoch lost in the middle
        bench.take(STATUS, struct.pack("<IH", 0xF4, 0), 60 * PERIOD - 2 * MS)
        frames = list(enumerate(marked_frames(number)))
        for place, data in frames[:3] if number == 40 else frames[3:] if number == 41 else frames:
            pose = bench.take(IDS[place], data, 60 * PERIOD - 2 * MS)
            if pose is not None:
                found.append(check_unmixed(pose))
    assert sorted({*range(20, 60)} - {*found}) == [40, 41, 42]
    assert bench.counters["epoch_late"] == 1
    assert len(bench.run(60, 61, 62)) == 3


def test_an_epoch_read_later_than_the_window_waits_for_the_next_instant() -> None:
    bench = Bench()
    bench.run(*range(1, 10))
    assert len(bench.epoch(10, late_ns=5 * MS)) == 1
    assert bench.epoch(11, late_ns=7 * MS) == []
    late, following = bench.epoch(12)
    assert (late.t_ns - 11 * PERIOD, following.t_ns - 12 * PERIOD) == pytest.approx((0, 0), abs=20_000)
    assert bench.epoch(13, late_ns=7 * MS) == []
    assert bench.epoch(15) == []  # something is missing between: 13 may hold some of it
    assert lost(bench.counters) == {"epoch_unproven": 2, "epoch_late": 1}


# device time


def instants(poses: list[Pose]) -> list[int]:
    return [b.t_ns - a.t_ns for a, b in itertools.pairwise(poses)]


def test_the_clocks_wrap_is_no_event() -> None:
    bench = Bench()
    poses = [pose for n in range(1, 60) for pose in bench.epoch(n, us=2**32 - 300_000 + n * 10_000)]
    assert len(poses) == 58
    assert all(abs(step - PERIOD) < 20_000 for step in instants(poses))
    assert lost(bench.counters) == {"epoch_unproven": 1}


@pytest.mark.parametrize("uptime_us", [600_000_000, 2_400_000_000, 4_000_000_000])
def test_a_power_cycle_is_counted_and_the_stream_goes_on(uptime_us: int) -> None:
    bench = Bench()
    before = [pose for n in range(1, 80) for pose in bench.epoch(n, us=uptime_us + n * 10_000)]
    after = [pose for n in range(500, 540) for pose in bench.epoch(n, us=(n - 499) * 10_000)]
    assert len(before) == 78
    assert len(after) >= 34
    assert abs(after[-1].t_ns - 539 * PERIOD) < MS
    assert all(pose.t_ns >= 499 * PERIOD for pose in after)
    assert bench.counters["ins_clock_jumps"] == 1
    assert bench.counters["ins_clock_wild"] == 4


def test_instants_follow_the_devices_clock_not_the_jitter_of_arrival() -> None:
    bench = Bench()
    chance = random.Random(4)
    poses = [pose for n in range(1, 200) for pose in bench.epoch(n, late_ns=chance.randrange(4 * MS))]
    assert len(poses) > 190
    assert max(abs(step - PERIOD) for step in instants(poses[80:])) < MS


def test_a_clock_of_other_unit_width_and_wrap() -> None:
    clocked = dbc_of(time=TimeSettings(signal="SBG_ECAN_MSG_EKF_INFO.TIME_STAMP", unit="0.1 ms", wraps_at=1.0))
    with pytest.raises(DbcError, match=r"nav\.dbc\.time\.unit: '0\.1 ms' is not a known unit of time, such as s"):
        Bench(clocked)
    bench = Bench(
        dbc_of(time=TimeSettings(signal="SBG_ECAN_MSG_EKF_INFO.TIME_STAMP", unit="ms", wraps_at=604_800_000.0))
    )
    poses = [pose for n in range(1, 60) for pose in bench.epoch(n, us=(604_800_000 - 300 + n * 10) % 604_800_000)]
    assert len(poses) == 58
    assert lost(bench.counters) == {"epoch_unproven": 1}


# frames


def test_short_twin_and_unknown_frames_are_dropped() -> None:
    bench = Bench()
    bench.run(1, 2)
    for can_id, data in zip(IDS, epoch_frames(3), strict=True):
        for bad in (data[:-1], b""):
            assert bench.take(can_id, bad, 3 * PERIOD) is None
        assert bench.take(can_id, data, 3 * PERIOD, extended=True) is None
        assert bench.take(can_id + 0x400, data, 3 * PERIOD) is None
    assert lost(bench.counters) == {"epoch_unproven": 1, "frame_short": 14, "frame_twin": 7}
    assert len(bench.run(3, 4)) == 2


FLOATS = """VERSION ""
BU_: INS
BO_ 2566844416 FAST: 8 INS
 SG_ T : 0|32@1+ (0.001,0) [0|0] "s" INS
 SG_ HEADING : 32|32@1- (1,0) [0|0] "deg" INS
BO_ 2566844417 REST: 8 INS
 SG_ X : 0|8@1- (1,0) [0|0] "km" INS
 SG_ DEPTH : 15|16@0+ (1,-10) [0|0] "ft" INS
 SG_ V : 24|8@1- (0.5,0) [0|0] "kn" INS
 SG_ STRANGE : 32|8@1- (1,0) [0|0] "furlong" INS
 SG_ BARE : 40|8@1- (1,0) [0|0] "" INS
BO_ 7 CHOICE: 8 INS
 SG_ WHICH M : 0|8@1+ (1,0) [0|0] "" INS
 SG_ SOMETIMES m0 : 8|8@1+ (1,0) [0|0] "m" INS
BO_ 8 LONG: 64 INS
 SG_ N : 0|8@1+ (1,0) [0|0] "m" INS
SIG_VALTYPE_ 2566844416 HEADING : 1;
"""


@pytest.fixture
def floats(tmp_path: Path) -> Path:
    file = tmp_path / "floats.dbc"
    file.write_text(FLOATS)
    return file


def general(file: Path, **changes: str | SignalSettings) -> DbcSettings:
    """Return a map of FLOATS that uses most of what a map may say."""
    signals: dict[str, str | SignalSettings] = {
        "north": "REST.X", "east": SignalSettings(signal="REST.X", sign=-1, offset=250.0),
        "down": "REST.DEPTH", "roll": SignalSettings(signal="REST.BARE", unit="mrad"),
        "pitch": SignalSettings(signal="REST.BARE", factor=0.01, sign=-1), "yaw": "FAST.HEADING",
        "u": "REST.V", "v": SignalSettings(signal="REST.STRANGE", factor=0.05, offset=-1.0),
        "w": SignalSettings(signal="REST.BARE", unit="mm/s"),
    }  # fmt: skip
    return DbcSettings(file=file, signals=signals | changes, time="FAST.T")


def floats_epoch(bench: Bench, number: int, heading: float = 450.0) -> Pose | None:
    bench.take(0x18FEF000, struct.pack("<If", 1000 + number * 10, heading), number * PERIOD, extended=True)
    data = struct.pack("<b", -3) + struct.pack(">H", 110) + struct.pack("<bbb", 7, 40, -25) + bytes(2)
    return bench.take(0x18FEF001, data, number * PERIOD + GAP, extended=True)


def test_extended_ids_units_signs_factors_offsets_floats_and_big_endian(floats: Path) -> None:
    bench = Bench(general(floats))
    assert bench.source.ids == {CanId(0x18FEF000, True), CanId(0x18FEF001, True)}
    for number in range(1 - CYCLES, 2):
        assert floats_epoch(bench, number, 90.0) is None
    pose = floats_epoch(bench, 2, 90.0)
    assert pose is not None
    assert pose.position_ned == pytest.approx((-3000.0, 3250.0, 30.48))
    assert pose.velocity_body == pytest.approx((3.5 * 1852 / 3600, 1.0, -0.025))
    expected = Rotation.from_euler("ZYX", [math.pi / 2, 0.25, -0.025]).as_quat(scalar_first=True)
    assert abs(float(expected @ pose.attitude)) == pytest.approx(1.0)
    assert pose.sigma_position_ned == (0.5, 0.5, 0.5)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_float_that_is_no_number_is_dropped(floats: Path, bad: float) -> None:
    bench = Bench(general(floats))
    for number in range(1 - CYCLES, 2):
        floats_epoch(bench, number, 90.0)
    assert floats_epoch(bench, 2, bad) is None
    assert bench.counters["frame_not_finite"] == 1
    assert floats_epoch(bench, 3, 90.0) is None
    assert floats_epoch(bench, 4, 90.0) is not None


@given(
    st.lists(st.tuples(st.integers(0, 0x7FF) | st.sampled_from((STATUS, *IDS)), st.binary(max_size=8), st.booleans()))
)
@settings(deadline=None)
def test_arbitrary_frames_do_no_harm(frames: list[tuple[int, bytes, bool]]) -> None:
    bench = Bench()
    for step, (can_id, data, extended) in enumerate(frames):
        bench.take(can_id, data, step * MS, extended)
    assert all("\n" not in text for text in bench.source.problems(NS))
    assert bench.run(*range(1000, 1010))


# the health report


def test_what_is_missing_is_said() -> None:
    bench = Bench()
    assert bench.source.problems(400 * MS) == []
    assert bench.source.problems(NS) == ["no pose for 1.0 s", "none of the 8 messages mapped from sbg.dbc has come"]
    for number in range(1, 100):
        bench.epoch(number, places=(0, 1, 2, 4, 5, 6))
    assert bench.source.problems(NS) == ["no pose for 1.0 s", "SBG_ECAN_MSG_EKF_POS (0x134) has never come"]
    bench.run(*range(100, 120))
    assert bench.source.problems(120 * PERIOD) == []
    for number in range(120, 200):
        bench.epoch(number, places=(0, 1, 2, 3, 4, 5))
    problems = bench.source.problems(2 * NS)
    assert problems == ["no pose for 0.8 s", "SBG_ECAN_MSG_EKF_VEL_NED (0x137) has not come for 0.8 s"]


def test_an_epoch_that_breaks_off_is_said() -> None:
    bench = Bench()
    bench.run(1, 2)
    for number in range(3, 100):
        bench.epoch(number, places=(0, 1, 2, 3, 4, 5, 6) if number % 10 == 0 else (0, 1, 2, 3, 5, 6))
    assert bench.source.problems(NS) == [
        "no pose for 1.0 s",
        "epochs break off before SBG_ECAN_MSG_EKF_ALTITUDE (0x135): it is lost, or sent more rarely than the others",
    ]


def test_a_window_longer_than_the_period_is_said() -> None:
    bench = Bench(dbc_of(window_s=0.015))
    bench.run(*range(1, 6))
    assert bench.source.problems(6 * PERIOD) == ["epochs come every 10.0 ms: nav.dbc.window_s must be shorter"]


def test_one_short_step_says_nothing_of_the_window() -> None:
    """A busy device measures one instant late, and the next in time."""
    bench = Bench()
    bench.run(*range(1, 21))
    bench.epoch(21, us=FIRST_US + 21 * 10_000 + 3_000, late_ns=3 * MS)
    bench.run(22)
    assert bench.source.problems(22 * PERIOD + GAP) == []


@pytest.mark.parametrize(
    ("status", "parts"),
    [(0xF0, []), (0xE4, ["attitude"]), (0xD4, ["attitude"]), (0xB4, ["velocity"]), (0x74, ["position"]),
     (0x32, ["velocity", "position"])],
)  # fmt: skip
def test_what_the_ins_calls_not_valid_is_not_used_and_said(status: int, parts: list[str]) -> None:
    bench = Bench(status=status)
    assert len(bench.run(1, 2)) == (0 if parts else 1)
    assert bench.counters["epoch_invalid"] == (1 if parts else 0)
    assert bench.source.problems(3 * PERIOD) == [f"the INS says that its {part} is not valid" for part in parts]
    bench.status = 0xF4
    assert len(bench.run(3, 4)) == 2


def test_accepted_values_of_a_status_and_their_age() -> None:
    mode = ValiditySettings(
        signal="SBG_ECAN_MSG_STATUS_03.SOLUTION", mask=0x0F, accept=[3, 4], says="mode", holds_s=1.0
    )
    bench = Bench(dbc_of(valid=[mode]), status=None)
    assert bench.run(1, 2) == []
    assert "SBG_ECAN_MSG_STATUS_03 (0x102) has never come" in bench.source.problems(NS)
    for status, good in ((0xF3, True), (0xF2, False), (0x04, True)):
        bench.take(STATUS, struct.pack("<IH", status, 0), 3 * PERIOD)
        assert len(bench.run(3 + status)) == 0 or good
        assert bool(bench.source.problems(4 * PERIOD)) != good
    assert bench.run(300, 301, 302) == []
    assert "SBG_ECAN_MSG_STATUS_03 (0x102) has not come for 3.0 s" in bench.source.problems(303 * PERIOD)


# maps


def dbc_of(**changes: object) -> DbcSettings:
    """Return the shipped map with changes."""
    return msgspec.structs.replace(SBG, **changes)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (
            {"u": "FAST.HEADING"},
            "nav.dbc.signals.u: the DBC's unit 'deg' is not a known unit of speed, such as m/s; set unit or ",
        ),
        ({"u": "REST.STRANGE"}, "nav.dbc.signals.u: the DBC's unit 'furlong'"),
        ({"yaw": "REST.BARE"}, "nav.dbc.signals.yaw: the DBC's unit ''"),
        (
            {"yaw": SignalSettings(signal="REST.BARE", unit="turns")},
            "nav.dbc.signals.yaw.unit: 'turns' is not a known unit of angle, such as rad",
        ),
        ({"u": SignalSettings(signal="REST.V", unit="m")}, "nav.dbc.signals.u.unit: 'm' is not a known unit of speed"),
        (
            {"u": SignalSettings(signal="REST.V", plus=PartSettings(signal="REST.BARE", unit="kots"))},
            "nav.dbc.signals.u.plus.unit: 'kots' is not a known unit of speed, such as m/s (did you mean knot)",
        ),
        ({"u": "REST"}, "nav.dbc.signals.u: must be MESSAGE.SIGNAL, got 'REST'"),
        ({"u": "REST.U"}, "nav.dbc.signals.u: message REST has no signal 'U'"),
        ({"u": "BEST.V"}, "nav.dbc.signals.u: no message 'BEST' in the DBC"),
        ({"u": "CHOICE.SOMETIMES"}, "nav.dbc.signals.u: message CHOICE is multiplexed, which is not supported"),
        ({"north": "LONG.N"}, "nav.dbc.signals.north: message LONG has 64 bytes, more than a CAN frame holds"),
        ({"rol": "REST.V"}, "nav.dbc.signals.rol: not a pose field: 'rol' is not one of north, east"),
        ({"latitude": SignalSettings(signal="REST.BARE", unit="deg")}, "nav.dbc.signals: latitude: not used beside"),
    ],
)
def test_a_map_that_does_not_fit_is_one_line(floats: Path, changes: dict[str, str], said: str) -> None:
    with pytest.raises(DbcError) as error:
        Bench(general(floats, **changes))
    text = str(error.value)
    assert text.startswith(f"{floats}: {said}") or (said in text and text.startswith(f"{floats}: nav.dbc"))
    assert "\n" not in text


def test_one_signal_for_two_parts_of_a_pose_is_objected_to() -> None:
    assert Bench().source.objections() == []
    signals = SBG.signals | {"pitch": SBG.signals["roll"], "sigma_pitch": SBG.signals["sigma_roll"]}
    said = "nav.dbc.signals.pitch: is SBG_ECAN_MSG_EKF_EULER.ROLL, as roll is"
    assert Bench(dbc_of(signals=signals)).source.objections() == [said]


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"epoch": ["SBG_ECAN_MSG_EKF_INFO"]}, "nav.dbc.epoch: must also list SBG_ECAN_MSG_EKF_ALTITUDE, "),
        ({"epoch": ["SBG_ECAN_MSG_EKF_INFO"] * 2}, "nav.dbc.epoch: lists a message twice"),
        ({"epoch": ["X"]}, "nav.dbc.epoch: must also list "),
        ({"time": "SBG_ECAN_MSG_EKF_POS.LATITUDE"}, "nav.dbc.time: the DBC's unit 'deg' is not a known unit of time"),
        ({"valid": [ValiditySettings(signal="A.B", mask=1)]}, "nav.dbc.valid[0]: no message 'A' in the DBC"),
        (
            {"valid": [ValiditySettings(signal="SBG_ECAN_MSG_EKF_POS.LATITUDE", mask=1)]},
            "nav.dbc.valid[0]: SBG_ECAN_MSG_EKF_POS.LATITUDE is not an unsigned integer",
        ),
        ({"file": CONFIG / "none.dbc"}, "nav.dbc.file: No such file or directory"),
        ({"file": CONFIG / "ins.eds"}, "not a usable DBC: "),
        (
            {"signals": {"yaw": "SBG_ECAN_MSG_EKF_EULER.YAW"}},
            "nav.dbc.signals: a pose needs north, east, down or latitude",
        ),
    ],
)
def test_a_table_that_does_not_fit_is_one_line(changes: dict[str, object], said: str) -> None:
    with pytest.raises(DbcError) as error:
        Bench(dbc_of(**changes))
    text = str(error.value)
    assert text.startswith(f"{changes.get('file', DBC)}: {said}")
    assert "\n" not in text


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (
            {"time": TimeSettings(signal="SBG_ECAN_MSG_EKF_INFO.TIME_STAMP", wraps_at=1e-6)},
            "nav.dbc.time: wraps_at: 1e-06 is hardly more than the signal's step",
        ),
        (
            {"valid": [ValiditySettings(signal="SBG_ECAN_MSG_STATUS_03.SOLUTION", mask=1 << 40)]},
            "nav.dbc.valid[0]: mask: SBG_ECAN_MSG_STATUS_03.SOLUTION has 32 bits only",
        ),
    ],
)
def test_numbers_that_no_signal_has_are_refused(changes: dict[str, object], said: str) -> None:
    with pytest.raises(DbcError) as error:
        Bench(dbc_of(**changes))
    assert str(error.value).endswith(said)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('source = "dbc"', 'source = "canopen"', "nav.canopen: missing, as source is 'canopen'"),
        ('file = "sbg.dbc"', "", "nav.dbc.file: missing"),
        ("mask = 0x30", "", "mask: give mask, accept or both"),
        ("mask = 0x30", "mask = 0", "nav.dbc.valid[0].mask: 0 accepts every value"),
        ("mask = 0x30", "accept = []", "nav.dbc.valid[0].accept: no value would be accepted"),
        ("window_s = 0.008", "window_s = 0", "nav.dbc.window_s: must be more than 0 (seconds)"),
        ('roll = "SBG_ECAN_MSG_EKF_EULER.ROLL"', 'roll = {signal = "A.B", sine = 1}', "sine: unknown key"),
        ('roll = "SBG_ECAN_MSG_EKF_EULER.ROLL"', 'roll = {signal = "A.B", sign = 2}', "sign: "),
        ('roll = "SBG_ECAN_MSG_EKF_EULER.ROLL"', 'roll = {signal = "A.B", factor = -1.0}', "factor: must be positive"),
        ('roll = "SBG_ECAN_MSG_EKF_EULER.ROLL"', 'roll = {signal = "A.B", factor = 1.0, unit = "m"}', "factor: set"),
    ],
)
def test_wrong_keys_are_found_when_the_file_is_read(tmp_path: Path, old: str, new: str, said: str) -> None:
    text = (CONFIG / "onboard-sbg.toml").read_text()
    assert old in text
    file = tmp_path / "onboard.toml"
    file.write_text(text.replace(old, new))
    with pytest.raises(ConfigError) as error:
        load(file, OnboardConfig)
    assert said in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("reported", "wanted", "factor"),
    [
        ("deg", "rad", math.pi / 180), ("Degrees", "rad", math.pi / 180), ("\u00b0", "deg", 1.0), ("mrad", "rad", 1e-3),
        ("m.s-1", "m/s", 1.0), ("km/h", "m/s", 1 / 3.6), ("Knots", "m/s", 0.5144444444), ("cm", "m", 0.01),
        ("metres", "m", 1.0), ("us", "s", 1e-6), ("\u00b5s", "s", 1e-6), ("\u03bcs", "s", 1e-6), ("ms", "s", 1e-3),
        ("", "", 1.0),
    ],
)  # fmt: skip
def test_units(reported: str, wanted: str, factor: float) -> None:
    assert conversion(reported, wanted) == pytest.approx(factor, rel=1e-9)


def test_a_dbc_as_vendors_write_them_in_windows_1252_with_blanks_and_tables(tmp_path: Path) -> None:
    text = DBC.read_text().replace('"deg"', '"\u00b0"').replace('"us"', '"\u00b5s"').replace('"m/s"', '"m.s-1"')
    text += 'VAL_ 258 SOLUTION 244 "all is well" ;\n'
    for encoding in ("cp1252", "utf-8"):
        file = tmp_path / f"{encoding}.dbc"
        file.write_bytes(text.encode(encoding))
        assert len(Bench(dbc_of(file=file)).run(1, 2)) == 1


def test_a_dbc_with_the_list_of_symbols_of_its_format_and_with_comments(tmp_path: Path) -> None:
    """As cantools, or a maker's editor, writes it: the list has the word CM_, which begins no comment there."""
    written = cantools.database.load_file(DBC)
    assert isinstance(written, cantools.database.Database)
    file = tmp_path / "written.dbc"
    comment = 'CM_ BO_ 258 "status;\nBO_ 1 No_message: 8 INS";\nCM_ "all of it";\n'
    file.write_text(written.as_dbc_string() + comment, newline="")
    assert "\tCM_\r\n" in file.read_bytes().decode()
    assert DbcText(file).names == DbcText(DBC).names
    assert len(Bench(dbc_of(file=file)).run(1, 2)) == 1


# nothing but listening, and the simulated INS


def test_nothing_is_sent_and_nothing_of_canopen_is_listened_to() -> None:
    sent: list[tuple[int, bytes]] = []
    nav = NavSettings(source="dbc", dbc=SBG)
    source = make_source(nav, SITE, lambda can_id, data: sent.append((can_id, data)), Counter())
    assert isinstance(source, DbcSource)
    assert source.ids == {CanId(number, extended=False) for number in (STATUS, *IDS)}
    source.opened()
    for step in range(100):
        source.tick(step * NS)
    assert sent == []


@pytest.fixture
def buses() -> Iterator[tuple[can.BusABC, can.BusABC]]:
    with can.Bus("dbc", "virtual", ignore_config=True) as near, can.Bus("dbc", "virtual", ignore_config=True) as far:
        yield near, far


def test_the_simulated_ins_is_understood_across_its_clocks_wrap(buses: tuple[can.BusABC, can.BusABC]) -> None:
    near, far = buses
    ins = SimulatedDbcIns(far, DBC, SITE)
    bench = Bench(status=None)
    poses: dict[int, Pose] = {}
    for number in range(1500):
        t_ns = number * PERIOD
        position = (3.0 * number, -2.0 * number, 5.0 + 0.01 * number)
        attitude = quat_from_euler(0.1, -0.05, 0.01 * number)
        ins.send(UTC_OFFSET + t_ns, position, attitude, (1.5, 0.1, -0.2), without=("EKF_POS",) if number == 700 else ())
        while (message := near.recv(0)) is not None:
            pose = bench.take(message.arbitration_id, bytes(message.data), t_ns, message.is_extended_id)
            if pose is not None:
                poses[number] = pose
                np.testing.assert_allclose(pose.position_ned, position, atol=0.012)
                np.testing.assert_allclose(pose.velocity_body, (1.5, 0.1, -0.2), atol=0.012)
                in_site = rotation_matrix(SITE.turn_at(position)) @ rotation_matrix(attitude)
                np.testing.assert_allclose(rotation_matrix(pose.attitude), in_site, atol=2e-4)
                assert abs(pose.t_ns - t_ns) < 20_000
    assert sorted(set(range(1500)) - set(poses)) == [*range(CYCLES + 1), 700, 701]
    assert bench.counters["ins_clock_wild"] == 0


def test_the_bench_by_dbc_is_configured_on_both_sides(tmp_path: Path) -> None:
    bench = load(CONFIG / "bench-dbc.toml", BenchConfig)
    assert (bench.sim.ins, bench.sim.ins_dbc) == ("dbc", DBC)
    assert load(bench.onboard, OnboardConfig).nav.source == "dbc"
    file = tmp_path / "bench.toml"
    file.write_text((CONFIG / "bench-dbc.toml").read_text().replace("ins_dbc", "ins_eds"))
    with pytest.raises(ConfigError, match=r"sim.ins_dbc: missing, as ins is 'dbc'"):
        load(file, BenchConfig)


@pytest.mark.parametrize(
    "line",
    [
        "BO_ 5 Huge: 4000000000 X",
        'BO_ 5 M: 8 X\n SG_ s : 0|4000000000@1+ (1,0) [0|0] "" X',
        'BO_ 5 M: 8 X\n SG_ s : 4000000000|8@1+ (1,0) [0|0] "" X',
        'BO_ 5 M: 8 X\n SG_ m M : 0|8@1+ (1,0) [0|0] "" X\n SG_ s m0 : 8|8@1+ (1,0) [0|0] "" X\n'
        "SG_MUL_VAL_ 5 s m 0-4000000000;",
    ],
)
def test_a_dbc_that_asks_for_gigabytes_is_refused_before_it_is_parsed(tmp_path: Path, line: str) -> None:
    file = tmp_path / "absurd.dbc"
    file.write_text(f'VERSION ""\nBU_: X\n{line}\n')
    text = DbcText(file)
    with pytest.raises(DbcError, match="at most"):
        text.message(text.names[0])
