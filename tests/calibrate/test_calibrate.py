"""`ods calibrate`: mounting and latency that are known come out, with standard errors that hold; or nothing does."""

import math
import tomllib
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
import pytest

from ods.base.clock import NS
from ods.base.errors import OdsError
from ods.base.frames.mounting import MountingSettings
from ods.base.geodesy import LocalFrame
from ods.calibrate.fit import Fit, calibrate
from ods.calibrate.model import HeadPoses
from ods.calibrate.pose_history import PoseHistory
from ods.calibrate.report import lines, results_of
from ods.calibrate.sightings import echoes_of
from ods.cli import main
from ods.messages import Ping, Pose
from ods.recording.s7k import RECORDED_DEVICES, Recorder
from ods.sim_sonar.echo.surface.settings import Surface
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.scene.settings import Oscillation, SceneFile, Sphere, VehiclePath, Waypoint
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.sonar.model import load_sonar
from ods.sonar_link.files.s7k.writer import S7kWriter
from tests.calibrate.fixed_object import NEARER_M, OBJECT, Sonar, around, detections, level_around, past, poses
from tests.recording.mcap_samples import write_segment

pytestmark = pytest.mark.slow

CONFIG = Path(__file__).parents[2] / "config"
SONAR = CONFIG / "sonars" / "seabat6012.toml"
LEVER = (3.0, 0.2, 0.5)
SITE = LocalFrame(57.048, 9.9187)
START_NS = 1_790_000_000 * NS


def fit_of(sonar: Sonar, seed: int, depth_m: float | None = None) -> Fit:
    rig = HeadPoses(PoseHistory(*poses(around)), MountingSettings(position_m=sonar.position))
    return calibrate(echoes_of(detections(sonar, seed), 0), rig, depth_m)


def test_what_is_known_comes_out_with_standard_errors_that_hold() -> None:
    """Yaw 2 deg, pitch -3 deg, 40 ms; the normalized error squared is 1 where a standard error is right."""
    errors = []
    for seed in range(12):
        fit = fit_of(Sonar(), seed)
        u, s = fit.parameters, fit.sigma
        errors.append(
            [
                (u.yaw - math.radians(2.0)) / s.yaw,
                (u.pitch + math.radians(3.0)) / s.pitch,
                (u.latency - 0.04) / s.latency,
            ]
        )
        assert all(result.known for result in results_of(fit).values())
    print("normalized error squared: yaw, pitch, latency", np.mean(np.square(errors), axis=0).round(2))
    assert np.abs(errors).max() < 3.0
    assert 0.5 < np.mean(np.square(errors)) < 1.6
    np.testing.assert_allclose([u.north, u.east], OBJECT[:2], atol=4.0 * max(s.north, s.east))
    assert u.nearer == pytest.approx(NEARER_M, abs=0.05)


def test_a_known_lever_is_no_error_and_a_known_depth_makes_pitch_surer() -> None:
    sonar = Sonar(position=LEVER, yaw_deg=-1.5, pitch_deg=-15.0, late_s=-0.02)
    freely, with_depth = fit_of(sonar, 1), fit_of(sonar, 1, depth_m=float(OBJECT[2]))
    for fit in (freely, with_depth):
        for name, true in (("yaw", math.radians(-1.5)), ("pitch", math.radians(-15.0)), ("latency", -0.02)):
            assert abs(getattr(fit.parameters, name) - true) < 3.5 * getattr(fit.sigma, name)
    assert with_depth.sigma.pitch < freely.sigma.pitch
    text = "\n".join(lines(freely, MountingSettings(position_m=LEVER), 5.0))
    assert "too early" in text
    assert f"position_m = {list(LEVER)}" in text


def test_a_level_vehicle_at_the_object_s_depth_is_not_reported_its_pitch() -> None:
    rig = HeadPoses(PoseHistory(*poses(level_around)), MountingSettings())
    fit = calibrate(echoes_of(detections(Sonar(), 2, level_around), 0), rig)
    results = results_of(fit)
    assert results["yaw"].known
    assert not results["pitch"].known
    text = "\n".join(lines(fit, MountingSettings(pitch_deg=-1.0), 0.0))
    assert "pitch: cannot be determined from this recording" in text
    assert "pitch_deg = -1  # not determined" in text


def test_one_heading_is_refused() -> None:
    rig = HeadPoses(PoseHistory(*poses(past)), MountingSettings())
    with pytest.raises(OdsError, match="from headings within 0 deg only, so any yaw fits: pass it on headings"):
        calibrate(echoes_of(detections(Sonar(), 3, past), 0), rig)


