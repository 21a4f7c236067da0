"""Parameters of the stages that come with ODS: what a `[[pipeline.stage]]` table may say. Quick to import."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

import msgspec

from ods.base.errors import OdsError
from ods.base.plugins import PluginGroup
from ods.base.settings import (
    Fraction,
    NonNegative,
    NonNegativeInt,
    OddInt,
    Positive,
    PositiveInt,
    Settings,
    complaint_of,
    refuse_even,
    slider,
)


class MeanRangeParams(Settings, frozen=True):
    """equalize.mean_range: bring the mean at each range to 1."""

    window: Annotated[PositiveInt, slider(10, 400, step=2, unit="samples")] = 160
    """Surroundings, range samples; structures longer than half of it are levelled."""
    guard: Annotated[float, msgspec.Meta(ge=1.0), slider(1.0, 3.0, step=0.05)] = 1.25
    """A level up to this multiple of its surroundings' is levelled in full."""
    side_lobe_db: Annotated[Positive, slider(10.0, 60.0, step=1.0, unit="dB")] = 30.0
    """A range's level is at least this far below its strongest sample, against side lobes in other beams: use 5 dB
    more than their suppression."""


class MedianRangeParams(Settings, frozen=True):
    """equalize.median_range: bring the median at each range to that of speckle of mean 1."""

    window: Annotated[PositiveInt, slider(10, 400, step=2, unit="samples")] = 160
    """Surroundings, range samples."""
    guard: Annotated[float, msgspec.Meta(ge=1.0), slider(1.0, 3.0, step=0.05)] = 1.25
    """As in equalize.mean_range."""


class LocalParams(Settings, frozen=True):
    """equalize.local: bring the mean around each cell to 1."""

    beam_blocks: Annotated[PositiveInt, slider(1, 32)] = 8
    """Blocks that the beams are divided into."""
    range_blocks: Annotated[PositiveInt, slider(1, 64)] = 16
    """Blocks of range; structures longer than two are levelled."""
    guard: Annotated[float, msgspec.Meta(ge=1.0), slider(1.0, 3.0, step=0.05)] = 1.2
    """A level within this factor of its surroundings' is levelled in full."""


class BoxParams(Settings, frozen=True):
    """filter.box: moving average over range samples."""

    window: Annotated[OddInt, slider(1, 41, unit="samples")] = 9
    """Range samples."""
    beams: Annotated[OddInt, slider(1, 15, unit="beams")] = 1
    """1: along the range only."""


class FirParams(Settings, frozen=True):
    """filter.fir: Hamming-windowed sinc [SSIE, Image processing, stage 2]."""

    taps: Annotated[OddInt, slider(1, 61, unit="samples")] = 9
    """Range samples."""
    cutoff: Annotated[float, msgspec.Meta(gt=0.0, lt=1.0), slider(0.01, 0.5, step=0.01)] = 0.1
    """-6 dB point, as a fraction of the Nyquist frequency."""
    object_m: Annotated[NonNegative, slider(0.0, 5.0, step=0.05, unit="m")] = 0.0
    """Smallest object: above 0 it decides taps and cutoff."""
    beams: Annotated[OddInt, slider(1, 15, unit="beams")] = 1
    """Taps across the beams; 1: along the range only."""
    round_beams: Annotated[float, msgspec.Meta(ge=0.0, le=3.0), slider(0.0, 3.0, step=0.05, unit="beams")] = 0.0
    """With beams = 1: smooth finely spaced beams as far across as along, at half range, with at most this sigma."""
    beam_cutoff: Annotated[float, msgspec.Meta(gt=0.0, lt=1.0), slider(0.05, 0.95, step=0.05)] = 0.4
    """-6 dB point across the beams, as a fraction of half a cycle a beam."""


class GaussianParams(Settings, frozen=True):
    """filter.gaussian: Gaussian weights, cut at three sigmas."""

    sigma: Annotated[float, msgspec.Meta(gt=0.0, le=100.0), slider(0.5, 20.0, log=True, unit="samples")] = 2.5
    """Range samples."""
    beam_sigma: Annotated[float, msgspec.Meta(ge=0.0, le=10.0), slider(0.0, 5.0, step=0.1, unit="beams")] = 0.0
    """Beams; 0: along the range only."""


class WienerParams(Settings, frozen=True):
    """filter.wiener: adaptive smoothing along the range, strong where there is only noise."""

    window: Annotated[OddInt, slider(1, 41, unit="samples")] = 9
    """Range samples."""
    beams: Annotated[OddInt, slider(1, 15, unit="beams")] = 1
    """1: along the range only."""


