"""The tracker's scan of a ping: the pipeline's message, and the poses while its echoes came back."""

from collections.abc import Callable
from typing import NamedTuple

from ods.messages import Detection, Detections
from ods.pose.buffer import PoseEstimate
from ods.tracker.measurement.coverage.looked import observed_ranges_of
from ods.tracker.measurement.planes import merge_planes
from ods.tracker.measurement.pose import motion_during_reception
from ods.tracker.measurement.scan import Scan, echo_table_of, echoes_of, not_swept_of, unseen_of, vehicle_at

HeadAt = Callable[[int], PoseEstimate | None]
"""The pose of the sonar's head at a time, ns; None where none is known."""


class Received(NamedTuple):
    """A scan, and what had to be left out of it."""

    scan: Scan
    dropped: int
    """Detections that are of no use."""
    at_rest: bool
    """The head counts as stationary while the echoes came back, as there is no pose."""


def received(
    message: Detections, sent: PoseEstimate | None, head_at: HeadAt, utc_ns: int, skipped_pings: int = 0
) -> Received:
    """Return the scan of a ping as the head would have measured it at transmission.

    sent: the head's pose then; skipped_pings: those since the one before that were not processed.
    """
    echoes, dropped = echoes_of(echo_table_of(_all_echoes(message)))
    if message.sector.plane_half_rad > 0.0:
        echoes = merge_planes(echoes, message.sector.plane_half_rad)
    vehicle, fan_turn, at_rest = None, 0.0, False
    if sent is not None:
        seen_from = sent
        listening = motion_during_reception.poses_of(sent, message.sector.range_max_m, message.sound_speed, head_at)
        at_rest = listening is None
        if listening is not None:
            echoes, fan_turn = motion_during_reception.at_transmission(echoes, listening)
            seen_from = listening.end
        # the bearings' error is that of the attitude at reception
        vehicle = vehicle_at(sent.position_ned, sent.attitude, sent.sigma_position, seen_from.sigma_attitude)
    scan = Scan(
        message.t_ns,
        utc_ns,
        vehicle,
        message.sector,
        echoes,
        message.usable,
        message.processed_ranges_m,
        fan_turn,
        unseen_of(message.unseen),
        observed_ranges_of(message),
        skipped_pings,
        not_swept_of(message.unseen),
    )
    return Received(scan, dropped, at_rest)


def _all_echoes(message: Detections) -> list[Detection]:
    """Return all echoes, faint ones too, as many pings together distinguish an object from the bottom; in the order of
    their bearings."""
    if not message.faint:
        return message.detections
    return sorted(message.detections + message.faint, key=lambda echo: echo.bearing_rad)
