"""`ods export` on whole, bad and hostile recordings, on a full disk, without the extra."""

import json
import math
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st
from rosbags.highlevel import AnyReader

from ods.base.files.in_file import MOST_TEXT_BYTES
from ods.cli import main
from ods.export.command import FORMATS
from ods.sonar_link.files.opening import open_pings
from tests.export import mission
from tests.export.mission import T_NS
from tests.recording.mcap_samples import OFFSET_NS, Sample, mission as long_mission, write_segment

ROOT = Path(__file__).parents[2]
CONFIG = (ROOT / "config" / "onboard.toml").read_bytes()
TOPICS = ("health", "pose", "ping", "detections", "obstacles")


def recording(path: Path, messages: list[Sample]) -> Path:
    return write_segment(path, messages, attachments={"config.toml": CONFIG})


@pytest.fixture
def record(tmp_path: Path) -> Path:
    """Return a recording of one ping, with all that goes with it."""
    return recording(tmp_path / "a.mcap", [(t, T_NS, m) for t, m in zip(TOPICS, mission.ALL, strict=True)])


def ods(*arguments: str | Path, prelude: str = "") -> "subprocess.CompletedProcess[str]":
    program = f"{prelude}\nimport sys\nfrom ods.cli import main\nsys.exit(main(sys.argv[1:]))"
    command = [sys.executable, "-c", program, *map(str, arguments)]
    # coverage would write, too, with a full disk
    own = {name: value for name, value in os.environ.items() if not name.startswith("COVERAGE_")}
    return subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT, env=own)


