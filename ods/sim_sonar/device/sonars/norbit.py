"""A simulated Norbit WBMS FLS: obeys and answers commands at one TCP port, sends images at another."""

import dataclasses
import math
from typing import NamedTuple

import numpy as np

from ods.base.clock import NS
from ods.sim_sonar.device.lines.tcp_line import TcpLine
from ods.sim_sonar.device.sonars import norbit_packets as wire
from ods.sim_sonar.device.sonars.norbit_packets import ImageSays
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.sonar.model import SonarModel

GREETING = b"NORBIT WBMS simulated\r\nSonar is ready to accept commands\r\n"
NATIVE_HZ = 78125.0
"""Rate of its samples, of which it sends every n-th."""
MOST_SAMPLES = 512 * 1024
"""Of an image."""
BEAMS = (64, 128, 256, 512)
MAX_LINE_BYTES = 4096
PATIENCE_S = 0.01

Values = tuple[float, ...]
DEFAULTS: dict[str, Values] = {
    "set_mode": (0,), "set_flip": (0,), "set_gate_mode": (1,), "set_range": (0.0, 50.0), "set_direction": (0.0,),
    "set_opening_angle": (140.0,), "set_resolution": (256, 128), "set_tx": (400.0, 80.0, 15, 500.0),
    "set_gain": (0.0,), "set_vga": (50.0,), "set_rate": (60.0,), "set_tp_rate": (5.0,), "set_trigger_mode": (3,),
    "set_power": (0,), "sound_velocity": (-1.0,),
}  # fmt: skip
"""Commands of this simulator, with what it is set to after switching on: the document's defaults."""
LIMITS: dict[str, tuple[float, float]] = {
    "set_mode": (0, 7), "set_flip": (0, 1), "set_gate_mode": (0, 2), "set_range": (0.0, 600.0),
    "set_direction": (-90.0, 90.0), "set_opening_angle": (1.0, 360.0), "set_gain": (0.0, 100.0),
    "set_vga": (0.0, 100.0), "set_rate": (-1.0, 60.0), "set_tp_rate": (-1.0, 60.0), "set_trigger_mode": (0, 5),
    "set_power": (0, 1), "sound_velocity": (-1.0, 1700.0),
}  # fmt: skip


class Setting(NamedTuple):
    """Settings of the sonar that affect its images."""

    mode: int
    range_m: float
    opening_deg: float
    samples: int
    beams: int
    gain_db: float
    ramp_db: float
    tx: Values
    rate_hz: float
    sound_speed: float
    """0 or less: that of the water."""
    power: bool


