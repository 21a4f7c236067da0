"""A simulated Ping360: a head that turns step by step, and sends one beam at each."""

import dataclasses
import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Bytes
from ods.messages import TruthObject
from ods.sim_sonar.device.remote_control_server import Line
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.sonar.model import SonarModel
from ods.sim_sonar.truth import within_fan
from ods.sonar_link.ping360 import messages
from ods.sonar_link.ping360.messages import (
    HEADER_BYTES,
    MODE,
    PING360,
    START,
    TICK_S,
    TURN,
    Beam,
    Kind,
    Sweep,
    Transmission,
)

PATIENCE_S = 0.01
STEP_S = 0.0025
"""Time for a motor step of 0.9 degrees."""
BEAM_S = 0.018
"""Time for a beam besides its echoes: with both a turn takes about 9 s at 2 m and 35 s at 50 m."""
LONGEST_REQUEST = 64
FIRMWARE = (3, 3, 8)
LIMITS = {
    "gain": (0, 2), "pulse_us": (1, 1000), "period": (80, 40000), "frequency_khz": (500, 1000), "samples": (200, 1200),
}  # fmt: skip
GAIN_DB = (-6.0, 0.0, 6.0)
"""Of the receiver's settings, of which the data sheet says nothing."""


class Asked(NamedTuple):
    """The requested settings."""

    transmission: Transmission
    sweep: Sweep | None
    """None: a single beam, when it is asked for."""


class ScannedImages(ImageSimulator):
    """One beam at a time, turned to wherever the head looks; what is true is that of the whole sector."""

    def __init__(self, sonar: SonarModel, scene: Scene, sector: SonarModel, *, gain_db: float = 0.0) -> None:
        """`sonar`: of one beam straight ahead; `sector`: of all beams that the head comes by."""
        super().__init__(sonar, scene, gain_db=gain_db)
        self._sector = sector

    def beam(self, t_s: float, number: int, angle: int) -> Bytes:
        """Return (samples,) counts of the beam of that head angle, gradians, sent at scene time `t_s`."""
        turned = self.seeing(self.scene.with_head_turned(2.0 * math.pi * angle / TURN))
        top = self.scene.file.image.full_scale_counts
        counts = turned.render(t_s, number)[0] * (255.0 / top)
        return np.asarray(np.rint(np.minimum(counts, 255.0)), np.uint8)

    def truth(self, t_s: float, ping_number: int = 0) -> list[TruthObject]:
        """Return the bounded objects, in the sector or not; levels are not reported."""
        del ping_number
        objects, pose = self.scene.objects_at(t_s), self.scene.head_at(t_s)
        inside = within_fan(self._sector, objects.position_ned, objects.radius_m, pose)
        rows = zip(objects.names, objects.position_ned, objects.velocity_ned, objects.radius_m, inside, strict=True)
        return [
            TruthObject(name, tuple(place.tolist()), tuple(speed.tolist()), float(radius), bool(seen))
            for name, place, speed, radius, seen in rows
        ]


