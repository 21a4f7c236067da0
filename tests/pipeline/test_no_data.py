"""Samples without data are no dark places: nothing is found in them or because of them, and what lies beside them is
found where it is. The images are numpy's own speckle; what is lost is known."""

from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np
import pytest

from ods.base.arrays import Bytes, Floats, Mask
from ods.messages import Detection, Ping
from ods.pipeline.chain import Chain
from ods.pipeline.image.missing.no_data import samples_without_data
from ods.pipeline.prepared.plan import PingError
from ods.pipeline.settings import AttentionSettings, PipelineSettings
from ods.pipeline.stage.params import BUILT_IN
from ods.sonar_link.ping_builder import runs_where
from tests.pipeline.pings import body_echo, fan_bearings, make_ping

pytestmark = pytest.mark.slow

SHAPE = BEAMS, SAMPLES = 60, 2000
BEARINGS = fan_bearings(BEAMS)
COLUMN = np.arange(SAMPLES)


def scattered(rng: np.random.Generator) -> Mask:
    return np.asarray(rng.random(SHAPE) < 0.5)


def cut_short(rng: np.random.Generator) -> Mask:
    return np.asarray(rng.uniform(0, SAMPLES, (BEAMS, 1)) <= COLUMN)


def far_half(_rng: np.random.Generator) -> Mask:
    return np.broadcast_to(COLUMN >= 1000, SHAPE).copy()


