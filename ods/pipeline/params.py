"""Parameters of the stages that come with ODS: what a `[[pipeline.stage]]` table may say. No numba here."""

import re
from collections.abc import Mapping
from typing import Annotated, Any, Literal

import msgspec

from ods.errors import OdsError
from ods.settings import NonNegativeInt, OddInt, Positive, PositiveInt, Settings


class MeanRangeParams(Settings, frozen=True):
    """equalize.mean_range: bring the mean at each range to 1."""

    window: PositiveInt = 160
    """Range samples that count as the surroundings. What is longer than half of it, across the fan, is levelled."""
    guard: Annotated[float, msgspec.Meta(ge=1.0)] = 1.25
    """Highest level of a range, in multiples of its surroundings' level, that is levelled in full."""
    side_lobe_db: Positive = 30.0
    """How far under a strong echo its mirror images in other beams stay: a range's level is at least this far under its
    strongest sample. As that is a crest of the speckle, take 5 dB more than the beams' side lobes are down."""


class LocalParams(Settings, frozen=True):
    """equalize.local: bring the mean around each place to 1."""

    beam_blocks: PositiveInt = 8
    """Blocks that the beams are parted into."""
    range_blocks: PositiveInt = 16
    """Blocks that the range is parted into; what is longer than two of them is levelled."""
    guard: Annotated[float, msgspec.Meta(ge=1.0)] = 1.2
    """Factor up to which a block's level may differ from its surroundings' and is levelled in full."""


class BoxParams(Settings, frozen=True):
    """filter.box: moving average over range samples."""

    window: OddInt = 9
    """Range samples."""


class FirParams(Settings, frozen=True):
    """filter.fir: low-pass filter over range samples, windowed-sinc design."""

    taps: OddInt = 9
    """Range samples."""
    cutoff: Annotated[float, msgspec.Meta(gt=0.0, lt=1.0)] = 0.1
    """-6 dB point, as a fraction of the Nyquist frequency (half the sampling rate in range)."""


class WienerParams(Settings, frozen=True):
    """filter.wiener: adaptive smoothing over range samples, strong where only noise is."""

    window: OddInt = 9
    """Range samples."""


class MedianParams(Settings, frozen=True):
    """filter.median: median over range samples."""

    window: Literal[3, 5, 7, 9] = 9
    """Range samples."""


class TwoLevelParams(Settings, frozen=True):
    """detect.two_level: the high level says that an object exists, the low level how far it extends."""

    levels: Literal["noise", "background"] = "noise"
    """noise: levels are background + value * noise; background: levels are value * background. Both are measured on
    each image: the background is its median, the noise the distance from there to its 84 % quantile."""
    high: Positive = 6.0
    """A region needs a cell above this level; of images of 120,000 cells of filtered speckle one in fifty has one."""
    low: Positive = 2.5
    """Cells above this level belong to it."""
    min_cells: PositiveInt = 4
    """Regions of fewer cells (beams x range samples) are dropped."""
    max_cells: NonNegativeInt = 0
    """Regions of more cells are dropped; 0: however large, it stays."""

    def __post_init__(self) -> None:
        if self.low > self.high:
            raise ValueError(f"low: {self.low} is above high, {self.high}")


BUILT_IN: Mapping[str, type[Settings]] = {
    "equalize.mean_range": MeanRangeParams,
    "equalize.local": LocalParams,
    "filter.box": BoxParams,
    "filter.fir": FirParams,
    "filter.median": MedianParams,
    "filter.wiener": WienerParams,
    "detect.two_level": TwoLevelParams,
}
"""Parameters of every stage that comes with ODS."""


class StageError(OdsError, ValueError):
    """The chain cannot be built, or a stage failed; the text is one line that names the key and what is wrong."""


def stage_label(index: int, stage: Mapping[str, Any]) -> str:
    """Return how complaints name entry `index` of `[[pipeline.stage]]`."""
    return f"stage[{index}] ({stage.get('use')})"


def read_params(kind: type[Settings], stage: Mapping[str, Any]) -> Settings:
    """Turn a `[[pipeline.stage]]` table into the stage's parameters. Raises StageError, which names the parameter."""
    try:
        return msgspec.convert({key: value for key, value in stage.items() if key != "use"}, kind)
    except msgspec.ValidationError as error:
        raise StageError(_in_plain_words(str(error))) from error


def _in_plain_words(text: str) -> str:
    """Turn "Expected `int`, got `str` - at `$.taps`" into "taps: expected `int`, got `str`"."""
    field = re.search(r"(unknown|required) field `([^`]+)`", text)
    if field:
        return f"{field[2]}: " + ("unknown key" if field[1] == "unknown" else "missing")
    message, _, key = text.partition(" - at `$.")
    return f"{key.rstrip('`')}: {message[:1].lower()}{message[1:]}" if key else message
