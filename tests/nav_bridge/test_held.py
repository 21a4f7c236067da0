"""Signals at rates of their own, and values split over two signals: against a motion in closed form."""

import math
import struct
from collections import Counter
from pathlib import Path

import pytest

from ods.base.geodesy import LocalFrame
from ods.messages import Pose
from ods.nav_bridge.can.frame import Frame
from ods.nav_bridge.dbc.file import DbcError
from ods.nav_bridge.dbc.source import DbcSource
from ods.nav_bridge.settings import DbcSettings, HeldSettings, NavSettings, PartSettings, SignalSettings
from ods.nav_bridge.source import SourceHost
from tests.nav_bridge.made_up_clock import utc_ahead

TEXT = """VERSION ""
BU_: INS
BO_ 1 ATTITUDE: 8 INS
 SG_ T : 0|16@1+ (1,0) [0|0] "ms" INS
 SG_ ROLL : 16|16@1- (0.0001,0) [0|0] "rad" INS
 SG_ PITCH : 32|16@1- (0.0001,0) [0|0] "rad" INS
 SG_ YAW : 48|16@1- (0.0001,0) [0|0] "rad" INS
BO_ 2 DEPTH: 4 INS
 SG_ D : 0|32@1- (0.001,0) [0|0] "m" INS
BO_ 3 DVL: 6 INS
 SG_ U : 0|16@1- (0.001,0) [0|0] "m/s" INS
 SG_ V : 16|16@1- (0.001,0) [0|0] "m/s" INS
 SG_ W : 32|16@1- (0.001,0) [0|0] "m/s" INS
BO_ 4 WHOLE: 4 INS
 SG_ LAT : 0|16@1- (1,0) [0|0] "deg" INS
 SG_ LON : 16|16@1- (1,0) [0|0] "deg" INS
BO_ 5 FRACTION: 8 INS
 SG_ LAT : 0|32@1- (1E-9,0) [0|0] "deg" INS
 SG_ LON : 32|32@1- (1E-9,0) [0|0] "deg" INS
BO_ 6 PLACE: 8 INS
 SG_ N : 0|32@1- (0.001,0) [0|0] "m" INS
 SG_ E : 32|32@1- (0.001,0) [0|0] "m" INS
"""
MS, NS = 1_000_000, 1_000_000_000
PERIOD = 10 * MS
ATTITUDE = {"roll": "ATTITUDE.ROLL", "pitch": "ATTITUDE.PITCH", "yaw": "ATTITUDE.YAW"}
PLACE: dict[str, str | SignalSettings] = {"north": "PLACE.N", "east": "PLACE.E", "down": "DEPTH.D"}
DVL = {"u": "DVL.U", "v": "DVL.V", "w": "DVL.W"}
YAW, PITCH, SPEED = 1.2, -0.2, 2.5
VELOCITY = SPEED * math.cos(PITCH) * math.cos(YAW), SPEED * math.cos(PITCH) * math.sin(YAW), -SPEED * math.sin(PITCH)
"""North, east, down; it never changes."""


def dbc(folder: Path, **changes: object) -> DbcSettings:
    file = folder / "rates.dbc"
    file.write_text(TEXT)
    usual = {"file": file, "signals": ATTITUDE | PLACE | DVL, "time": "ATTITUDE.T"}
    return DbcSettings(**(usual | changes))  # type: ignore[arg-type]


class Vehicle:
    """Moves evenly; each message is sent at its own rate, a little after the attitude."""

    def __init__(self, settings: DbcSettings) -> None:
        self.counters: Counter[str] = Counter()
        host = SourceHost(LocalFrame(57.0, 9.9), lambda *_: None, self.counters, 0, utc_ahead(0))
        self.source = DbcSource(NavSettings(source="dbc", dbc=settings, stale_s=0.2), settings, host)

    def take(self, can_id: int, data: bytes, t_ns: int) -> Pose | None:
        return self.source.take(Frame(can_id, False, data, t_ns))

    def fly(self, number: int, *also: str) -> Pose | None:
        """Send one attitude, then the named messages; return the pose."""
        t_ns = number * PERIOD
        reported = [round(value * 1e4) for value in (0.0, PITCH, YAW)]
        pose = self.take(1, struct.pack("<Hhhh", number * 10, *reported), t_ns)
        north, east, down = (round(1000 * part * t_ns / NS) for part in VELOCITY)
        data = {
            "DEPTH": (2, struct.pack("<i", down)),
            "DVL": (3, struct.pack("<hhh", round(1000 * SPEED), 0, 0)),
            "PLACE": (6, struct.pack("<ii", north, east)),
        }
        for name in also:
            can_id, payload = data[name]
            pose = self.take(can_id, payload, t_ns) or pose
        return pose