def test_too_few_sightings_are_refused() -> None:
    rig = HeadPoses(PoseHistory(*poses(around)), MountingSettings())
    with pytest.raises(OdsError, match=r"only .* pings show one object at one place"):
        calibrate(echoes_of(detections(Sonar(), 4)[:30], 0), rig)
    with pytest.raises(OdsError, match="no detection"):
        calibrate(echoes_of([], 0), rig)


def messages(sonar: Sonar, seconds: float) -> Iterator[Pose | Ping]:
    """Yield the vehicle's poses, and simulated images of a ball that it goes half round."""
    arc = math.radians(50.0) * np.sin(2.0 * math.pi * np.arange(0.0, seconds + 2.0) / 40.0)
    points = [
        Waypoint(t_s=float(t), position_ned=(-25.0 * math.cos(a), -25.0 * math.sin(a), 10.0 + 3.0 * math.sin(0.3 * t)))
        for t, a in enumerate(arc.tolist())
    ]
    mounting = MountingSettings(position_m=sonar.position, yaw_deg=sonar.yaw_deg, pitch_deg=sonar.pitch_deg)
    ball = Sphere(name="ball", position_ned=(0.0, 0.0, 11.0), radius_m=0.4, surface=Surface(cd=0.5))
    path_of = VehiclePath(
        waypoints=points,
        mounting=mounting,
        yaw=Oscillation(amplitude_deg=45.0, period_s=36.0),
        pitch=Oscillation(amplitude_deg=5.0, period_s=7.0),
        roll=Oscillation(amplitude_deg=5.0, period_s=5.0),
    )
    scene, model = Scene(SceneFile(seed=5, vehicle=path_of, objects=[ball])), load_sonar(SONAR)
    images = ImageSimulator(model, scene)
    for k in range(round(20 * (seconds + 1.0))):
        vehicle, t_ns = scene.vehicle_at(0.05 * k), k * NS // 20
        north, east, down = vehicle.position_ned.tolist()
        w, x, y, z = vehicle.attitude.tolist()
        still = (0.0, 0.0, 0.0)
        yield Pose(k, t_ns, START_NS + t_ns, (north, east, down), (w, x, y, z), still, still, still)
    for number in range(int(seconds / model.ping_period_s)):
        sent_s = number * model.ping_period_s
        t_ns = round((sent_s + sonar.late_s) * NS)
        yield images.ping(sent_s, number, t_ns, START_NS + t_ns)


def record(path: Path, reported: Iterable[Pose | Ping]) -> None:
    """Write messages as `ods record` does, with `--s7k` if that is the suffix."""
    if path.suffix == ".mcap":
        samples = [("pose" if isinstance(each, Pose) else "ping", each.t_ns, each) for each in reported]
        write_segment(path, samples)
        return
    with path.open("xb", buffering=0) as file:
        writer = S7kWriter(file, path.name, START_NS, RECORDED_DEVICES)
        recorder = Recorder(writer, SITE)
        for each in reported:
            recorder.take(each)
        writer.close()


@pytest.mark.parametrize("suffix", ["s7k", "mcap"])
def test_a_simulated_recording_from_images_to_the_lines_to_paste(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], suffix: str
) -> None:
    sonar = Sonar(position=LEVER)
    ball = tmp_path / f"ball.{suffix}"
    record(ball, messages(sonar, 40.0))
    config = tmp_path / "onboard.toml"
    text = (CONFIG / "onboard.toml").read_text(encoding="utf-8")
    text = text.replace("[sonar]", f"[sonar]\nmounting = {{ position_m = {list(LEVER)} }}\nlatency_ms = 2.0")
    config.write_text(
        text.replace('"ins.eds"', f'"{CONFIG}/ins.eds"').replace('"ods_node.eds"', f'"{CONFIG}/ods_node.eds"')
    )
    assert main(["calibrate", str(ball), "--config", str(config)]) == 0
    printed = capsys.readouterr().out
    print(printed)
    reported = tomllib.loads(printed[printed.index("\n\n") :])["sonar"]
    assert reported["mounting"]["yaw_deg"] == pytest.approx(sonar.yaw_deg, abs=0.3)
    assert reported["latency_ms"] == pytest.approx(2.0 + 1e3 * sonar.late_s, abs=12.0)
    assert reported["mounting"]["position_m"] == list(LEVER)
    assert main(["calibrate", str(CONFIG / "onboard.toml"), "--config", str(config)]) == 2
