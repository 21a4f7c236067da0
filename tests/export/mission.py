"""A few messages by hand, of a vehicle 100 m north and 20 m east of the site, heading east at 10 m depth."""

import math

from ods.base.frames.mounting import Mounting, MountingSettings
from ods.messages import ClosestApproach, Detection, Detections, Health, Obstacle, ObstacleList, Ping, Pose, Sector

UTC_NS = 1_700_000_005_250_000_000
T_NS = 5_250_000_000
A = math.sqrt(0.5)
MOUNTED = Mounting(MountingSettings(position_m=(2.0, 0.5, 1.0), pitch_deg=-90.0))
"""Two metres ahead, half to starboard, one down; it looks down."""

PING = Ping(
    seq=3, ping_number=82, t_ns=T_NS, t_rx_ns=T_NS + 1, utc_ns=UTC_NS, beams=2, samples=3, dtype="u2",
    data=b"\x01\x00\x02\x00\x03\x00\x04\x00\x05\x00\x06\x01", bearing_rad=[-math.pi / 6, math.pi / 6], range0_m=0.0,
    dr_m=0.5, sound_speed=1490.0, beam_width_rad=[0.02, 0.02], frequency_hz=450e3,
)  # fmt: skip
POSE = Pose(
    seq=9, t_ns=T_NS, utc_ns=UTC_NS, position_ned=(100.0, 20.0, 10.0), attitude=(A, 0.0, 0.0, A),
    velocity_body=(1.5, 0.2, -0.1), sigma_position_ned=(1.0, 2.0, 3.0), sigma_attitude=(0.1, 0.2, 0.3), altitude_m=7.5,
)  # fmt: skip
ROCK = Obstacle(
    id=7, state="active", position_ned=(110.0, 60.0, 12.0), velocity_ned=(0.1, 0.2, 0.3), radius_m=1.5,
    sigma_position=(0.2, 0.4, 3.0), sigma_velocity=(0.01, 0.02, 0.03), sigma_radius=0.1, first_seen_utc_ns=UTC_NS - 9,
    last_seen_utc_ns=UTC_NS, times_seen=9, existence=0.5, covariance_ne=0.01, cpa=ClosestApproach(4.0, 2.5, 0.3),
)  # fmt: skip
LIST = ObstacleList(
    seq=4, ping_number=82, t_ns=T_NS, utc_ns=UTC_NS, t_rx_ns=T_NS, valid=False, reasons=["no pose", "sonar: silent"],
    obstacles=[ROCK],
)  # fmt: skip
DETECTIONS = Detections(
    seq=3, ping_number=82, t_ns=T_NS, t_rx_ns=T_NS, utc_ns=UTC_NS, sound_speed=1490.0,
    sector=Sector(1.0, 50.0, -0.5, 0.5, 0.1),
    detections=[Detection(30.0, 0.25, 1.5, 9.0, 4.0, 12.0, 20, 1.0, 0.05, 0.1, 0.01, 0.2)],
)  # fmt: skip
HEALTH = Health(
    process="sonar", pid=11, seq=2, t_ns=T_NS, utc_ns=UTC_NS, ready=True, problems=["no data, for 3 s"],
    counters={"bad_record": 2}, rates_hz={}, ages_s={}, lags={}, cpu_percent=3.5, rss_mb=40.0,
)  # fmt: skip
ALL = (HEALTH, POSE, PING, DETECTIONS, LIST)