def test_held_values_are_carried_on_and_their_age_is_in_the_standard_deviation(tmp_path: Path) -> None:
    held = {"PLACE": HeldSettings(growth_m_s=0.5), "DEPTH": HeldSettings(growth_m_s=0.3), "DVL": HeldSettings()}
    vehicle = Vehicle(dbc(tmp_path, held=held))
    poses = 0
    for number in range(200):
        rates = {"PLACE": 20, "DEPTH": 10, "DVL": 7}
        pose = vehicle.fly(number, *(name for name, every in rates.items() if number % every == 0))
        if pose is None:
            continue
        poses += 1
        t_s = pose.t_ns / NS
        assert pose.position_ned == pytest.approx([part * t_s for part in VELOCITY], abs=3e-3)
        ages = {name: (number - 1) % every * 0.01 + 0.01 for name, every in rates.items()}
        plane, down = math.hypot(0.5, 0.5 * ages["PLACE"]), math.hypot(0.5, 0.3 * ages["DEPTH"])
        assert pose.sigma_position_ned == pytest.approx((plane, plane, down), abs=1e-6)
        assert pose.sigma_attitude == (0.005, 0.005, 0.005)
    assert poses == 199  # the first instant proves nothing
    assert vehicle.source.problems(2 * NS) == []


def test_what_is_too_old_is_no_pose_and_is_said_by_name(tmp_path: Path) -> None:
    vehicle = Vehicle(dbc(tmp_path, held={name: HeldSettings(max_age_s=0.25) for name in ("PLACE", "DEPTH", "DVL")}))
    for number in range(150):
        pose = vehicle.fly(number, *("PLACE", "DVL") if number > 50 else ("PLACE", "DVL", "DEPTH"))
        assert (pose is not None) == (0 < number <= 75)
    assert vehicle.source.problems(190 * PERIOD) == [
        "no pose for 1.1 s",
        "ATTITUDE (0x1) has not come for 0.4 s",
        "PLACE (0x6): last came 0.4 s ago, nav.dbc.held.PLACE.max_age_s is 0.25",
        "DEPTH (0x2): last came 1.4 s ago, nav.dbc.held.DEPTH.max_age_s is 0.25",
        "DVL (0x3): last came 0.4 s ago, nav.dbc.held.DVL.max_age_s is 0.25",
    ]
    assert vehicle.counters["epoch_aged"] == 74
    assert vehicle.fly(150, "DEPTH") is None
    assert vehicle.fly(151) is not None


def test_a_held_heading_makes_the_attitude_less_sure(tmp_path: Path) -> None:
    text = TEXT.replace(
        "BO_ 2 DEPTH", 'BO_ 7 COMPASS: 2 INS\n SG_ YAW : 0|16@1- (0.0001,0) [0|0] "rad" INS\nBO_ 2 DEPTH'
    )
    signals = ATTITUDE | PLACE | DVL | {"yaw": "COMPASS.YAW"}
    held = {name: HeldSettings(growth_rad_s=0.2) for name in ("COMPASS", "PLACE", "DEPTH", "DVL")}
    settings = dbc(tmp_path, signals=signals, held=held)
    settings.file.write_text(text)
    vehicle = Vehicle(settings)
    vehicle.take(7, struct.pack("<h", 12000), 0)
    vehicle.fly(0, "PLACE", "DEPTH", "DVL")
    vehicle.fly(1)
    pose = vehicle.fly(20)
    assert pose is None  # an instant is missing: proven by the next
    pose = vehicle.fly(21)
    assert pose is not None
    assert pose.sigma_attitude == pytest.approx((0.005, 0.005, math.hypot(0.005, 0.2 * 0.21)), abs=1e-6)