class MedianParams(Settings, frozen=True):
    """filter.median: median over range samples."""

    window: Literal[3, 5, 7, 9] = 9
    """Range samples."""
    beams: Literal[1, 3, 5] = 1
    """Beams, by the median of their medians; 1: along the range only."""


class IirParams(Settings, frozen=True):
    """filter.iir: recursive low-pass along the range, forwards and backwards."""

    length: Annotated[float, msgspec.Meta(ge=0.5, le=1000.0), slider(0.5, 50.0, log=True, unit="samples")] = 3.0
    """Range samples over which the weights fall to 1/e."""


class MinObjectParams(Settings, frozen=True):
    """filter.min_object: suppress structures smaller than an object, by grey opening."""

    size_m: Annotated[float, msgspec.Meta(gt=0.0, le=50.0), slider(0.05, 10.0, log=True, unit="m")] = 0.5
    """Smallest object kept, in range and across."""


class BeamGainParams(Settings, frozen=True):
    """equalize.beam_gain: equalize beams of different gain."""

    limit: Annotated[float, msgspec.Meta(ge=1.0), slider(1.0, 100.0, log=True)] = 30.0
    """Largest factor applied to a beam, up or down."""


class PingIirParams(Settings, frozen=True):
    """filter.ping_iir: recursive mean over pings, motion-compensated."""

    weight: Annotated[float, msgspec.Meta(gt=0.0, le=1.0), slider(0.02, 1.0, step=0.02)] = 0.4
    """Weight of the newest ping."""
    longest_gap_s: Annotated[Positive, slider(0.2, 20.0, log=True, unit="s")] = 2.0
    """A longer pause discards earlier pings."""


class PingMedianParams(Settings, frozen=True):
    """filter.ping_median: median over pings, motion-compensated."""

    pings: Literal[3, 5, 7] = 3
    """Pings, the newest included."""
    longest_gap_s: Annotated[Positive, slider(0.2, 20.0, log=True, unit="s")] = 2.0
    """A longer pause discards earlier pings."""


class BackgroundParams(Settings, frozen=True):
    """equalize.background: bring the mean over pings of each cell to 1."""

    weight: Annotated[float, msgspec.Meta(gt=0.0, le=1.0), slider(0.002, 1.0, log=True)] = 0.02
    """Weight of the newest ping."""
    guard: Annotated[float, msgspec.Meta(ge=1.0), slider(1.0, 5.0, step=0.1)] = 1.5
    """A mean within this factor of its range's is levelled in full."""
    longest_gap_s: Annotated[Positive, slider(0.5, 60.0, log=True, unit="s")] = 10.0
    """A longer pause discards earlier pings."""


class GroupParams(Settings, frozen=True):
    """How cells become regions, and which regions count."""

    connectivity: Literal[4, 8] = 8
    """8: cells at a corner are connected; 4: only at a side."""
    min_cells: Annotated[PositiveInt, slider(1, 60, unit="cells")] = 4
    """Smaller regions, in cells (beams x range samples), are dropped."""
    max_cells: Annotated[NonNegativeInt, slider(0, 20_000, step=10, log=True, unit="cells")] = 0
    """Larger ones are dropped; 0: none."""
    min_extent_m: Annotated[NonNegative, slider(0.0, 5.0, step=0.05, unit="m")] = 0.0
    """Smaller regions, in range and across, are dropped."""
    max_extent_m: Annotated[NonNegative, slider(0.0, 50.0, step=0.5, unit="m")] = 0.0
    """Larger regions, in range or across, are dropped; 0: none."""
    strongest: Annotated[Fraction, slider(0.01, 1.0, step=0.01)] = 1.0
    """A region must contain one of the ping's strongest samples, this share: equalization raises silent parts."""
    border: Annotated[float, msgspec.Meta(ge=1.0, le=10.0), slider(1.0, 4.0, step=0.05)] = 1.0
    """Factor on the threshold within 2 beams (of 16 or more) or 4 range samples (of 32 or more) of the border, where
    filters double the noise."""
    split_db: Annotated[NonNegative, slider(0.0, 12.0, step=0.25, unit="dB")] = 0.0
    """Depth of a valley that splits a region; 0: never."""


