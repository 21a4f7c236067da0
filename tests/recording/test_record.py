"""`ods record` on a live chain: read back by ods, by the tables of the format's definition and by pyread7k; faults."""

import json
import math
import signal
import subprocess
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from ods.cli import main
from ods.messages import Ping, frame_of
from ods.sonar_link.files.opening import open_pings
from ods.sonar_link.files.s7k.writer import write_s7k
from tests.recording.record_samples import (
    HEADING,
    LATITUDE_DEG,
    LONGITUDE_DEG,
    PERIOD_NS,
    PITCH,
    ROLL,
    START_NS,
    VEHICLE_NED,
    Chain,
    chain,
    obstacles_at,
    pose_at,
    rock,
    simulated_pings,
    wait_for,
)
from tests.sonar_link import s7k_tables

PINGS = 6
POSE_NS = 10_000_000
RESOLUTION = timedelta(microseconds=2)
"""Of a 7KTIME, whose seconds are float32."""


@dataclass
class Recording:
    path: Path
    pings: list[Ping]
    said: str


def publish_all(live: Chain, path: Path, pings: list[Ping]) -> None:
    """Publish pings, 15 poses a ping and an obstacle seen at each but the last, at which it is terminated."""
    live.publish_until_recorded(path, pose_at(START_NS - POSE_NS))
    live.publish_until_recorded(path, obstacles_at(START_NS, 0, rock(START_NS)))
    live.publish_until_recorded(path, pings[0])
    for number, ping in enumerate(pings[1:], 1):
        for step in range(15):
            live.publish(pose_at(ping.utc_ns - PERIOD_NS + step * POSE_NS, 15 * number + step))
        live.publish(ping)
        seen, state = (ping.utc_ns, "active") if ping is not pings[-1] else (ping.utc_ns - PERIOD_NS, "terminated")
        for seq in (2 * number, 2 * number + 1):
            live.publish(
                obstacles_at(ping.utc_ns, seq, rock(seen, "terminated" if state == "terminated" else "active"))
            )