def split(**changes: object) -> dict[str, object]:
    """Return a map of latitude and longitude in whole degrees and fractions, in two messages of one instant."""
    signals: dict[str, object] = {
        "latitude": SignalSettings(signal="WHOLE.LAT", plus="FRACTION.LAT"),
        "longitude": SignalSettings(signal="WHOLE.LON", plus=PartSettings(signal="FRACTION.LON")),
        "altitude": SignalSettings(signal="DEPTH.D", sign=-1),
    }
    held = {"DEPTH": HeldSettings(), "DVL": HeldSettings()}
    return {"signals": ATTITUDE | signals | DVL, "held": held} | changes


def test_whole_and_fraction_in_two_frames_are_combined_within_one_instant_only(tmp_path: Path) -> None:
    """Both cross a whole degree again and again: a fraction of another instant would be 111 km away."""
    vehicle = Vehicle(dbc(tmp_path, **split()))
    vehicle.take(2, struct.pack("<i", 0), 0)
    vehicle.take(3, struct.pack("<hhh", 0, 0, 0), 0)
    found = 0
    for number in range(300):
        t_ns = number * PERIOD
        if number % 20 == 0:
            vehicle.take(2, struct.pack("<i", 0), t_ns)
            vehicle.take(3, struct.pack("<hhh", 0, 0, 0), t_ns)
        latitude = 57.0 + (1e-5 if number % 2 else -1e-5)
        longitude = 10.0 + (-2e-5 if number % 3 else 1e-5)
        degrees = math.floor(latitude), math.floor(longitude)
        rest = [round((value - whole) * 1e9) for value, whole in zip((latitude, longitude), degrees, strict=True)]
        sent = {
            1: struct.pack("<Hhhh", number * 10, 0, 0, 0), 4: struct.pack("<hh", *degrees), 5: struct.pack("<ii", *rest)
        }  # fmt: skip
        for step, (can_id, data) in enumerate(sent.items()):
            if (can_id, number % 37) in ((4, 5), (5, 11)):
                continue  # lost
            pose = vehicle.take(can_id, data, t_ns + step * MS // 4)
            if pose is not None:
                found += 1
                north, east, down = LocalFrame(57.0, 9.9).ned(latitude, longitude, 0.0).tolist()
                assert pose.position_ned == pytest.approx((north, east, down), abs=1e-3)
    assert found == 300 - 10 - 2 * 15  # to find the order, a frame lost meanwhile; then two for each loss


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"held": {"DEEP": HeldSettings()}}, "nav.dbc.held.DEEP: no message 'DEEP' in the DBC (did you mean DEPTH)"),
        ({"held": {"WHOLE": HeldSettings()}}, "nav.dbc.held.WHOLE: cannot be held, as it carries no signal of "),
        ({"held": {"ATTITUDE": HeldSettings()}}, "nav.dbc.held.ATTITUDE: cannot be held, as it carries nav.dbc.time"),
        (
            {"time": None, "held": {name: HeldSettings() for name in ("ATTITUDE", "PLACE", "DEPTH", "DVL")}},
            "nav.dbc.held: at least one message must not be held: its arrival triggers a pose",
        ),
        (
            split(held={"WHOLE": HeldSettings()}),
            "nav.dbc.signals.latitude: its two signals belong to one instant only if neither",
        ),
        (
            {"held": {"DVL": HeldSettings()}, "epoch": ["ATTITUDE", "PLACE", "DEPTH", "DVL"]},
            "nav.dbc.epoch: lists a message that nav.dbc.held",
        ),
    ],
)
def test_what_cannot_be_held_is_one_line(tmp_path: Path, changes: dict[str, object], said: str) -> None:
    with pytest.raises(DbcError) as error:
        Vehicle(dbc(tmp_path, **changes))
    assert said in str(error.value)
    assert "\n" not in str(error.value)