class SimulatedNorbit:
    """The far end of a WBMS: see `SimulatedSonar`. It does not ping before it is asked to."""

    def __init__(self, nominal: ImageSimulator, line: TcpLine, commands: TcpLine) -> None:
        """`nominal`: the images at the scene's levels; `line`, `commands`: the ports of images and commands."""
        self._nominal = nominal
        self._line = line
        self._commands = commands
        self._values = dict(DEFAULTS)
        self._stream = b""
        self._client = 0

    @property
    def controls(self) -> Setting:
        """The settings that it has been set to."""
        values = self._values
        rates = [rate for name in ("set_rate", "set_tp_rate") if (rate := values[name][0]) > 0.0]
        return Setting(
            mode=int(values["set_mode"][0]),
            range_m=values["set_range"][1],
            opening_deg=values["set_opening_angle"][0],
            samples=int(values["set_resolution"][0]),
            beams=int(values["set_resolution"][1]),
            gain_db=values["set_gain"][0] if not values["set_vga"][0] else 0.0,
            ramp_db=values["set_vga"][0],
            tx=values["set_tx"],
            rate_hz=min(rates, default=60.0),
            sound_speed=values["sound_velocity"][0],
            power=bool(values["set_power"][0]),
        )

    def listen(self, _device_ns: int) -> None:
        """Obey and answer what has come; find out whether a client is there."""
        self._line.read()
        self._stream += self._commands.read()
        if self._commands.connections != self._client:
            self._client = self._commands.connections
            self._commands.write([GREETING], PATIENCE_S)
        *lines, self._stream = self._stream.replace(b"\r", b"\n").split(b"\n")
        self._stream = self._stream[-MAX_LINE_BYTES:]
        for line in lines:
            if line.strip():
                self._commands.write([self._answer(line.decode("ascii", "replace").split())], PATIENCE_S)

    def wanted(self, telegram: list[bytes]) -> list[bytes]:
        """Return what goes out: nothing while it does not ping."""
        return telegram if self.controls.power and self._line.connected else []

    def images(self) -> ImageSimulator:
        """Return the images of the range, fan, resolution and gain that have been asked for."""
        asked, model = self.controls, self._nominal.sonar
        dr_m = _decimation(asked, model) * _native_m(model)
        beams = asked.beams
        spacing_rad = math.radians(asked.opening_deg) / beams
        sonar = dataclasses.replace(
            model,
            bearing_rad=np.asarray((np.arange(beams) - 0.5 * (beams - 1)) * spacing_rad, np.float64),
            elevation_rad=np.zeros(beams),
            range0_m=dr_m,
            dr_m=dr_m,
            samples=max(1, math.floor(asked.range_m / dr_m)),
        )
        return ImageSimulator(sonar, self._nominal.scene, gain_db=asked.gain_db)

    def period_s(self, sonar: SonarModel) -> float:
        """Return the time from ping to ping: the asked-for rate, or what the range takes."""
        return max(1.0 / self.controls.rate_hz, sonar.ping_period_s)

    def telegram(self, images: ImageSimulator, t_s: float, number: int, _sent_ns: int, device_ns: int) -> list[bytes]:
        """Return the packet of the ping sent at scene time `t_s`, `device_ns` by the sonar's clock."""
        asked, sonar = self.controls, images.sonar
        if not asked.power or sonar is self._nominal.sonar:
            return []
        speed = asked.sound_speed if asked.sound_speed > 0.0 else sonar.sound_speed
        frequency_khz, bandwidth_khz, amplitude, pulse_us = asked.tx
        says = ImageSays(
            sound_speed=speed,
            sample_rate_hz=sonar.sound_speed / (2.0 * sonar.dr_m),
            time_s=device_ns / NS,
            first_sample=round(sonar.range0_m / sonar.dr_m),
            bearing_rad=sonar.bearing_rad,
            opening_rad=math.radians(asked.opening_deg),
            frequency_khz=frequency_khz,
            bandwidth_khz=bandwidth_khz,
            pulse_s=1e-6 * pulse_us,
            amplitude=int(amplitude),
            ping_rate_hz=1.0 / self.period_s(sonar),
            number=number,
            gain_db=(asked.gain_db, asked.gain_db + 1e-2 * asked.ramp_db * sonar.range_max_m),
            mode=asked.mode,
        )
        return [wire.water_column(says, images.render(t_s, number), self._nominal.scene.file.image.full_scale_counts)]

    def close(self) -> None:
        """Give the command port back."""
        self._commands.unplug()

    def _answer(self, words: list[str]) -> bytes:
        name, *texts = words
        if name not in self._values:
            return f"{name}: unknown command\r\n".encode()
        try:
            values = tuple(float(text) for text in texts)
        except ValueError:
            return f"{name}: arguments are numbers\r\n".encode()
        if values and _can(name, values):
            self._values[name] = values
        return f"{name} {' '.join(f'{value:g}' for value in self._values[name])} # simulated\r\n".encode()


def _can(name: str, values: Values) -> bool:
    """Return whether these are values of the command, within its limits."""
    if len(values) != len(DEFAULTS[name]) or not all(map(math.isfinite, values)):
        return False
    if name == "set_resolution":
        return 64 <= values[0] <= 2048 and values[1] in BEAMS
    if name == "set_range":
        return values[0] == 0.0 and 1.0 <= values[1] <= LIMITS[name][1]
    low, high = LIMITS.get(name, (0.0, math.inf))
    return all(low <= value <= high for value in values)


def _native_m(sonar: SonarModel) -> float:
    return sonar.sound_speed / (2.0 * NATIVE_HZ)


def _decimation(asked: Setting, sonar: SonarModel) -> int:
    """Return how many of its own samples make one of an image, so that neither the asked-for count nor the most that
    an image can have is passed."""
    own = asked.range_m / _native_m(sonar)
    return max(1, math.ceil(own / min(asked.samples, MOST_SAMPLES // asked.beams)))