def half_dead(rng: np.random.Generator) -> Mask:
    return np.broadcast_to(rng.permutation(BEAMS)[:, None] < BEAMS // 2, SHAPE).copy()


def one_side_dead(_rng: np.random.Generator) -> Mask:
    return np.broadcast_to(np.arange(BEAMS)[:, None] < BEAMS // 2, SHAPE).copy()


PATTERNS = [scattered, cut_short, far_half, half_dead, one_side_dead]


def counts_of(rng: np.random.Generator, lost: Mask, intensity: Floats | float = 1.0) -> Bytes:
    amplitude = 30.0 * np.sqrt(intensity * rng.exponential(size=SHAPE))
    return np.where(lost, 0, np.minimum(amplitude, 255.0)).astype(np.uint8)


def reported(counts: Bytes, lost: Mask, number: int = 0) -> Ping:
    return make_ping(counts, no_data=runs_where(lost), seq=number)


def find_in_speckle(chain: Chain, lose: Callable[[np.random.Generator], Mask], images: int, tell: bool) -> int:
    rng, count = np.random.default_rng(3), 0
    for number in range(images):
        lost = lose(rng)
        ping = make_ping(counts_of(rng, lost), no_data=runs_where(lost) if tell else [], seq=number)
        count += len(chain.process(ping).detections)
    return count


@pytest.mark.parametrize("lose", PATTERNS)
@pytest.mark.parametrize("tell", [True, False])
def test_default_chain_finds_no_more_in_speckle_than_in_whole_images(
    lose: Callable[[np.random.Generator], Mask], tell: bool
) -> None:
    """Of whole images, 0.08 each; the far half missing alone gave 300 each."""
    assert find_in_speckle(Chain(PipelineSettings()), lose, 15, tell) <= 5


FILTERS = sorted(name for name in BUILT_IN if not name.startswith("detect.") and name != "equalize.mean_range")


@pytest.mark.parametrize("name", FILTERS)
def test_no_stage_makes_echoes_of_gaps(name: str) -> None:
    """Measured over what the same stages make of whole images."""
    stages = ({"use": "equalize.mean_range"}, {"use": name}, {"use": "filter.box"}, {"use": "detect.two_level"})
    chains = [Chain(PipelineSettings(stage=stages)) for _ in range(3)]
    whole = find_in_speckle(chains[0], lambda _: np.zeros(SHAPE, np.bool_), 10, True)
    assert find_in_speckle(chains[1], cut_short, 10, True) <= 1.5 * whole + 6
    assert find_in_speckle(chains[2], far_half, 10, True) <= 1.5 * whole + 6


@pytest.mark.parametrize("method", ["ca", "goca", "soca", "os"])
def test_cfar_leaves_gaps_out_of_the_surroundings(method: str) -> None:
    stages: tuple[dict[str, Any], ...] = (
        {"use": "equalize.mean_range"}, {"use": "filter.fir"}, {"use": "detect.cfar", "method": method},
    )  # fmt: skip
    chain = Chain(PipelineSettings(stage=stages), learnt_cells=2_000_000)
    assert find_in_speckle(chain, cut_short, 10, True) <= 6


def near(detections: list[Detection], range_m: float, bearing: float) -> list[Detection]:
    return [d for d in detections if np.hypot(d.range_m - range_m, range_m * (d.bearing_rad - bearing)) < 2.5]


@pytest.mark.parametrize("lose", PATTERNS)
def test_objects_where_data_are_are_found_in_their_places_and_those_in_gaps_are_not(
    lose: Callable[[np.random.Generator], Mask],
) -> None:
    places = [(r, float(b)) for r in (20.0, 45.0, 70.0, 90.0) for b in (-0.5, -0.2, 0.25, 0.6)]
    intensity = 1.0 + sum(60.0 * body_echo("half", 1.0, r, b, BEARINGS, SAMPLES) for r, b in places)
    rng, chain = np.random.default_rng(8), Chain(PipelineSettings())
    for number in range(4):
        lost = lose(rng)
        counts = counts_of(rng, lost & False, intensity)  # an echo there is, but the decoder says: no data
        ping, marks = reported(counts, lost, number), np.zeros(SHAPE, np.int32)
        detections = chain.process(ping, marks).detections
        assert not marks[lost & (marks > 0)].any() or lose is scattered
        for range_m, bearing in places:
            around = body_echo("half", 2.5, range_m, bearing, BEARINGS, SAMPLES) > 0.02
            found = near(detections, range_m, bearing)
            if lost[around].all():
                assert not found
            elif lost[around].mean() < 0.02:
                assert len(found) == 1
                assert abs(found[0].near_m - (range_m - 1.0)) < 0.6


@pytest.mark.parametrize("tell", [True, False])
@pytest.mark.parametrize(
    ("shape", "radius", "range_m"), [("half", 1.5, 25.0), ("half", 3.0, 40.0), ("disc", 1.5, 50.0)]
)
def test_a_body_behind_a_dead_beam_is_one_body_in_its_place(
    shape: str, radius: float, range_m: float, tell: bool
) -> None:
    """It fell to two pieces, each half as large, 14 times as far aside as they claimed (mean of squares)."""
    rng, chain, wrong = np.random.default_rng(2), Chain(PipelineSettings()), []
    for number in range(15):
        bearing, beam = float(rng.uniform(-0.3, 0.3)), np.arange(BEAMS)[:, None]
        lost = np.broadcast_to(beam == np.abs(BEARINGS - bearing).argmin(), SHAPE)
        intensity = 1.0 + 60.0 * body_echo(shape, radius, range_m, bearing, BEARINGS, SAMPLES)
        counts = counts_of(rng, lost, intensity)
        found = near(
            chain.process(reported(counts, lost, number) if tell else make_ping(counts)).detections, range_m, bearing
        )
        assert len(found) == 1
        assert not found[0].cut
        wrong.append([(found[0].bearing_rad - bearing) / found[0].sigma_bearing_rad, found[0].radius_m / radius])
    assert np.mean(np.square(wrong), 0)[0] < 3.0
    assert 0.7 < np.mean(wrong, 0)[1] < 1.3


@pytest.mark.parametrize(("first", "stop"), [(30, 60), (29, 31), (31, 33), (0, 30)])
def test_a_body_of_which_dead_beams_hide_a_part_is_cut_off(first: int, stop: int) -> None:
    rng, chain = np.random.default_rng(2), Chain(PipelineSettings())
    lost = np.zeros(SHAPE, np.bool_)
    lost[first:stop] = True
    intensity = 1.0 + 60.0 * body_echo("half", 3.0, 30.0, 0.0, BEARINGS, SAMPLES)
    found = near(chain.process(reported(counts_of(rng, lost, intensity), lost)).detections, 30.0, 0.0)
    assert found
    assert all(echo.cut and echo.sigma_bearing_rad * 30.0 > 4.0 for echo in found)


def test_zeros_that_are_data_cut_nothing_off() -> None:
    """A sonar that tells amplitudes over a threshold only, as floats."""
    rng = np.random.default_rng(4)
    amplitude = 120.0 * np.sqrt(body_echo("half", 1.5, 40.0, 0.0, BEARINGS, SAMPLES) * rng.exponential(size=SHAPE))
    amplitude[amplitude < 10.0] = 0.0
    found = near(Chain(PipelineSettings()).process(make_ping(amplitude.astype(np.float32))).detections, 40.0, 0.0)
    assert len(found) == 1
    assert not found[0].cut


def test_an_echo_that_is_strewn_with_losses_is_found() -> None:
    rng, chain = np.random.default_rng(5), Chain(PipelineSettings())
    intensity = 1.0 + 60.0 * body_echo("half", 1.5, 50.0, 0.1, BEARINGS, SAMPLES)
    for number in range(5):
        lost = scattered(rng)
        ping = make_ping(counts_of(rng, lost, intensity), seq=number)
        assert len(near(chain.process(ping).detections, 50.0, 0.1)) == 1


@pytest.mark.parametrize("rms", [0.2, 0.5, 0.7, 1.5])
def test_quiet_image_is_data_and_shows_only_what_is_there(rms: float) -> None:
    """8 bits, linear, most samples 0: without dither 1450 false echoes an image at 0.5 counts rms."""
    rng, chain, false, found = np.random.default_rng(6), Chain(PipelineSettings()), 0, 0
    for number in range(20):
        echo = 12.0**2 * body_echo("half", 1.5, 50.0, 0.1, BEARINGS, SAMPLES) if number % 2 else 0.0
        counts = np.sqrt((rms**2 + echo) * rng.exponential(size=SHAPE)).astype(np.uint8)
        ping = make_ping(counts, seq=number)
        assert samples_without_data(ping, counts, 0, 255.0).sum() < 0.01 * counts.size
        detections = chain.process(ping).detections
        hits = len(near(detections, 50.0, 0.1))
        found, false = found + min(hits, 1), false + len(detections) - hits
    assert found == 10
    assert false <= 5


def test_what_the_samples_tell_of_gaps_is_what_was_lost() -> None:
    rng = np.random.default_rng(4)
    for lose in PATTERNS[1:]:
        lost = lose(rng)
        lost[:, :40] = False  # what is left of a beam must show that it is loud
        counts = counts_of(rng, lost)
        found = samples_without_data(make_ping(counts), counts, 0, 255.0)
        assert (found != lost).mean() < 0.002


def test_levels_that_fall_to_nothing_are_data() -> None:
    """A sonar without TVG: far samples are 0 because nothing is received any more, in one beam a little earlier."""
    rng = np.random.default_rng(4)
    counts = np.minimum(3e4 / (COLUMN + 50.0) ** 1.7 * np.sqrt(rng.exponential(size=SHAPE)), 255.0).astype(np.uint8)
    assert (counts[:, -500:] == 0).all()
    assert samples_without_data(make_ping(counts), counts, 0, 255.0).sum() < 0.02 * counts.size


def test_sonar_that_shows_only_what_is_over_a_threshold_is_not_taken_for_one_that_lacks_data() -> None:
    rng = np.random.default_rng(4)
    echoes = sum(body_echo("disc", 1.5, r, b, BEARINGS, SAMPLES) for r, b in [(20, -0.3), (60, 0.2), (80, 0.5)])
    counts = (120.0 * np.sqrt(echoes * rng.exponential(size=SHAPE))).astype(np.uint8)
    counts[counts < 10] = 0
    assert samples_without_data(make_ping(counts), counts, 0, 255.0).sum() < 0.005 * counts.size
    assert all(
        near(Chain(PipelineSettings()).process(make_ping(counts)).detections, r, b) for r, b in [(20, -0.3), (80, 0.5)]
    )


def test_gaps_are_known_in_rings_of_attention_and_averaged_samples() -> None:
    attention = AttentionSettings(near_m=20.0, every=3, margin_m=3.0, subsample=2)
    chain = Chain(PipelineSettings(attention=attention))
    assert find_in_speckle(chain, cut_short, 24, True) <= 8


@pytest.mark.parametrize("value", [1, 77, 254])
@pytest.mark.parametrize("dtype", ["u1", "<f4"])
def test_beams_that_are_stuck_at_one_value_are_unseen(value: int, dtype: str) -> None:
    chain, rng = Chain(PipelineSettings()), np.random.default_rng(3)
    stuck = one_side_dead(rng)
    for number in range(3):
        counts = np.where(stuck, value, counts_of(rng, np.zeros(SHAPE, np.bool_))).astype(dtype)
        found = chain.process(make_ping(counts, seq=number))
        assert found.unseen_why == "no data in 50% of the image"
        assert {each.why for each in found.unseen} == {"no data"}
        assert not [each for each in found.detections if each.bearing_rad < 0.0]


def test_beams_that_show_nothing_over_the_sonar_s_threshold_are_data() -> None:
    rng = np.random.default_rng(3)
    counts = np.maximum(counts_of(rng, np.zeros(SHAPE, np.bool_)), 60)
    counts[::2] = 60
    assert not samples_without_data(make_ping(counts), counts, 0, 255.0).any()


@pytest.mark.parametrize("run", [(60, 0, 5), (-1, 0, 5), (0, 5, 5), (0, 5, 2001), (0, -1, 5)])
def test_runs_that_the_ping_does_not_have_are_refused(run: tuple[int, int, int]) -> None:
    counts = counts_of(np.random.default_rng(1), np.zeros(SHAPE, np.bool_))
    with pytest.raises(PingError, match="no_data"):
        Chain(PipelineSettings()).process(make_ping(counts, no_data=[run]))


def test_pings_recorded_before_there_were_gaps_are_read() -> None:
    ping = make_ping(np.ones((2, 3), np.uint8))
    fields = msgspec.msgpack.decode(msgspec.msgpack.encode(ping))
    del fields["no_data"]
    assert msgspec.msgpack.decode(msgspec.msgpack.encode(fields), type=Ping) == ping
