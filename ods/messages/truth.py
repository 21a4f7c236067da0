"""Ground truth, by the simulator."""

import msgspec

from ods.messages.fields import Count, Instant, Quaternion, Vector3


class TruthObject(msgspec.Struct, frozen=True):
    """A simulated object."""

    name: str
    position_ned: Vector3
    velocity_ned: Vector3
    radius_m: float
    in_sector: bool
    peak_db: float = 0.0
    """Highest expected level of its echo, dB over 1 count^2; 0 out of the sector."""
    background_db: float = 0.0
    """Expected level around it, likewise: the difference is its signal-to-noise ratio."""


class Truth(msgspec.Struct, frozen=True):
    """One ping of the simulator."""

    ping_number: Count
    t_ns: int
    """Transmit time."""
    t_sent_ns: int
    """When the ping's last byte had been written to the line."""
    position_ned: Vector3
    attitude: Quaternion
    objects: list[TruthObject]


class VehicleTruth(msgspec.Struct, frozen=True):
    """The simulated vehicle that obeys set points."""

    seq: Count
    t_ns: Instant
    scene_s: float
    """0 at the start of the mission."""
    position_ned: Vector3
    attitude: Quaternion
    velocity_ned: Vector3
    """Over ground, m/s."""
    stopped: bool
    """Its propeller stopped because no set points came."""