class SimulatedPing360:
    """The far end of a Ping360: see `SimulatedSonar`. It does not ping before it is asked to."""

    def __init__(self, nominal: ImageSimulator, line: Line) -> None:
        """`nominal`: the images at the scene's levels."""
        self._nominal = nominal
        self._line = line
        self._stream = b""
        self._asked: Asked | None = None
        self._angle = 0
        """Of the head, gradians."""
        self._way = 1

    @property
    def controls(self) -> Asked | None:
        """The requested settings."""
        return self._asked

    def listen(self, _device_ns: int) -> None:
        """Obey and answer what has come."""
        self._stream += self._line.read()
        while (at := self._stream.find(START)) >= 0 and len(self._stream) >= at + HEADER_BYTES:
            size = messages.unpack_header(self._stream, at).size
            if size > LONGEST_REQUEST:
                self._stream = self._stream[at + len(START) :]
                continue
            if len(self._stream) < at + size:
                break
            message = self._stream[at : at + size]
            self._stream = self._stream[at + size :]
            if messages.is_sound(memoryview(message)):
                self._line.write([self._answer(message)], PATIENCE_S)
        self._stream = self._stream[-LONGEST_REQUEST:]

    def wanted(self, telegram: list[bytes]) -> list[bytes]:
        """Return all: what has not been asked for was not made."""
        return telegram

    def images(self) -> ScannedImages:
        """Return the images of the range and samples that have been asked for."""
        model, asked = self._nominal.sonar, self._asked
        dr_m = model.dr_m if asked is None else 0.5 * model.sound_speed * asked.transmission.period * TICK_S
        samples = model.samples if asked is None else asked.transmission.samples
        sweep = None if asked is None else asked.sweep
        width = TURN - 1 if sweep is None else (sweep.stop - sweep.start) % TURN
        first = -(TURN // 2) if width >= TURN - 2 or sweep is None else (sweep.start + TURN // 2) % TURN - TURN // 2
        bearing_rad = np.asarray((first + np.arange(width + 1)) * (2.0 * math.pi / TURN), np.float64)
        beam = dataclasses.replace(
            model, bearing_rad=np.zeros(1), elevation_rad=np.zeros(1), range0_m=dr_m, dr_m=dr_m, samples=samples
        )
        sector = dataclasses.replace(beam, bearing_rad=bearing_rad, elevation_rad=np.zeros(width + 1))
        gain_db = 0.0 if asked is None else GAIN_DB[asked.transmission.gain]
        return ScannedImages(beam, self._nominal.scene, sector, gain_db=gain_db)

    def period_s(self, sonar: SonarModel) -> float:
        """Return the time from beam to beam."""
        sweep = self._asked.sweep if self._asked else None
        steps, delay_ms = (sweep.steps, sweep.delay_ms) if sweep else (1, 0)
        return 2.0 * sonar.range_max_m / sonar.sound_speed + BEAM_S + STEP_S * steps + 1e-3 * delay_ms

    def telegram(self, images: ImageSimulator, t_s: float, number: int, _sent_ns: int, _device_ns: int) -> list[bytes]:
        """Return the beam sent at scene time `t_s`, and turn the head on."""
        asked = self._asked
        if asked is None or asked.sweep is None or not isinstance(images, ScannedImages):
            return []
        taken = asked.transmission
        samples = images.beam(t_s, number, self._angle).tobytes()
        numbers = taken.gain, self._angle, taken.pulse_us, taken.period, taken.frequency_khz
        beam = Beam(*numbers, asked.sweep, samples)
        self._turn_on(asked.sweep)
        return [messages.encode_beam(beam)]

    def _turn_on(self, sweep: Sweep) -> None:
        """Turn the head to the next beam: to and fro in a sector, on and on where that is all round."""
        width = (sweep.stop - sweep.start) % TURN
        if width + sweep.steps >= TURN:
            self._angle = (self._angle + sweep.steps) % TURN
            return
        place = (self._angle - sweep.start) % TURN + self._way * sweep.steps
        if not 0 <= place <= width:
            self._way = -self._way
            place += 2 * self._way * sweep.steps
        self._angle = (sweep.start + min(max(place, 0), width)) % TURN

    def _answer(self, message: bytes) -> bytes:
        kind = messages.unpack_header(message).kind
        if kind == Kind.GENERAL_REQUEST:
            return self._requested(messages.decode_id(message))
        if kind == Kind.MOTOR_OFF:
            self._asked = None
        elif kind == Kind.AUTO_TRANSMIT:
            asked = messages.decode_auto_transmit(message)
            if not _can(*asked):
                return _refusal(kind, b"out of limits")
            self._asked, self._angle, self._way = Asked(*asked), asked[1].start, 1
        else:
            return _refusal(kind, b"unknown message")
        return messages.pack(Kind.ACK, kind.to_bytes(2, "little"), PING360)

    def _requested(self, wanted: int) -> bytes:
        if wanted == Kind.DEVICE_INFORMATION:
            return messages.pack(wanted, bytes([PING360, MODE, *FIRMWARE, 0]), PING360)
        if wanted == Kind.PROTOCOL_VERSION:
            return messages.pack(wanted, bytes([1, 1, 0, 0]), PING360)
        if wanted == Kind.DEVICE_DATA:
            taken = self._asked.transmission if self._asked else Transmission(0, 32, 80, 740, 200)
            numbers = taken.gain, self._angle, taken.pulse_us, taken.period, taken.frequency_khz
            return messages.encode_beam(Beam(*numbers, None, bytes(taken.samples)))
        return _refusal(wanted, b"unknown message")


def _refusal(kind: int, words: bytes) -> bytes:
    return messages.pack(Kind.NACK, kind.to_bytes(2, "little") + words, PING360)


def _can(transmission: Transmission, sweep: Sweep) -> bool:
    """Return whether it can do so."""
    numbers = all(low <= getattr(transmission, name) <= high for name, (low, high) in LIMITS.items())
    return numbers and max(sweep.start, sweep.stop) < TURN and 1 <= sweep.steps <= 10 and sweep.delay_ms <= 100