@pytest.fixture(scope="module", params=["7042", "7018"])
def recording(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Recording:
    path = tmp_path_factory.mktemp("recording") / "mission.s7k"
    pings = simulated_pings(PINGS, linear16=request.param == "7018")
    with chain("sonar", "tracker", "nav") as live:
        recorder = live.record("--s7k", str(path))
        publish_all(live, path, pings)
        wait_for(lambda: path.read_bytes().count(b"terminated") == 1)
        recorder.send_signal(signal.SIGINT)
        said, errors = recorder.communicate(timeout=20)
    assert (recorder.returncode, errors) == (0, "")
    return Recording(path, pings, said)


def of_type(records: list[s7k_tables.Raw], kind: int) -> list[s7k_tables.Raw]:
    return [record for record in records if record.type == kind]


def last_pings(records: list[s7k_tables.Raw], kind: int) -> list[s7k_tables.Raw]:
    """Return the records of the pings; the first was published until it was received, so perhaps more than once."""
    return of_type(records, kind)[-PINGS:]


def utc(ns: int) -> datetime:
    return datetime.fromtimestamp(ns // 10**9, UTC) + timedelta(microseconds=ns % 10**9 // 1000)


def test_ods_reads_identical_pings(recording: Recording) -> None:
    sequence = open_pings(recording.path)
    assert len(sequence.pings) == PINGS
    for back, ping in zip(sequence.pings, recording.pings, strict=True):
        assert back.data == ping.data
        assert abs(back.utc_ns - ping.utc_ns) <= 2000
        for name in ("ping_number", "beams", "samples", "dtype", "scale", "scale_factor", "planes"):
            assert getattr(back, name) == getattr(ping, name)
        for name in ("range0_m", "dr_m", "sound_speed", "frequency_hz", "bearing_rad", "beam_width_rad"):
            assert getattr(back, name) == pytest.approx(getattr(ping, name), rel=2e-7)
    assert set(sequence.losses) <= {"other_records", "duplicate_pings"}


def test_ods_detect_reads_a_recording(recording: Recording, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["detect", str(recording.path), "--json"]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [line["ping_number"] for line in lines] == list(range(PINGS))


def test_the_definition_s_tables_read_identical_pings(recording: Recording) -> None:
    records = s7k_tables.read(recording.path)
    kind = 7042 if recording.pings[0].dtype == "u1" else 7018
    settings, geometry, samples = (last_pings(records, number) for number in (7000, 7004, kind))
    for ping, setting, table, water in zip(recording.pings, settings, geometry, samples, strict=True):
        assert np.array_equal(s7k_tables.samples(water), frame_of(ping))
        assert setting.head["ping_number"] == water.head["ping_number"] == ping.ping_number
        assert setting.head["sound_velocity"] == pytest.approx(ping.sound_speed)
        assert setting.head["frequency"] == pytest.approx(ping.frequency_hz)
        spacing = setting.head["sound_velocity"] / 2.0 / setting.head["sample_rate"]
        assert spacing == pytest.approx(ping.dr_m, rel=2e-7)
        first = water.head.get("first_sample", 0)
        assert first * spacing == pytest.approx(ping.range0_m, rel=1e-6)
        assert setting.head["range"] == pytest.approx(ping.range0_m + ping.samples * ping.dr_m)
        angles = np.frombuffer(table.data, "<f4").reshape(4, ping.beams)
        assert np.array_equal(angles[1], np.array(ping.bearing_rad, np.float32))
        assert np.array_equal(angles[3], np.array(ping.beam_width_rad, np.float32))
        assert not angles[[0, 2]].any()
        for record in (setting, table, water):
            assert abs(s7k_tables.instant(record.frame["time"]) - utc(ping.utc_ns)) <= RESOLUTION
            assert (record.frame["device"], record.frame["flags"]) == (7000, 0x8001)
        assert setting.at < table.at < water.at


def test_header_and_catalogue_tell_where_everything_is(recording: Recording) -> None:
    records = s7k_tables.read(recording.path)
    header, catalogue = records[0], records[-1]
    assert (header.type, catalogue.type) == (7200, 7300)
    assert header.frame["optional_id"] == 7300
    place = np.frombuffer(header.optional, np.dtype([("size", "<u4"), ("offset", "<u8")]))[0]
    assert place.item() == (catalogue.frame["size"], catalogue.at)
    assert header.head["name"].rstrip(b"\0") == b"mission.s7k"
    devices = np.frombuffer(header.data, np.dtype([("device", "<u4"), ("enumerator", "<u2")]))
    assert devices["device"].tolist() == [7000, 100, 101, 102]
    assert (header.head["data_size"], header.head["devices"]) == (len(header.data), 4)
    entries = np.frombuffer(catalogue.data, s7k_tables.CATALOGUE_ENTRY)
    assert (catalogue.head["size"], catalogue.head["version"]) == (14, 1)
    assert catalogue.head["records"] == len(entries) == len(records) - 1
    for entry, record in zip(entries, records[:-1], strict=True):
        assert entry["offset"] == record.at
        assert (entry["size"], entry["type"], entry["device"]) == tuple(
            record.frame[name] for name in ("size", "type", "device")
        )
        assert entry["time"].ljust(10, b"\0") == record.frame["time"]


def place_of(north: float, east: float) -> tuple[float, float]:
    """Return latitude and longitude, rad, by the ellipsoid's radii of curvature: good to millimetres at 200 m."""
    a, e2, latitude = 6378137.0, 0.00669437999014, math.radians(LATITUDE_DEG)
    root = math.sqrt(1.0 - e2 * math.sin(latitude) ** 2)
    meridian, normal = a * (1.0 - e2) / root**3, a / root
    there = latitude + north / meridian
    return there, math.radians(LONGITUDE_DEG) + east / (normal * math.cos(latitude))


def test_the_obstacle_is_a_contact_created_modified_and_deleted(recording: Recording) -> None:
    contacts = of_type(s7k_tables.read(recording.path), 3001)
    assert [contact.head["state"] for contact in contacts] == [0] + [1] * (PINGS - 2) + [2]
    assert [contact.head["ping_number"] for contact in contacts] == [0, *range(2, 2 * PINGS, 2)]
    for contact in contacts:
        head = contact.head
        assert (head["target"], head["flags"], contact.frame["size"]) == (7, 0b1101, 64 + 446 + 4)
        assert head["range"] == pytest.approx(50.0, abs=1e-4)
        ahead, below = 30.0 * math.cos(PITCH), 30.0 * math.sin(PITCH)
        starboard = 40.0 * math.cos(ROLL) + below * math.sin(ROLL)
        assert head["bearing"] == pytest.approx(math.atan2(starboard, ahead), abs=1e-6)
        north, east, _ = rock(0).position_ned
        assert (head["latitude"], head["longitude"]) == pytest.approx(place_of(north, east), abs=2e-9)
        assert (head["length"], head["width"], head["azimuth"]) == (3.0, 3.0, 0.0)
        assert head["operator"].rstrip(b"\0") == b"ods"
        assert (
            head["description"].rstrip(b"\0").startswith(b"down=15.0 v=0.00,0.00,0.00 sigma=0.2,0.3,3.0 sr=0.1 p=0.97")
        )
    assert [contact.head["classification"].rstrip(b"\0") for contact in contacts[-2:]] == [b"active", b"terminated"]
    modified = contacts[1]
    assert abs(s7k_tables.instant(modified.head["time"]) - utc(START_NS + PERIOD_NS)) <= RESOLUTION


def test_poses_are_position_attitude_and_heading_twenty_times_a_second(recording: Recording) -> None:
    records = s7k_tables.read(recording.path)
    position, attitude, heading = (of_type(records, kind) for kind in (1003, 1012, 1013))
    assert len(position) == len(attitude) == len(heading)
    times = [s7k_tables.instant(record.frame["time"]) for record in position]
    steps = [(b - a).total_seconds() for a, b in pairwise(times)][-(3 * (PINGS - 1) - 1) :]
    assert steps == pytest.approx([0.05] * len(steps), abs=1e-5)
    assert (position[-1].head["latitude"], position[-1].head["longitude"]) == pytest.approx(
        place_of(*VEHICLE_NED[:2]), abs=2e-9
    )
    assert position[-1].head["height"] == pytest.approx(-VEHICLE_NED[2], abs=0.01)
    assert (attitude[-1].head["roll"], attitude[-1].head["pitch"], attitude[-1].head["heave"]) == pytest.approx(
        (ROLL, PITCH, 0.0),
        abs=4e-5,  # level is not level at the site 126 m away
    )
    assert heading[-1].head["heading"] == pytest.approx(HEADING, abs=2e-5)
    assert [record.frame["device"] for record in (position[-1], attitude[-1], heading[-1])] == [100, 102, 101]


def test_the_summary_says_what_was_written(recording: Recording) -> None:
    written = [len(of_type(s7k_tables.read(recording.path), kind)) for kind in (7000, 3001, 1003)]
    counts = "{} pings, {} contacts, {} poses".format(*written)
    assert recording.said.startswith(f"{recording.path}: {counts}, ")


def check_with_pyread7k(path: Path, pings: list[Ping]) -> None:
    """Let Teledyne's own reader, where it is installed, read the file."""
    pyread7k = pytest.importorskip("pyread7k")
    dataset = pyread7k.PingDataset(str(path)).pings[-len(pings) :]
    for read, ping in zip(dataset, pings, strict=True):
        settings = read.sonar_settings
        assert (read.ping_number, settings.sound_velocity) == (ping.ping_number, pytest.approx(ping.sound_speed))
        assert settings.sound_velocity / 2.0 / settings.sample_rate == pytest.approx(ping.dr_m, rel=2e-7)
        assert abs(settings.frame.time.replace(tzinfo=UTC) - utc(ping.utc_ns)) <= RESOLUTION
        assert np.array_equal(read.beam_geometry.horizontal_angles, np.array(ping.bearing_rad, np.float32))
        assert read.has_beamformed == (ping.dtype == "u2")  # it has no record 7042
        if read.has_beamformed:
            assert np.array_equal(read.beamformed.amplitudes.T, frame_of(ping))
    header = pyread7k.S7KFileReader(str(path)).file_header
    assert header.recording_name == path.name


def test_pyread7k_reads_identical_pings_and_the_pose(recording: Recording) -> None:
    check_with_pyread7k(recording.path, recording.pings)
    pyread7k = pytest.importorskip("pyread7k")
    read = pyread7k.PingDataset(str(recording.path)).pings[-2]
    assert (read.position_set[0].latitude, read.position_set[0].longitude) == pytest.approx(
        place_of(*VEHICLE_NED[:2]), abs=2e-9
    )
    assert read.heading_set[0].heading == pytest.approx(HEADING, abs=2e-5)
    assert read.roll_pitch_heave_set[0].pitch == pytest.approx(PITCH, abs=4e-5)


def test_pyread7k_reads_a_file_that_was_cut_off_and_completed(tmp_path: Path) -> None:
    path = tmp_path / "cut.s7k"
    pings = simulated_pings(3, linear16=True)
    write_s7k(path, pings)
    samples = of_type(s7k_tables.read(path), 7018)[-1]
    path.write_bytes(path.read_bytes()[: samples.at + samples.frame["size"] + 100])
    assert main(["record", "--finish", str(path)]) == 0
    check_with_pyread7k(path, pings)


# --- faults


def test_kill_9_costs_no_ping_that_was_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "killed.s7k"
    pings = simulated_pings(PINGS, linear16=True)
    with chain("sonar") as live:
        recorder = live.record("--s7k", str(path))
        live.publish_until_recorded(path, pings[0])
        for ping in pings[1:]:
            live.publish_until_recorded(path, ping)
        recorder.kill()
        recorder.communicate()
    settings = of_type(s7k_tables.read(path), 7000)[-1]
    with path.open("ab") as file:
        file.write(path.read_bytes()[settings.at : settings.at + 150])  # a write that the kill cut short
    sequence = open_pings(path)
    assert [ping.data for ping in sequence.pings] == [ping.data for ping in pings]
    assert sequence.losses["truncated_record"] == 1
    assert main(["record", "--finish", str(path)]) == 0
    assert f"{path}: complete, " in capsys.readouterr().out
    whole = path.read_bytes()
    assert main(["record", "--finish", str(path)]) == 0
    assert path.read_bytes() == whole
    records = s7k_tables.read(path)
    assert (records[0].type, records[-1].type) == (7200, 7300)
    assert len(records) == records[-1].head["records"] + 1


def ended(recorder: "subprocess.Popen[str]") -> str:
    """Return the one line that a recorder says before it ends with an error."""
    said, errors = recorder.communicate(timeout=20)
    assert (recorder.returncode, said) == (2, "")
    assert errors.count("\n") == 1
    return errors


def test_nobody_publishes(tmp_path: Path) -> None:
    path = tmp_path / "nothing.s7k"
    with chain() as live:
        assert f"nothing to record was received from {live.run_dir}" in ended(
            live.record("--s7k", str(path), "--seconds", "0.5")
        )
    assert not path.exists()


def test_the_tracker_is_away(tmp_path: Path) -> None:
    path = tmp_path / "no_tracker.s7k"
    with chain("sonar") as live:
        recorder = live.record("--s7k", str(path))
        live.publish_until_recorded(path, simulated_pings(1, linear16=False)[0])
        recorder.send_signal(signal.SIGTERM)
        said, _ = recorder.communicate(timeout=20)
    assert recorder.returncode == 0
    assert "0 contacts, 0 poses" in said
    assert len(open_pings(path).pings) == 1


def test_a_full_disk_is_one_line_and_the_whole_records_stay(tmp_path: Path) -> None:
    path = tmp_path / "full.s7k"
    limit = 300_000  # two pings of 7042 and a half
    prelude = f"import resource; resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit}))"
    pings = simulated_pings(4, linear16=False)
    with chain("sonar") as live:
        recorder = live.record("--s7k", str(path), prelude=prelude)
        live.publish_until_recorded(path, pings[0])
        for ping in pings[1:]:
            live.publish(ping)
        assert f"{path}: File too large; kept: 2 pings, 0 contacts" in ended(recorder)
    sequence = open_pings(path)
    assert [ping.data for ping in sequence.pings] == [ping.data for ping in pings[:2]]
    assert sequence.losses == {"other_records": 2}
    assert s7k_tables.entries_of(path)["type"].tolist() == [7200, *[7000, 7004, 7042] * 2]


def test_an_existing_file_is_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "mission.s7k"
    path.write_text("precious")
    with chain() as live:
        assert f"{path}: already exists, and is not overwritten" in ended(live.record("--s7k", str(path)))
    assert path.read_text() == "precious"


def test_a_folder_that_is_not_there(tmp_path: Path) -> None:
    with chain() as live:
        assert "No such file or directory" in ended(live.record("--s7k", str(tmp_path / "no" / "x.s7k")))


@pytest.mark.parametrize("seconds", ["0", "-1", "nan", "soon"])
def test_a_bad_length_of_time(seconds: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["record", "--s7k", "x.s7k", "--seconds", seconds])
    assert "is not a number of seconds above 0" in capsys.readouterr().err
