"""Where the vehicle and the sonar's head were, as the messages to the planner tell it."""

from ods.messages import PoseAt
from ods.pose.buffer import PoseEstimate


def pose_at(estimate: PoseEstimate | None) -> PoseAt | None:
    """Return an estimate as messages have it."""
    if estimate is None:
        return None
    north, east, down = estimate.position_ned.tolist()
    w, x, y, z = estimate.attitude.tolist()
    v_north, v_east, v_down = estimate.velocity_ned.tolist()
    sigma_north, sigma_east, sigma_down = estimate.sigma_position.tolist()
    roll, pitch, yaw = estimate.sigma_attitude.tolist()
    return PoseAt(
        position_ned=(north, east, down),
        attitude=(w, x, y, z),
        velocity_ned=(v_north, v_east, v_down),
        sigma_position=(sigma_north, sigma_east, sigma_down),
        sigma_attitude=(roll, pitch, yaw),
        extrapolated_s=estimate.extrapolated_s,
    )
