"""The simulated Sonar 3D-15: its packets by our codec and by the maker's own client, which writes some for ours."""

import math
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from ods.base.arrays import Floats32
from ods.base.frames.geometry import polar_to_body
from ods.messages import frame_of
from ods.sim_sonar.device.sonars import sonar3d15_packets as wire
from ods.sim_sonar.device.sonars.sonar3d15 import SimulatedSonar3d15
from ods.sim_sonar.device.sonars.sonar3d15_packets import ImageSays
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.range_image import RangeImages, RangeSonar, range_image
from ods.sim_sonar.sonar.model import load_sonar
from ods.sonar_link.ping_builder import Stamp
from ods.sonar_link.sonar3d15 import packets
from ods.sonar_link.sonar3d15.image import ping_of
from tests.range_images import SONAR, scene_of, shipped_scene, sphere

CONFIG = Path(__file__).parents[2] / "config"
SAYS = ImageSays(1_700_000_000_123_456_789, 4242, 1480.0, 15.0, 1_200_000, (90.0, 40.0), 0.001)


@pytest.fixture
def wlsonar() -> ModuleType:
    """Water Linked's client, of PyPI; `pip install ods[peers]`."""
    return pytest.importorskip("wlsonar.range_image_protocol")  # type: ignore[no-any-return]


def ranges(seed: int = 0) -> Floats32:
    rng = np.random.default_rng(seed)
    return np.where(rng.random((64, 256)) < 0.3, 0.0, rng.uniform(0.05, 15.0, (64, 256))).astype(np.float32)


def test_our_codec_reads_it() -> None:
    found = packets.unpack(wire.range_image(SAYS, ranges()))
    image = packets.decode_range_image(found.message)
    ping = ping_of(image, Stamp(0, 0, 0, 0))
    np.testing.assert_allclose(frame_of(ping).astype(float).T * ping.dr_m, ranges(), atol=0.0006)
    assert (image.time_ns, image.number) == SAYS[:2]
    assert packets.unpack(wire.strength_image(SAYS, np.zeros((64, 256), np.uint8))).kind == packets.BITMAP


def test_the_makers_client_reads_it(wlsonar: ModuleType) -> None:
    reported = wlsonar.unpackb(wire.range_image(SAYS, ranges()))
    assert type(reported).__name__ == "RangeImage"
    numbers = np.array(reported.image_pixel_data).reshape(reported.height, reported.width)
    np.testing.assert_array_equal(numbers, np.rint(ranges() / SAYS.scale_m).astype(int))
    assert reported.header.timestamp.ToNanoseconds() == SAYS.time_ns
    assert (reported.header.sequence_id, reported.range, reported.speed_of_sound) == (4242, 15.0, 1480.0)
    assert (reported.fov_horizontal, reported.fov_vertical) == (90.0, 40.0)
    strengths = np.arange(64 * 256, dtype=np.int64).astype(np.uint8).reshape(64, 256)
    picture = wlsonar.unpackb(wire.strength_image(SAYS, strengths))
    assert picture.image_pixel_data == strengths.tobytes()


@pytest.mark.parametrize("name", ["RIP1", "RIP2"])
def test_ours_reads_what_the_makers_client_writes(wlsonar: ModuleType, name: str) -> None:
    numbers = np.rint(ranges(3) / 0.001).astype(int)
    made = wlsonar.RangeImage(
        speed_of_sound=1500.0, range=15.0, frequency=5, width=256, height=64, fov_horizontal=90.0, fov_vertical=40.0,
        image_pixel_scale=0.001, image_pixel_data=numbers.ravel().tolist(),
    )  # fmt: skip
    made.header.sequence_id = 99
    made.header.timestamp.FromNanoseconds(SAYS.time_ns)
    packet = wlsonar.packb(made, protocol=wlsonar.ProtocolVersion[name])
    assert packets.fault_of(packet) == ""
    assert packets.is_sound(packet)
    image = packets.decode_range_image(packets.unpack(packet).message)
    ping = ping_of(image, Stamp(0, 0, 0, 0))
    np.testing.assert_array_equal(frame_of(ping), numbers.T)
    assert (image.number, image.time_ns, ping.frequency_hz) == (99, SAYS.time_ns, 0.0)


def test_directions_are_those_of_the_makers_client(wlsonar: ModuleType) -> None:
    del wlsonar  # it is installed
    from wlsonar import range_image_to_xyz  # type: ignore[import-not-found, import-untyped, unused-ignore]
    from wlsonar.range_image_protocol import unpackb  # type: ignore[import-not-found, import-untyped, unused-ignore]

    packet = wire.range_image(SAYS, ranges())
    theirs = range_image_to_xyz(unpackb(packet))
    ping = ping_of(packets.decode_range_image(packets.unpack(packet).message), Stamp(0, 0, 0, 0))
    assert ping.range_grid is not None
    range_m = frame_of(ping).astype(float).T * ping.dr_m
    ours = polar_to_body(range_m, np.array(ping.bearing_rad)[None, :], np.array(ping.range_grid.elevation_rad)[:, None])
    for one, other in zip(ours.reshape(-1, 3), theirs, strict=True):
        assert other is None or math.dist(one, other) < 1e-4


def test_ranges_of_a_sphere_and_a_bottom_are_those_of_geometry() -> None:
    exact = RangeSonar(*SONAR[:3], noise_m=0.0, missing=0.0, false=0.0)
    seen = range_image(exact, scene_of(sphere(9.0, 0.0, 20.0)), 0.0, 0)
    assert seen.shape == (64, 256)
    assert seen[31:33, 127:129].max() == pytest.approx(8.5, abs=0.01)
    lowest = seen[0, 20]
    assert lowest == pytest.approx(2.6 / math.sin(math.radians(20.0)), rel=1e-5)
    assert not seen[40:, :100].any()


def test_a_telegram_is_one_image_and_its_strengths_and_the_same_again() -> None:
    images = ImageSimulator(load_sonar(CONFIG / "sonars" / "sonar3d15.toml"), shipped_scene())
    end = SimulatedSonar3d15(images)
    first, second = (end.telegram(images, 2.0, 12, 0, SAYS.time_ns) for _ in range(2))
    assert first == second
    assert [packets.unpack(packet).kind for packet in first] == [packets.RANGE_IMAGE, packets.BITMAP]
    assert max(map(len, first)) < packets.MAX_PACKET_BYTES
    assert end.period_s(images.sonar) == pytest.approx(1.0 / 6.0, rel=0.02)


def test_its_pings_hold_the_ranges_and_directions_of_its_images() -> None:
    scene, model = scene_of(sphere(9.0, 3.0, 19.0)), load_sonar(CONFIG / "sonars" / "sonar3d15.toml")
    ping = RangeImages(model, scene).ping(0.0, 7, 0, 0)
    assert ping.range_grid is not None
    assert (ping.beams, ping.samples) == model.pixels == (256, 64)
    image = range_image(SONAR, scene, 0.0, 7)  # opens as far
    np.testing.assert_allclose(frame_of(ping).astype(float).T * ping.dr_m, image, atol=0.51 * ping.dr_m)
    np.testing.assert_allclose(ping.bearing_rad, SONAR.bearing_rad)
    np.testing.assert_allclose(ping.range_grid.elevation_rad, SONAR.elevation_rad)


def test_a_sonar_without_pixels_sends_no_range_images() -> None:
    with pytest.raises(ValueError, match="no pixels"):
        RangeImages(load_sonar(CONFIG / "sonars" / "seabat6012.toml"), shipped_scene())
