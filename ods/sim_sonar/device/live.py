"""The live devices of the bench, each in a thread at its own pace: the sonar on its line, the INS on CAN."""

import logging
import queue
import threading
from collections.abc import Callable

import numpy as np

from ods.base import clock
from ods.base.arrays import Floats
from ods.messages import Truth
from ods.sim_sonar.device.remote_control_server import Line
from ods.sim_sonar.device.simulated_sonar import SimulatedSonar
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.ins.canopen_ins import SimulatedIns
from ods.sim_sonar.ins.dbc_ins import SimulatedDbcIns
from ods.sim_sonar.ins.nmea_ins import SimulatedNmeaIns
from ods.sim_sonar.ins.place import InsPlace, over_bottom
from ods.sim_sonar.ins.sigmas import USUAL_SIGMAS
from ods.sim_sonar.receiver.blindness import BLINDNESS
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.settings import INS_STEP_M, FaultSettings, SimSettings

log = logging.getLogger(__name__)

LEAST_PATIENCE_S = 0.12
PATIENCE_OF_PERIOD = 0.8
"""Time that the reader of a telegram may take, s, or this share of the time between two pings if that is more. A line
would not wait, but its driver holds five pings."""


class Mission:
    """Mission time: 0 at `start_ns` (CLOCK_MONOTONIC), UTC as it was then, and the faults that happen on the way."""

    def __init__(self, start_ns: int, faults: list[FaultSettings]) -> None:
        self.start_ns = start_ns
        self.utc_offset_ns = clock.utc_offset_ns()
        self._faults = faults

    def seconds(self, t_ns: int) -> float:
        """Return the mission time of a monotonic instant, s."""
        return (t_ns - self.start_ns) / clock.NS

    def faulty(self, kind: str, t_ns: int) -> bool:
        """Return whether a fault of this kind is on."""
        seconds = self.seconds(t_ns)
        return any(f.kind == kind and f.at_s <= seconds < f.at_s + f.for_s for f in self._faults)


class Device(threading.Thread):
    """A thread that does one step after another until stopped, and remembers why it ended if it fails."""

    def __init__(self, name: str, step: Callable[[], int]) -> None:
        super().__init__(name=name, daemon=True)
        self._step = step
        self._stopping = threading.Event()
        self.failure = ""

    def run(self) -> None:
        """Call `step`, which returns the monotonic time of its next turn, on time and again."""
        due_ns = clock.monotonic_ns()
        try:
            while not self._stopping.wait(max(0.0, (due_ns - clock.monotonic_ns()) / clock.NS)):
                due_ns = self._step()
        except Exception as error:
            log.exception("%s failed", self.name)
            self.failure = f"{self.name}: {error}"

    def stop(self) -> None:
        """End the thread."""
        self._stopping.set()
        self.join(2.0)


