"""`ods missions CAMPAIGN.toml --fit FILE`: laws of detections, from image-level missions."""

import time
from collections.abc import Sequence
from pathlib import Path
from statistics import median

import numpy as np
from rich.console import Console
from rich.table import Table

from ods.base.errors import OdsError
from ods.messages import Detections
from ods.missions.detections.fitting import FEWEST, Gathering, Received, clutter_law, echo_law, logit_of
from ods.missions.detections.laws import Errors, Laws, fingerprints, save_laws
from ods.missions.detections.sights import WORDS, fan_of, sights_of
from ods.missions.settings import Campaign
from ods.missions.setup import Setup, flight_of, onboard_of, sonar_of
from ods.missions.watch import OnBoard, head_of
from ods.missions.world import FIRST_TO_FIT

BAND_M = 20.0
"""Of ranges, in the table."""
MISSIONS = 12
LONGEST_ROUND = 100
"""Pings after which the processed ranges are the same again, at most."""


def fit_to_file(campaign: Campaign, path: Path, console: Console) -> None:
    """Fit distributions, write them and print the data that they were fitted to. Raises OdsError."""
    began = time.perf_counter()
    received, laws = fitted(campaign, MISSIONS)
    save_laws(laws, path)
    console.print(table_of(received, laws.sector.range_max_m))
    console.print(
        f"{laws.pings} pings, {laws.echoes} echoes of objects; {laws.clutter.per_scan:.2f} clutter echoes a ping; "
        f"{time.perf_counter() - began:.0f} s"
    )


def fitted(campaign: Campaign, missions: int) -> tuple[Received, Laws]:
    """Return what image-level missions detect, in worlds that no campaign flies, and its laws. Raises OdsError."""
    setup = Setup(sonar_of(campaign), onboard_of(campaign), None)
    if setup.sonar.planes > 1 or setup.sonar.pixels is not None:
        raise OdsError(f"sonar: {setup.sonar.name} sees in 3-D: detections are fitted to sonars of one plane")
    gathering, shown, chain_ms = Gathering(fan_of(setup.sonar)), list[Detections](), list[float]()
    for number in range(FIRST_TO_FIT, FIRST_TO_FIT + missions):
        watch, found = gathered(campaign, number, setup, gathering)
        shown = found if len(found) > len(shown) else shown
        chain_ms += watch.finding_ms
    received = gathering.received()
    whole, cut = received.seen & ~received.cut, received.seen & received.cut
    if whole.sum() < FEWEST:
        raise OdsError(f"--fit: {whole.sum()} echoes of objects in {missions} missions are too few")
    thresholds_db = [each.heard_from_db for each in shown if each.heard_from_db is not None]
    law = echo_law(received, whole)
    return received, Laws(
        **fingerprints(campaign, setup.onboard.pipeline, setup.sonar),
        features=list(WORDS),
        lowest=tuple(received.features.min(axis=0).round(5).tolist()),
        highest=tuple(received.features.max(axis=0).round(5).tolist()),
        seen=_logit(received.features, received.seen),
        faint=_logit(received.features[received.seen], received.faint[received.seen]),
        cut=_logit(received.features[received.seen], received.cut[received.seen]),
        errors=list(Errors._fields),
        whole=law,
        cut_off=echo_law(received, cut) if cut.sum() >= FEWEST else law,
        clutter=clutter_law(gathering.alone, gathering.pings),
        sector=shown[-1].sector,
        processed_ranges_m=round_of([each.processed_ranges_m for each in shown]),
        heard_from_db=median(thresholds_db) if thresholds_db else None,
        chain_ms=round(median(chain_ms), 3),
        pings=gathering.pings,
        echoes=int(received.seen.sum()),
    )


def gathered(campaign: Campaign, number: int, setup: Setup, gathering: Gathering) -> tuple[OnBoard, list[Detections]]:
    """Fly a mission by images and gather what it sees; return the detections, too. Raises OdsError."""
    gathering.begin()
    flight = flight_of(campaign, number, "ods", setup)
    watch, vehicle, fan = flight.watch, flight.vehicle, fan_of(setup.sonar)
    assert isinstance(watch, OnBoard)
    listens_s = 2.0 * fan.range_max_m / fan.sound_speed
    shown = []
    for sent in flight.pings():
        assert watch.newest is not None
        if watch.newest.detections is not None:
            shown.append(watch.newest.detections)
            sights = sights_of(flight.world, vehicle, sent.t_s, fan)
            gathering.take(number, sights, shown[-1], head_of(vehicle, sent.t_s + listens_s))
    return watch, shown


def round_of(ranges: Sequence[list[tuple[float, float]]]) -> list[list[tuple[float, float]]]:
    """Return what comes again and again in what was processed ping by ping, the first being ping 0."""
    for period in range(1, LONGEST_ROUND):
        if all(one == other for one, other in zip(ranges, ranges[period:], strict=False)):
            return list(ranges[:period])
    raise OdsError("--fit: the ranges that pipeline.attention processes do not repeat from ping to ping")


def table_of(received: Received, range_max_m: float) -> Table:
    """Return the fitted data by range, which shows whether there is enough."""
    table = Table("range of the front, m", "objects in view", "probability of detection", "error of the front, m",
                  "of the bearing, beams", "radius over the true one", "level, dB")  # fmt: skip
    near, errors = received.features[:, 1] * range_max_m, Errors(*received.errors.T)
    for low in np.arange(0.0, range_max_m, BAND_M).tolist():
        rows = (near >= low) & (near < low + BAND_M)
        seen = rows & received.seen
        if not seen.any():
            continue
        table.add_row(
            f"{low:.0f} to {low + BAND_M:.0f}",
            f"{rows.sum()}",
            f"{seen.sum() / rows.sum():.3f}",
            *(f"{np.mean(part[seen]):+.2f} ± {np.std(part[seen]):.2f}" for part in (errors.near, errors.bearing)),
            f"{np.exp(np.median(errors.radius[seen])):.2f}",
            f"{np.mean(errors.snr[seen]):.1f}",
        )
    return table


def _logit(features: np.ndarray, happened: np.ndarray) -> tuple[float, ...]:
    return tuple(logit_of(features, happened).round(4).tolist())
