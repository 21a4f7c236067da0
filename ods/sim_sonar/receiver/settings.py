"""The [image] table of config/scenes/*.toml: levels, speckle, the gain and its errors, the samples that are sent."""

from typing import Annotated, Literal

import msgspec

from ods.base.settings import Fraction, NonNegative, NonNegativeInt, Positive, Settings

Correlation = Annotated[float, msgspec.Meta(ge=0.0, le=0.95)]
SampleKind = Literal["log8", "linear8", "linear16"]
FOREVER_S = 1e9


class Tvg(Settings, frozen=True, kw_only=True):
    """Losses in the water, and the gain against them."""

    spreading_db: NonNegative = 40.0
    """dB a decade of range, two-way."""
    absorption_db_per_m: NonNegative = 0.12
    """One way (0.12: sea water, 455 kHz)."""
    set_spreading_db: NonNegative | None = None
    """Compensated by the sonar; left out: all."""
    set_absorption_db_per_m: NonNegative | None = None
    """Likewise."""
    noise_range_m: NonNegative = 0.0
    """Range at which the gain lifts the noise to `noise_counts`; 0: all."""


class Belt(Settings, frozen=True, kw_only=True):
    """Ranges where the gain is wrong."""

    from_m: NonNegative
    to_m: Positive
    gain_db: float
    """Below 0: a dark belt."""
    edge_m: NonNegative = 1.0
    """Width of the slope at both edges."""

    def __post_init__(self) -> None:
        if self.to_m <= self.from_m:
            raise ValueError(f"to_m: must be greater than from_m, {self.from_m:g}")


class _Arc(Settings, frozen=True, kw_only=True):
    """An arc of constant range."""

    range_m: Positive | None = None
    """Middle of the arc; none: random for each ping."""
    width_m: Positive = 0.5
    """In range."""
    chance: Fraction = 1.0
    """Share of pings that have it."""
    pings: list[NonNegativeInt] = msgspec.field(default_factory=list)
    """Numbers of pings that have it; empty: by chance."""


class Dropout(_Arc, frozen=True, kw_only=True):
    """A dark arc over all beams; if wider than the range, a lost image."""

    gain_db: Annotated[float, msgspec.Meta(le=0.0)] = -20.0


class DropIn(_Arc, frozen=True, kw_only=True):
    """A bright arc over all beams."""

    gain_db: NonNegative = 10.0


class Interference(Settings, frozen=True, kw_only=True):
    """Another sonar: each pulse appears as an arc, a continuous one as a spoke."""

    position_ned: tuple[float, float, float]
    """m."""
    level_counts: Positive
    """Root mean square amplitude in a beam that points at it."""
    period_s: NonNegative = 0.0
    """From pulse to pulse; 0: continuous."""
    pulse_s: Positive = 0.0005
    start_s: float = 0.0
    """Scene time of one pulse's arrival."""
    from_s: NonNegative = 0.0
    """Scene time of its start."""
    to_s: Positive = FOREVER_S
    """Scene time of its end."""


class LoudSpell(Settings, frozen=True, kw_only=True):
    """More noise in some beams; beyond full scale, saturated beams."""

    level_counts: Positive
    """Root mean square amplitude."""
    first_beam: NonNegativeInt = 0
    beams: NonNegativeInt = 0
    """0: all from the first one on."""
    from_s: NonNegative = 0.0
    """Scene time of its start."""
    to_s: Positive = FOREVER_S
    """Scene time of its end."""


class SecondWay(Settings, frozen=True, kw_only=True):
    """A longer path by which each echo arrives again."""

    longer_m: Positive
    """Added slant range."""
    gain_db: Annotated[float, msgspec.Meta(le=0.0)]
    """Level relative to the direct path."""


class ImageLevels(Settings, frozen=True, kw_only=True):
    """How reflected intensity becomes samples."""

    gain: Positive = 20000.0
    """Amplitude, counts, of 1 m2 of fully reflecting area at normal incidence in one sample."""
    noise_counts: NonNegative = 30.0
    """Root mean square amplitude of the receiver's noise."""
    looks: Annotated[float, msgspec.Meta(ge=0.5, le=1000.0)] = 1.0
    """Shape of the speckle's Gamma distributed intensity."""
    texture: Annotated[float, msgspec.Meta(ge=0.1, le=1000.0)] | None = None
    """Shape of a Gamma distributed texture beneath the speckle (K distribution); left out: none."""
    speckle: bool = True
    """False: the mean image, without speckle and noise."""
    range_correlation: Correlation = 0.0
    """Of the speckle's amplitude in neighbouring range samples."""
    beam_correlation: Correlation | None = None
    """The same of beams; none: by their overlap."""
    coherence_s: NonNegative = 0.0
    """Time after which speckle is independent; 0: never."""
    max_error: Annotated[float, msgspec.Meta(gt=0.0, le=0.5)] = 0.03
    """Relative, of the mean image."""
    tvg: Tvg = Tvg()
    """Spreading, absorption and the gain against them."""
    belts: list[Belt] = msgspec.field(default_factory=list)
    beam_gain_db: list[float] = msgspec.field(default_factory=list)
    """Error of each beam; empty: none, or random."""
    beam_gain_rms_db: NonNegative = 0.0
    """Sigma of random errors."""
    dropouts: list[Dropout] = msgspec.field(default_factory=list)
    drop_ins: list[DropIn] = msgspec.field(default_factory=list)
    interference: list[Interference] = msgspec.field(default_factory=list)
    loud_spells: list[LoudSpell] = msgspec.field(default_factory=list)
    second_ways: list[SecondWay] = msgspec.field(default_factory=list)
    saturation_counts: Positive = 1e9
    """Highest amplitude received."""
    samples: SampleKind = "log8"
    """log8: record 7042's 8-bit logarithm; linear8, linear16: proportional to amplitude."""
    log_factor: Positive = 40.0
    """log8: counts a decade."""
    full_scale_counts: Positive = 65535.0
    """linear8, linear16: amplitude of the highest value."""

    def __post_init__(self) -> None:
        if self.beam_gain_db and self.beam_gain_rms_db:
            raise ValueError("beam_gain_rms_db: cannot be combined with beam_gain_db")
