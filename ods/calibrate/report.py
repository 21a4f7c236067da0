"""Report of a calibration: as text, and as lines for the configuration."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from ods.base.frames.mounting import MountingSettings
from ods.calibrate.fit import Fit

TOLD_YAW_DEG, TOLD_PITCH_DEG, TOLD_LATENCY_S = 0.5, 1.0, 0.015
"""A standard error above this is no knowledge: 0.5 deg is 0.9 m at 100 m, 15 ms at 20 deg/s 0.3 deg."""
TO_DETERMINE = {
    "yaw": "pass the object on more different headings",
    "pitch": "pass it higher and lower than it lies, off the bow to both sides, or give its --depth",
    "latency": "turn back and forth while it is in view",
}


class Angle(NamedTuple):
    """One of the results, in the unit in which it is printed."""

    value: float
    sigma: float
    known: bool


def results_of(fit: Fit) -> dict[str, Angle]:
    """Return yaw and pitch, deg, and latency, ms, each with whether the recording determines it."""
    degrees = {
        name: (math.degrees(getattr(fit.parameters, name)), math.degrees(getattr(fit.sigma, name)), most)
        for name, most in (("yaw", TOLD_YAW_DEG), ("pitch", TOLD_PITCH_DEG))
    }
    latency = 1e3 * fit.parameters.latency, 1e3 * fit.sigma.latency, 1e3 * TOLD_LATENCY_S
    return {
        name: Angle(value, sigma, sigma <= most)
        for name, (value, sigma, most) in {**degrees, "latency": latency}.items()
    }


def lines(fit: Fit, mounting: MountingSettings, latency_ms: float) -> Iterator[str]:
    """Yield the report; `mounting`, `latency_ms`: as configured when it was recorded."""
    u, s = fit.parameters, fit.sigma
    yield (
        f"object: north {u.north:.2f}, east {u.east:.2f}, down {u.down:.1f} m (+- {s.north:.2f}, {s.east:.2f}, "
        f"{s.down:.1f}), in {fit.sightings} pings, from {fit.nearest_m:.0f} to {fit.farthest_m:.0f} m, headings over "
        f"{fit.headings_deg:.0f} deg"
    )
    yield f"residuals: {fit.range_rms_m:.2f} m, {math.degrees(fit.bearing_rms):.2f} deg rms"
    results = results_of(fit)
    for name, (value, sigma, known) in results.items():
        if not known:
            yield f"{name}: cannot be determined from this recording: {TO_DETERMINE[name]}"
        elif name == "latency":
            yield f"{name}: pings are stamped {abs(value):.1f} +- {sigma:.1f} ms too {'late' if value > 0 else 'early'}"
        else:
            yield f"{name}: {value:.2f} +- {sigma:.2f} deg"
    yield ""
    yield from _settings(results, mounting, latency_ms)


def _settings(results: dict[str, Angle], mounting: MountingSettings, latency_ms: float) -> Iterator[str]:
    """Yield the tables to put into the configuration; what is not reported stays as it is."""
    if results["latency"].known:
        yield "[sonar]"
        yield f"latency_ms = {latency_ms + results['latency'].value:.1f}"
        yield ""
    yield "[sonar.mounting]"
    yield f"position_m = {list(mounting.position_m)}"
    yield f"roll_deg = {mounting.roll_deg:g}"
    for name, before in (("pitch", mounting.pitch_deg), ("yaw", mounting.yaw_deg)):
        known = results[name].known
        yield f"{name}_deg = {f'{results[name].value:.2f}' if known else f'{before:g}  # not determined'}"