class TwoLevelParams(GroupParams, frozen=True):
    """detect.two_level: the high level decides that an object exists, the low level how far it extends."""

    levels: Literal["noise", "background", "absolute", "false_alarm"] = "noise"
    """noise: background + value * noise; background: value * background; absolute: value; false_alarm: the high level
    follows from `rate`, the low one as with noise."""
    high: Annotated[Positive, slider(2.0, 20.0, step=0.1)] = 6.0
    """A region must contain a cell above this level."""
    low: Annotated[Positive, slider(0.5, 10.0, step=0.1)] = 2.5
    """Connected cells above this level belong to the region."""
    rate: Annotated[float, msgspec.Meta(ge=1e-9, le=0.01), slider(1e-9, 0.01, log=True)] = 1e-6
    """With "false_alarm": share of the cells without echoes above the high level."""
    follow: Annotated[Fraction, slider(0.0, 1.0, step=0.05)] = 0.6
    """With "noise": share of the threshold rise over a rough sea-bed, in dB, that is applied. 0: one level for the
    whole image."""
    faint: Annotated[Fraction, slider(0.0, 1.0, step=0.05)] = 0.3
    """The same for weak detections, which only the tracker uses; none with `follow` or more."""
    fronts: bool = True
    """Over a rough sea-bed a network judges leading edges, of beams 0.67 to 2 degrees wide."""

    def __post_init__(self) -> None:
        if self.low > self.high:
            raise ValueError(f"low: {self.low} is above high, {self.high}")


class OneLevelParams(GroupParams, frozen=True):
    """detect.one_level: cells above one level, for comparison."""

    levels: Literal["noise", "background", "absolute", "false_alarm"] = "noise"
    """Unit of `level`, as in detect.two_level."""
    level: Annotated[Positive, slider(1.0, 20.0, step=0.1)] = 5.0
    """Cells above this level are echoes."""
    rate: Annotated[float, msgspec.Meta(ge=1e-9, le=0.01), slider(1e-9, 0.01, log=True)] = 1e-6
    """As in detect.two_level."""
    follow: Annotated[Fraction, slider(0.0, 1.0, step=0.05)] = 0.6
    """As in detect.two_level."""


class CfarParams(GroupParams, frozen=True):
    """detect.cfar: cells above their surroundings in range (H. Rohling, IEEE Trans. AES 19, 1983)."""

    method: Literal["ca", "goca", "soca", "os"] = "ca"
    """Level of the surroundings: mean, the greater or the smaller side's mean, or an order statistic."""
    guard: Annotated[PositiveInt, slider(1, 120, unit="samples")] = 24
    """Range samples ignored on each side of a cell."""
    train: Annotated[PositiveInt, slider(1, 200, unit="samples")] = 48
    """Range samples beyond these, on each side."""
    rank: Annotated[float, msgspec.Meta(gt=0.0, lt=1.0), slider(0.05, 0.95, step=0.05)] = 0.75
    """os: quantile of the surroundings."""
    rate: Annotated[float, msgspec.Meta(ge=1e-9, le=0.01), slider(1e-9, 0.01, log=True)] = 1e-6
    """False-alarm rate: share of the cells without echoes above the high level, measured on each image."""
    low: Annotated[Positive, slider(0.5, 10.0, step=0.1)] = 2.5
    """Cells above this multiple of the noise belong to an echo."""


BUILT_IN: Mapping[str, type[Settings]] = {
    "equalize.mean_range": MeanRangeParams,
    "equalize.median_range": MedianRangeParams,
    "equalize.local": LocalParams,
    "equalize.beam_gain": BeamGainParams,
    "equalize.background": BackgroundParams,
    "filter.box": BoxParams,
    "filter.fir": FirParams,
    "filter.gaussian": GaussianParams,
    "filter.median": MedianParams,
    "filter.iir": IirParams,
    "filter.min_object": MinObjectParams,
    "filter.ping_iir": PingIirParams,
    "filter.ping_median": PingMedianParams,
    "filter.wiener": WienerParams,
    "detect.two_level": TwoLevelParams,
    "detect.one_level": OneLevelParams,
    "detect.cfar": CfarParams,
}
"""Parameters of every built-in stage."""


STAGES = PluginGroup("pipeline.plugins", "ods.stages")
"""Where the user's own stages are named."""


class StageError(OdsError, ValueError):
    """The chain cannot be built, or a stage failed; the text is one line that names the key and what is wrong."""


class NotANumberError(StageError):
    """An image has cells that are not finite."""

    def __init__(self) -> None:
        super().__init__("its image has values that are not finite")


def stage_label(index: int, stage: Mapping[str, Any]) -> str:
    """Return how complaints name entry `index` of `[[pipeline.stage]]`."""
    return f"stage[{index}] ({stage.get('use')})"


def read_params(kind: type[Settings], stage: Mapping[str, Any]) -> Settings:
    """Turn a `[[pipeline.stage]]` table into the stage's parameters. Raises StageError, which names the parameter."""
    try:
        params = msgspec.convert({key: value for key, value in stage.items() if key != "use"}, kind)
        refuse_even(params)
    except msgspec.ValidationError as error:
        raise StageError(complaint_of(error, kind)) from error
    except ValueError as error:
        raise StageError(str(error)) from error
    return params