class LiveSonar:
    """The simulated sonar: an image at every ping period, sent as its far end speaks when its echoes have come in.

    What clients ask for holds from the next ping on.
    """

    def __init__(
        self, images: ImageSimulator, end: SimulatedSonar, settings: SimSettings, mission: Mission, line: Line
    ) -> None:
        """`images`: those after switching on."""
        self.truths: queue.SimpleQueue[Truth] = queue.SimpleQueue()
        self.pings_late = 0
        self._images = images
        self._offset_ns = round(settings.sonar_clock_offset_s * clock.NS)
        self._mission = mission
        self._line = line
        self._plugged = True
        self._end = end
        self._controls = end.controls
        self._latency_ms = settings.sonar_latency_ms
        self._set_times()
        self._ping_number = 0
        self._transmit_ns = mission.start_ns
        self._telegram: list[bytes] = []
        self._render()

    def step(self) -> int:
        """Send the telegram whose time has come, render the next; return when that one is due."""
        due_ns = self._transmit_ns + self._listen_ns
        if clock.monotonic_ns() < due_ns:
            return due_ns
        self._plug_as_the_faults_say(due_ns)
        if not self._mission.faulty("sonar_silent", due_ns) and self._plugged:
            telegram = self._end.wanted(self._telegram)
            if telegram and self._mission.faulty("sonar_garbage", due_ns):
                telegram = [_garbage(self._ping_number, sum(map(len, telegram)))]
            if telegram:
                self._line.write(telegram, max(LEAST_PATIENCE_S, PATIENCE_OF_PERIOD * self._period_ns / clock.NS))
                self.truths.put(self._truth(clock.monotonic_ns()))
        self._ping_number += 1
        self._transmit_ns += self._period_ns
        self._end.listen(self._device_utc_ns(clock.monotonic_ns()))
        self._obey()
        while clock.monotonic_ns() > self._transmit_ns + self._listen_ns + self._period_ns:
            self.pings_late += 1
            self._transmit_ns += self._period_ns
        self._render()
        return self._transmit_ns + self._listen_ns

    def _obey(self) -> None:
        """Apply the requested settings."""
        if self._end.controls == self._controls:
            return
        self._controls = self._end.controls
        self._images = self._end.images()
        self._set_times()

    def _set_times(self) -> None:
        sonar = self._images.sonar
        self._period_ns = round(self._end.period_s(sonar) * clock.NS)
        listen_s = 2.0 * sonar.range_max_m / sonar.sound_speed + 1e-3 * self._latency_ms
        self._listen_ns = round(listen_s * clock.NS)

    def _device_utc_ns(self, t_ns: int) -> int:
        return t_ns + self._mission.utc_offset_ns + self._offset_ns

    def _render(self) -> None:
        seconds, utc_ns = self._mission.seconds(self._transmit_ns), self._device_utc_ns(self._transmit_ns)
        now_ns = self._transmit_ns
        self._images.blindness = [spoil for kind, spoil in BLINDNESS.items() if self._mission.faulty(kind, now_ns)]
        self._telegram = self._end.telegram(self._images, seconds, self._ping_number, self._transmit_ns, utc_ns)

    def _truth(self, sent_ns: int) -> Truth:
        seconds = self._mission.seconds(self._transmit_ns)
        vehicle = self._images.scene.vehicle_at(seconds)
        north, east, down = vehicle.position_ned.tolist()
        w, x, y, z = vehicle.attitude.tolist()
        return Truth(
            ping_number=self._ping_number,
            t_ns=self._transmit_ns,
            t_sent_ns=sent_ns,
            position_ned=(north, east, down),
            attitude=(w, x, y, z),
            objects=self._images.truth(seconds, self._ping_number),
        )

    def _plug_as_the_faults_say(self, now_ns: int) -> None:
        unplugged = self._mission.faulty("serial_unplugged", now_ns)
        if unplugged and self._plugged:
            self._line.unplug()
        elif not unplugged and not self._plugged:
            self._line.plug()
        self._plugged = not unplugged


def _garbage(seed: int, count: int) -> bytes:
    return np.random.default_rng(seed).bytes(count)


class LiveIns:
    """The simulated INS: one epoch every period."""

    def __init__(
        self,
        scene: Scene,
        settings: SimSettings,
        mission: Mission,
        ins: SimulatedIns | SimulatedDbcIns | SimulatedNmeaIns,
        place: InsPlace,
    ) -> None:
        self._scene = scene
        self._place = place
        self._mission = mission
        self._ins = ins
        self._offset_ns = round(settings.ins_clock_offset_s * clock.NS)
        self._period_ns = round(clock.NS / settings.pose_rate_hz)
        self._due_ns = clock.monotonic_ns()
        self._noise = np.random.default_rng(scene.file.seed)

    def step(self) -> int:
        """Send the pose of now; return when the next is due."""
        now = clock.monotonic_ns()
        if not self._mission.faulty("ins_silent", now):
            device_utc_ns = now + self._mission.utc_offset_ns + self._offset_ns
            beyond_ms = device_utc_ns % clock.MS  # TIME_OF_DAY holds whole milliseconds
            place, attitude, velocity_body = self._place.reported(self._scene, self._mission.seconds(now - beyond_ms))
            over_bottom_m = self._over_bottom(place)
            if self._mission.faulty("ins_steps", now):
                place = place + INS_STEP_M
            self._ins.send(device_utc_ns - beyond_ms, place, attitude, velocity_body, over_bottom=over_bottom_m)
        self._due_ns = max(self._due_ns + self._period_ns, now)
        return self._due_ns

    def _over_bottom(self, place: Floats) -> float | None:
        true = over_bottom(self._scene, place)
        return None if true is None else true + USUAL_SIGMAS.over_bottom * self._noise.standard_normal()
