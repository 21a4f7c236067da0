"""A simulated Blueprint Oculus: obeys fire messages, sends simple ping results by TCP and its status by UDP."""

import dataclasses
import math
import socket

import msgspec

from ods.base.clock import NS
from ods.sim_sonar.device.lines.tcp_line import HOST, TcpLine
from ods.sim_sonar.device.sonars import oculus_messages as wire
from ods.sim_sonar.device.sonars.oculus_messages import FireMessage, ImageHead
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.sonar.model import SonarModel, make_sonar
from ods.sim_sonar.sonar.settings import SonarFile

LOW_MODE, HIGH_MODE = 1, 2
HIGH_RANGE_M = 40.0
HIGH_FREQUENCY, HIGH_OPENING, HIGH_BEAM_WIDTH = 1.6, 70.0 / 130.0, 0.6
"""The high mode's, as shares of the low one's: an M750d has 750 kHz, 130 and 1 degrees there, 1.2 MHz, 70 and 0.6."""
PERIODS_S = {0: 1 / 10, 1: 1 / 15, 2: 1 / 40, 3: 1 / 5, 4: 1 / 2}
"""Shortest time from ping to ping, by the number in the fire message; every other number is standby."""
NOMINAL_GAIN_PERCENT, DB_PER_PERCENT = 50.0, 0.5
"""Gain of the scene's levels, and this simulator's law: the real one is not known."""
NEAREST_RANGE_M = 1.0
UPTIME_S = 1000.0
"""Since when the sonar has been on when the mission starts."""
STATUS_PERIOD_NS = NS
PATIENCE_S = 0.01


class SimulatedOculus:
    """The far end of an Oculus: see `SimulatedSonar`. Before its first fire message it is in standby."""

    def __init__(self, file: SonarFile, nominal: ImageSimulator, line: TcpLine, status_port: int) -> None:
        """`file`: the low mode; `nominal`: its images."""
        self._nominal = nominal
        self._line = line
        self._modes = {LOW_MODE: nominal.sonar, HIGH_MODE: _high_mode(file)}
        self.controls: FireMessage | None = None
        self._stream = bytearray()
        self._client = 0
        self._status_port = status_port
        self._status_due_ns = 0
        self._on_ns: int | None = None
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    def listen(self, device_ns: int) -> None:
        """Obey what has come; announce the sonar on the network once a second."""
        self._stream += self._line.read()
        if self._line.connections != self._client:
            self._client = self._line.connections
        while (fire := wire.take_fire(self._stream)) is not None:
            if self._can(fire):
                self.controls = fire
        if device_ns >= self._status_due_ns:
            self._status_due_ns = device_ns + STATUS_PERIOD_NS
            client = HOST if self._line.connected else "0.0.0.0"
            self._socket.sendto(wire.status(HOST, client), (HOST, self._status_port))
            if self._standby:
                self._line.write([wire.dummy()], PATIENCE_S)

    def wanted(self, telegram: list[bytes]) -> list[bytes]:
        """Return what goes out: nothing in standby."""
        return [] if self._standby or not self._line.connected else telegram

    def images(self) -> ImageSimulator:
        """Return the images of the range, mode, beams and gain that have been asked for."""
        fire = self.controls
        if fire is None:
            return self._nominal
        model = self._modes[fire.mode]
        samples = 1 + math.floor((fire.range_m - model.range0_m) / model.dr_m + 0.5)
        step = 1 if fire.wants_512 else 2
        sonar = dataclasses.replace(
            model,
            samples=min(max(samples, 1), model.samples),
            bearing_rad=model.bearing_rad[::step].copy(),
            elevation_rad=model.elevation_rad[::step].copy(),
        )
        gain_db = DB_PER_PERCENT * (fire.gain_percent - NOMINAL_GAIN_PERCENT)
        return ImageSimulator(sonar, self._nominal.scene, gain_db=gain_db)

    def period_s(self, sonar: SonarModel) -> float:
        """Return the time from ping to ping: the asked-for rate, or what the range takes."""
        asked_s = PERIODS_S.get(self.controls.ping_rate, 1.0) if self.controls else 1.0
        return max(asked_s, sonar.ping_period_s)

    def telegram(self, images: ImageSimulator, t_s: float, number: int, sent_ns: int, device_ns: int) -> list[bytes]:
        """Return the result of the ping sent at scene time `t_s`, `device_ns` by the sonar's clock."""
        fire = self.controls
        if self._standby or fire is None:
            return []
        self._on_ns = device_ns - round(UPTIME_S * NS) if self._on_ns is None else self._on_ns
        sonar = images.sonar
        speed = fire.sound_speed or sonar.sound_speed
        head = ImageHead(
            number, sonar.frequency_hz, speed, (device_ns - self._on_ns) / NS, sonar.dr_m * speed / sonar.sound_speed,
            sonar.bearing_rad, fire.gain_percent if fire.mode == LOW_MODE else 40.0 + 0.6 * fire.gain_percent,
        )  # fmt: skip
        return [
            wire.ping_result(fire, head, images.render(t_s, number), self._nominal.scene.file.image.full_scale_counts)
        ]

    def close(self) -> None:
        """Give the socket back."""
        self._socket.close()

    @property
    def _standby(self) -> bool:
        return self.controls is None or self.controls.ping_rate not in PERIODS_S

    def _can(self, fire: FireMessage) -> bool:
        numbers = fire.range_m, fire.gain_percent, fire.sound_speed, fire.salinity
        return fire.mode in self._modes and all(map(math.isfinite, numbers)) and fire.range_m >= NEAREST_RANGE_M


def _high_mode(file: SonarFile) -> SonarModel:
    return make_sonar(
        msgspec.structs.replace(
            file,
            frequency_hz=HIGH_FREQUENCY * file.frequency_hz,
            beam_spacing_deg=HIGH_OPENING * file.beam_spacing_deg,
            beam_width_deg=HIGH_BEAM_WIDTH * file.beam_width_deg,
            samples=min(file.samples, round(HIGH_RANGE_M / file.dr_m)),
        )
    )
