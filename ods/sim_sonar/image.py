"""One call renders one image: a scene, or arrays, seen by a sonar at one time."""

import copy
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Image
from ods.messages import Ping, TruthObject
from ods.sim_sonar.echo.bodies.bodies import Bodies
from ods.sim_sonar.echo.bodies.motion_during_reception import as_received, turn_per_metre
from ods.sim_sonar.mean_area import Surroundings, mean_area
from ods.sim_sonar.pose import Transmission, VehiclePose
from ods.sim_sonar.receiver.quantize import PingMaker
from ods.sim_sonar.receiver.settings import ImageLevels
from ods.sim_sonar.receiver.signal_chain import Receiver
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.sonar.grid import grid_of
from ods.sim_sonar.sonar.model import SonarModel
from ods.sim_sonar.truth import truth_of


def render_image(
    sonar: SonarModel,
    surroundings: Surroundings,
    sent: Transmission,
    levels: ImageLevels | None = None,
    *,
    seed: int = 0,
) -> Image:
    """Return one image from arrays: (beams, samples) float32 amplitude, counts.

    The time in `sent` is for other sonars' pulses and the coherence time. Intensity is Gamma distributed about eq. 5's
    mean [SSIE]. Raises ValueError when `levels` do not fit the sonar. Tables are made at each call: for a
    sequence, keep a Receiver.
    """
    chosen = ImageLevels() if levels is None else levels
    area = mean_area(grid_of(sonar), surroundings, sent.pose, chosen.max_error)
    return Receiver(sonar, chosen, seed).receive(area, sent)


class _Moment(NamedTuple):
    """A scene at the instant of a ping."""

    t_s: float
    pose: VehiclePose
    """The sonar head's, at transmission."""
    received: Bodies
    """The objects as they are received, see `as_received`."""
    area: Floats
    """(beams, samples) m2."""

    def sent(self, ping_number: int) -> Transmission:
        """Return the ping of that number, sent now."""
        return Transmission(self.pose, self.t_s, ping_number)


class ImageSimulator:
    """Renders the images of one scene with one sonar; the same seed gives the same bytes, in any order of calls."""

    def __init__(
        self,
        sonar: SonarModel,
        scene: Scene,
        seed: int | None = None,
        *,
        power_db: float = 0.0,
        gain_db: float = 0.0,
    ) -> None:
        """Prepare tables; `seed` replaces the scene's own. Raises ValueError when the scene does not fit the sonar.

        `power_db`: transmit power over that of the scene's levels, raises the echoes; `gain_db` likewise, raises all.
        """
        self.sonar = sonar
        self.scene = scene
        levels = scene.file.image
        chosen = scene.file.seed if seed is None else seed
        with _that_amplitudes_hold():
            self.receiver = Receiver(sonar, levels, chosen, power_db=power_db, gain_db=gain_db)
        self.blindness: Sequence[Callable[[Image], None]] = ()
        """What is wrong with the sonar just now: each changes the image that it sends."""
        self._make_ping = PingMaker(sonar, levels)
        self._grid = grid_of(sonar)
        self._newest: _Moment | None = None

    def seeing(self, scene: Scene) -> "ImageSimulator":
        """Return the same sonar before other surroundings, at once: the tables are kept.

        Raises ValueError when the scene's levels or seed are others, of which the tables are made.
        """
        old, new = self.scene.file, scene.file
        if (new.image, new.seed) != (old.image, old.seed):
            raise ValueError("image: with other levels or another seed")
        other = copy.copy(self)
        other.scene, other._newest = scene, None
        return other

    def mean_area(self, t_s: float) -> Floats:
        """Return the area, m2, (beams, samples) float64, that each sample receives of a ping sent at scene time `t_s`.

        Do not write to it.
        """
        return self._moment(t_s).area

    def _moment(self, t_s: float) -> _Moment:
        """Return what there is at scene time `t_s`; the newest is kept, as image and truth both need it."""
        if self._newest is None or self._newest.t_s != t_s:
            file, scene = self.scene.file, self.scene
            pose = scene.head_at(t_s)
            sonar, head_at = self.sonar, scene.head_at
            received = as_received(scene.bodies_at(t_s), t_s, pose, sonar.sound_speed, head_at)
            turning = turn_per_metre(pose, t_s, sonar.range_max_m, sonar.sound_speed, head_at)
            surroundings = Surroundings(received, scene.sea_bed, file.shadows, turning)
            area = mean_area(self._grid, surroundings, pose, file.image.max_error)
            self._newest = _Moment(t_s, pose, received, area)
        return self._newest

    def mean_image(self, t_s: float, ping_number: int = 0) -> Image:
        """Return the image without speckle: (beams, samples) float32 root mean square amplitude, counts."""
        moment = self._moment(t_s)
        with _that_amplitudes_hold():
            return self.receiver.mean_image(moment.area, self.receiver.levels_of(moment.sent(ping_number)))

    def render(self, t_s: float, ping_number: int) -> Image:
        """Return the image at scene time `t_s`: (beams, samples) float32 amplitude, counts. Raises ValueError."""
        moment = self._moment(t_s)
        with _that_amplitudes_hold():
            image = self.receiver.receive(moment.area, moment.sent(ping_number))
            if not np.isfinite(image).all():
                raise OverflowError
        for spoil in self.blindness:
            spoil(image)
        return image

    def ping(self, t_s: float, ping_number: int, t_ns: int, utc_ns: int) -> Ping:
        """Return the image at scene time `t_s` as the sonar sends it, transmitted at `t_ns`."""
        return self._make_ping(self.render(t_s, ping_number), ping_number, t_ns, utc_ns)

    def truth(self, t_s: float, ping_number: int = 0) -> list[TruthObject]:
        """Return the bounded objects at scene time `t_s`, with the levels of their echoes in that ping."""
        moment = self._moment(t_s)
        levels = self.receiver.levels_of(moment.sent(ping_number))
        received_ned = moment.received["centre"][self.scene.shown]
        return truth_of(self.sonar, moment.area, levels, moment.pose, self.scene.objects_at(t_s), received_ned)


@contextmanager
def _that_amplitudes_hold() -> Iterator[None]:
    """Raise ValueError where levels come to more than 32-bit numbers hold: who looks amplitudes up relies on it."""
    try:
        with np.errstate(over="raise"):
            yield
    except ArithmeticError as error:
        names = "gain, noise_counts, a level_counts or a level in dB"
        raise ValueError(f"image: {names} is higher than the largest amplitude (1e19 counts)") from error
