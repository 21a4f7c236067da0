"""The pipeline from messages to detections, without sockets, files or a clock.

The process (`service`), files (`ods track`) and recordings (`ods replay`) give it the same messages.
"""

from collections import Counter

import msgspec
import numpy as np

from ods.base.frames.mounting import Mounting
from ods.messages import Detections, Ping, Pose
from ods.pipeline.chain import Chain
from ods.pipeline.interference.repeated_image import RepeatedImage
from ods.pipeline.prepared.plan import PingError
from ods.pipeline.prepared.speckle import KeepAlive
from ods.pipeline.settings import PipelineConfig
from ods.pipeline.steadiness import Steadiness
from ods.pipeline.swept import SweptSonar
from ods.pose.buffer import PoseBuffer, PoseEstimate
from ods.pose.head import head_of

SOUND_SPEEDS = (1350.0, 1650.0)
"""Sound speeds of water, m/s: 1403 in pure water at 0 deg C, 1560 at the bottom of the Red Sea, a little more in
brine."""


class PingProcessor:
    """The chain and the poses of the sonar's head.

    `counters`: those of the pose buffer; where a stage compares pings, and of range images, pings_without_pose; of a
    mechanically scanned sonar beams_without_pose.
    """

    def __init__(
        self, settings: PipelineConfig, counters: "Counter[str] | None" = None, alive: KeepAlive | None = None
    ) -> None:
        """alive: see `Chain`. Raises PluginError, StageError."""
        self.counters: Counter[str] = Counter() if counters is None else counters
        self.chain = Chain(settings.pipeline, alive=alive)
        self._mounting = Mounting(settings.mounting)
        self._poses = PoseBuffer(*msgspec.structs.astuple(settings.pose))
        self._poses.counters = self.counters
        self._repeated = RepeatedImage()
        self._steadiness = Steadiness()
        self._swept = SweptSonar(self._head_at)
        self._poses_until, self._poses_heard = -1, 0

    def add_pose(self, pose: Pose) -> None:
        """Take in a pose."""
        self._poses_until = pose.seq
        self._poses_heard += 1
        self._repeated.add_pose(pose)
        self._poses.insert(pose)

    def process(self, ping: Ping) -> Detections:
        """Return the detections of a ping. Raises PingError, StageError."""
        repeated = self._repeated.judge(ping) if ping.range_grid is None else ""  # an even bottom is always the same
        caution = "; ".join(filter(None, (repeated, self._steadiness.judge(ping))))
        _refuse_sound_speed(ping)
        _refuse_negative(ping)
        found = self._found(ping) if ping.sweep is None else self._found_by_sweep(ping)
        return msgspec.structs.replace(
            found, caution=caution, poses_until=self._poses_until, poses_heard=self._poses_heard
        )

    def _found(self, ping: Ping) -> Detections:
        pose = self._head_at(ping.t_ns)
        self.counters["pings_without_pose"] += pose is None and (self.chain.over_pings or ping.range_grid is not None)
        return self.chain.process(ping, pose=pose)

    def _found_by_sweep(self, ping: Ping) -> Detections:
        if self.chain.over_pings:
            raise PingError(
                "a stage compares successive pings, which is not possible with a mechanically scanned sonar"
            )
        image = self._swept.image(ping)
        self.counters["beams_without_pose"] = self._swept.without_pose
        return self._swept.detections(image, self.chain.process(image.ping))

    def _head_at(self, t_ns: int) -> PoseEstimate | None:
        return head_of(self._poses.at(t_ns), self._mounting)


def _refuse_sound_speed(ping: Ping) -> None:
    """Raises PingError: ranges follow from it, so all of them would be wrong."""
    low, high = SOUND_SPEEDS
    if ping.sound_speed > 0.0 and not low < ping.sound_speed < high:
        raise PingError(f"sound_speed: {ping.sound_speed:g} m/s is not that of water, between {low:g} and {high:g}")


def _refuse_negative(ping: Ping) -> None:
    """Raises PingError where decibels, say, are declared as amplitudes: the image would show no echo."""
    if ping.dtype != "f4" or ping.scale != "linear" or len(ping.data) % 4:
        return
    samples = np.frombuffer(ping.data, "<f4")
    if 2 * np.count_nonzero(samples < 0.0) > samples.size:
        raise PingError("most samples are below 0, which a linear amplitude cannot be: are they decibels (scale = db)?")
