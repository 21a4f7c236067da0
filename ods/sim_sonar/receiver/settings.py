"""The [image] table of config/scenes/*.toml: levels, speckle, the gain and its errors, the samples that are sent."""

from typing import Annotated, Literal

import msgspec

from ods.base.settings import Fraction, NonNegative, NonNegativeInt, Positive, Settings

Correlation = Annotated[float, msgspec.Meta(ge=0.0, le=0.95)]
SampleKind = Literal["log8", "linear8", "linear16"]
FOREVER_S = 1e9


class Tvg(Settings, frozen=True, kw_only=True):
    """Losses in the water, and the time-varying gain that should compensate for them."""

    spreading_db: NonNegative = 40.0
    """Spreading loss, dB a decade of range, two-way."""
    absorption_db_per_m: NonNegative = 0.12
    """One way (0.12: sea water, 455 kHz)."""
    set_spreading_db: NonNegative | None = None
    """Spreading loss that the sonar compensates; left out: all."""
    set_absorption_db_per_m: NonNegative | None = None
    """Absorption that the sonar compensates; left out: all."""
    noise_range_m: NonNegative = 0.0
    """Range at which the gain lifts the noise to `noise_counts`; 0: all."""


class Belt(Settings, frozen=True, kw_only=True):
    """A belt of ranges where the gain is wrong."""

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
    """Middle of the arc; none: anywhere, drawn again for each ping."""
    width_m: Positive = 0.5
    """Extent in range."""
    chance: Fraction = 1.0
    """Share of the pings that have it."""
    pings: list[NonNegativeInt] = msgspec.field(default_factory=list)
    """Numbers of the pings that have it; empty: by chance."""


class Dropout(_Arc, frozen=True, kw_only=True):
    """A dark arc over all beams; with a width beyond the range, a lost image."""

    gain_db: Annotated[float, msgspec.Meta(le=0.0)] = -20.0
    """Level inside."""


class DropIn(_Arc, frozen=True, kw_only=True):
    """A bright arc over all beams: the gain jumps."""

    gain_db: NonNegative = 10.0
    """Level inside."""


class Interference(Settings, frozen=True, kw_only=True):
    """Another sonar: each pulse leaves an arc, an endless one a spoke."""

    position_ned: tuple[float, float, float]
    """m."""
    level_counts: Positive
    """Root mean square amplitude in a beam that looks at it."""
    period_s: NonNegative = 0.0
    """From pulse to pulse; 0: endless."""
    pulse_s: Positive = 0.0005
    """Pulse length."""
    start_s: float = 0.0
    """Scene time at which one of its pulses arrives."""
    from_s: NonNegative = 0.0
    """Scene time from which on it sounds,"""
    to_s: Positive = FOREVER_S
    """and until which."""


class LoudSpell(Settings, frozen=True, kw_only=True):
    """More noise in some beams for a time; beyond full scale, saturated beams."""

    level_counts: Positive
    """Root mean square amplitude."""
    first_beam: NonNegativeInt = 0
    """The first of the beams that have it."""
    beams: NonNegativeInt = 0
    """How many have it; 0: all from the first one on."""
    from_s: NonNegative = 0.0
    """Scene time from which on it is received,"""
    to_s: Positive = FOREVER_S
    """and until which."""


class SecondWay(Settings, frozen=True, kw_only=True):
    """A longer path, over the surface say, by which each echo arrives a second time."""

    longer_m: Positive
    """Added slant range."""
    gain_db: Annotated[float, msgspec.Meta(le=0.0)]
    """Level relative to the direct path."""


class ImageLevels(Settings, frozen=True, kw_only=True):
    """From reflected intensity to samples."""

    gain: Positive = 20000.0
    """Counts of amplitude for 1 m2 of fully reflecting, fully lit area in one sample."""
    noise_counts: NonNegative = 30.0
    """Root mean square amplitude of the receiver's noise."""
    looks: Annotated[float, msgspec.Meta(ge=0.5, le=1000.0)] = 1.0
    """Of the speckle: intensity is Gamma distributed with this shape."""
    texture: Annotated[float, msgspec.Meta(ge=0.1, le=1000.0)] | None = None
    """Shape of a Gamma distributed texture beneath the speckle (K distribution): the smaller, the more spiky; left
    out: none."""
    speckle: bool = True
    """False: the mean image, without speckle and noise."""
    range_correlation: Correlation = 0.0
    """Of the speckle's amplitude from one range sample to the next."""
    beam_correlation: Correlation | None = None
    """The same from beam to beam; none: by the overlap of the beams."""
    coherence_s: NonNegative = 0.0
    """Time after which speckle is new; 0: never."""
    max_error: Annotated[float, msgspec.Meta(gt=0.0, le=0.5)] = 0.03
    """Relative error that the mean image may have."""
    tvg: Tvg = Tvg()
    """Spreading, absorption and the gain against them."""
    belts: list[Belt] = msgspec.field(default_factory=list)
    """Errors of the gain over range."""
    beam_gain_db: list[float] = msgspec.field(default_factory=list)
    """Error of each beam's gain; empty: none, or random ones."""
    beam_gain_rms_db: NonNegative = 0.0
    """Standard deviation of random errors of the beams' gains."""
    dropouts: list[Dropout] = msgspec.field(default_factory=list)
    """Dark arcs."""
    drop_ins: list[DropIn] = msgspec.field(default_factory=list)
    """Bright arcs."""
    interference: list[Interference] = msgspec.field(default_factory=list)
    """Other sonars."""
    loud_spells: list[LoudSpell] = msgspec.field(default_factory=list)
    """Noise that comes and goes."""
    second_ways: list[SecondWay] = msgspec.field(default_factory=list)
    """Multipath."""
    saturation_counts: Positive = 1e9
    """Highest amplitude that the receiver passes on."""
    samples: SampleKind = "log8"
    """log8: record 7042's 8-bit logarithm; linear8, linear16: proportional to amplitude."""
    log_factor: Positive = 40.0
    """log8: counts a decade of amplitude."""
    full_scale_counts: Positive = 65535.0
    """linear8, linear16: amplitude of the highest sample value."""

    def __post_init__(self) -> None:
        if self.beam_gain_db and self.beam_gain_rms_db:
            raise ValueError("beam_gain_rms_db: goes without beam_gain_db")