@pytest.mark.parametrize("name", FORMATS)
def test_every_format_of_a_recording(
    name: str, record: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / f"out.{name}"
    assert main(["export", str(record), f"--{name}", str(out)]) == 0
    said = capsys.readouterr().out
    assert said.startswith(f"{out}: 5 messages, ")
    assert said.count(",") == 1  # nothing was lost
    assert main(["export", str(record), f"--{name}", str(out)]) == 2
    assert capsys.readouterr().err == f"ods export: {out}: already exists, and is not overwritten\n"


def test_the_times_are_utc_of_what_is_reported(record: Path, tmp_path: Path) -> None:
    main(["export", str(record), "--ros2", str(tmp_path / "bag")])
    with AnyReader([tmp_path / "bag"]) as reader:
        assert {stamp for _, stamp, _ in reader.messages()} == {T_NS + OFFSET_NS}
    main(["export", str(record), "--s7k", str(tmp_path / "a.s7k")])
    (ping,) = open_pings(tmp_path / "a.s7k").pings
    assert abs(ping.utc_ns - T_NS - OFFSET_NS) < 1_000_000


def test_the_site_may_be_another_configurations(record: Path, tmp_path: Path) -> None:
    (tmp_path / "other.toml").write_text("[site]\nlatitude_deg = -10.0\nlongitude_deg = 20.0\n[new]\nx = 1\n")
    out = tmp_path / "out"
    assert main(["export", str(record), "--geojson", str(out), "--config", str(tmp_path / "other.toml")]) == 0
    first = json.loads(out.read_text())["features"][0]["geometry"]["coordinates"]
    assert first[:2] == pytest.approx([20.0, -10.0], abs=0.01)


def test_a_configuration_is_read_as_by_all_commands(
    record: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config, out = tmp_path / "other.toml", tmp_path / "out"
    config.write_bytes(b"\xef\xbb\xbf[site]\r\nlatitude_deg = -10.0\r\nlongitude_deg = 20.0\r\n")
    assert main(["export", str(record), "--geojson", str(out), "--config", str(config)]) == 0
    os.truncate(config, MOST_TEXT_BYTES + 1)
    assert main(["export", str(record), "--csv", str(tmp_path / "tables"), "--config", str(config)]) == 2
    assert capsys.readouterr().err == f"ods export: {config}: larger than 4.19 MB\n"


@pytest.mark.parametrize(
    ("attached", "said"),
    [
        ({}, "the recording has no configuration: give one with --config"),
        ({"config.toml": b"\xff"}, "the recording's configuration: not valid TOML"),
        (
            {"config.toml": b"[site]\nlatitude_deg = 100.0\nlongitude_deg = 1.0"},
            "site.latitude_deg: must be at most 90 (degrees)",
        ),
        ({"config.toml": b"[sonar]"}, "site: missing"),
    ],
)
def test_a_recording_without_a_place(
    attached: dict[str, bytes], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_segment(tmp_path / "a.mcap", long_mission(1), attachments=attached)
    assert main(["export", str(path), "--csv", str(tmp_path / "out")]) == 2
    err = capsys.readouterr().err
    assert said in err
    assert err.count("\n") == 1


def test_nothing_is_left_where_nothing_can_be_exported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    empty = recording(tmp_path / "a.mcap", [])
    for name in FORMATS:
        assert main(["export", str(empty), f"--{name}", str(tmp_path / "out")]) == 2
        assert capsys.readouterr().err == "ods export: there is nothing to export in the recording\n"
    for bad, code in ((tmp_path / "none", 1), (tmp_path, 2), (ROOT / "README.md", 1)):
        assert main(["export", str(bad), "--csv", str(tmp_path / "out")]) == code
        assert capsys.readouterr().err.count("\n") == 1
    assert main(["export", str(empty), "--csv", str(tmp_path / "no" / "out")]) == 2
    assert {path.name for path in tmp_path.iterdir()} == {"a.mcap"}


def test_a_place_that_cannot_be_looked_at_is_one_line(
    record: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / ("x" * 300)  # as for a folder of another user, which root could look into
    assert main(["export", str(record), "--csv", str(out)]) == 2
    assert capsys.readouterr().err == f"ods export: {out}: file name too long\n"


@pytest.mark.parametrize("name", FORMATS)
def test_a_full_disk_is_one_line_and_leaves_nothing(name: str, tmp_path: Path) -> None:
    record = recording(tmp_path / "a.mcap", long_mission(30))
    limit = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (1500, 1500))"
    done = ods("export", record, f"--{name}", tmp_path / "out", prelude=limit)
    assert (done.returncode, done.stderr) == (2, f"ods export: {tmp_path / 'out'}: file too large\n")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("name", "module"), [("ros2", "rosbags"), ("foxglove", "foxglove")])
def test_without_the_extra_it_says_what_to_install(name: str, module: str, record: Path, tmp_path: Path) -> None:
    done = ods("export", record, f"--{name}", tmp_path / "out", prelude=f"import sys; sys.modules['{module}'] = None")
    assert done.returncode == 2
    assert done.stderr.startswith("ods export: needs pip install 'ods[export]': there is no ")
    assert done.stderr.count("\n") == 1
    other = ods("export", record, "--csv", tmp_path / "out", prelude=f"import sys; sys.modules['{module}'] = None")
    assert (other.returncode, other.stderr) == (0, "")


def wild() -> Iterator[Sample]:
    """Yield messages whose numbers no sea has."""
    for number in (math.nan, math.inf, -math.inf, 1e300, -1e300):
        there = (number, 1.0, number)
        rock = msgspec.structs.replace(
            mission.ROCK, id=-(2**63), position_ned=there, velocity_ned=there, radius_m=number, sigma_position=there,
            covariance_ne=number, first_seen_utc_ns=2**64 - 1, last_seen_utc_ns=-(2**63),
        )  # fmt: skip
        yield "obstacles", T_NS, msgspec.structs.replace(mission.LIST, obstacles=[rock, mission.ROCK])
        echo = msgspec.structs.replace(mission.DETECTIONS.detections[0], range_m=number, radius_m=number)
        yield "detections", T_NS, msgspec.structs.replace(mission.DETECTIONS, detections=[echo])
        yield "ping", T_NS, msgspec.structs.replace(mission.PING, dr_m=min(100.0, abs(number)), scale_factor=0.0)
        wide = msgspec.structs.replace(mission.PING, scale="log8", scale_factor=0.0, bearing_rad=[-6.0, 6.0])
        yield "ping", T_NS, wide
        yield "health", T_NS, msgspec.structs.replace(mission.HEALTH, cpu_percent=number, t_ns=2**63 - 1)
        yield "pose", T_NS, msgspec.structs.replace(mission.POSE, position_ned=(math.nan, 0.0, 1e7))


@pytest.mark.parametrize("name", FORMATS)
def test_wild_numbers_are_no_traceback(name: str, tmp_path: Path) -> None:
    record = recording(tmp_path / "a.mcap", [*wild(), ("ping", T_NS, mission.PING)])
    assert main(["export", str(record), f"--{name}", str(tmp_path / "out")]) == 0
    if name == "geojson":
        json.loads((tmp_path / "out").read_text(), parse_constant=lambda text: pytest.fail(f"{text} is no JSON"))


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_damaged_recording_is_exported_or_refused_in_one_line(
    data: st.DataObject, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if not (tmp_path / "whole.mcap").exists():
        write_segment(tmp_path / "whole.mcap", long_mission(3), attachments={"config.toml": CONFIG}, finish=False)
    damaged = bytearray((tmp_path / "whole.mcap").read_bytes())
    for place in data.draw(st.lists(st.integers(0, len(damaged) - 1), min_size=1, max_size=8)):
        damaged[place] ^= data.draw(st.integers(1, 255))
    (tmp_path / "a.mcap").write_bytes(damaged[: data.draw(st.integers(len(damaged) // 2, len(damaged)))])
    name = data.draw(st.sampled_from(["csv", "foxglove", "geojson", "s7k"]))
    out = tmp_path / "out"
    code = main(["export", str(tmp_path / "a.mcap"), f"--{name}", str(out)])
    said = capsys.readouterr()
    assert code in (0, 1, 2)
    assert (said.out + said.err).count("\n") == 1
    subprocess.run(["rm", "-rf", str(out)], check=True)
