"""What is written when: contacts by what changed, poses thinned, losses counted; writing and mending files."""

import math
from collections import Counter
from pathlib import Path

import msgspec
import pytest

from ods.base.clock import NS
from ods.base.frames.geometry import quat_from_euler
from ods.base.geodesy import LocalFrame
from ods.cli import main
from ods.messages import ObstacleList, Ping, Pose
from ods.recording import record_s7k
from ods.recording.s7k import RECORDED_DEVICES, Recorder
from ods.sonar_link.files.s7k.catalogue import encode_file_header, text_field, with_catalogue
from ods.sonar_link.files.s7k.writer import S7kWriter, repair_s7k, write_s7k
from tests.recording.record_samples import LATITUDE_DEG, LONGITUDE_DEG, START_NS, obstacles_at, pose_at, rock
from tests.sonar_link import s7k_tables
from tests.sonar_link.sonar_samples import UTC_NS, make_ping

T = START_NS


def recorded(path: Path, *messages: Ping | ObstacleList | Pose) -> tuple[list[s7k_tables.Raw], Recorder]:
    """Record messages; return the records between header and catalogue."""
    with path.open("xb", buffering=0) as file:
        writer = S7kWriter(file, path.name, T, RECORDED_DEVICES)
        recorder = Recorder(writer, LocalFrame(LATITUDE_DEG, LONGITUDE_DEG))
        for message in messages:
            recorder.take(message)
        writer.close()
    return s7k_tables.read(path)[1:-1], recorder


def contacts(records: list[s7k_tables.Raw]) -> list[tuple[int, int, bytes]]:
    return [
        (record.head["target"], record.head["state"], record.head["classification"].rstrip(b"\0"))
        for record in records
        if record.type == 3001
    ]


def test_a_contact_is_written_when_something_is_new(tmp_path: Path) -> None:
    records, recorder = recorded(
        tmp_path / "x.s7k",
        pose_at(T),
        obstacles_at(T, 1, rock(T)),
        obstacles_at(T, 2, rock(T)),  # only the list is new
        obstacles_at(T, 3, rock(T, "stand_by")),
        obstacles_at(T, 4),  # not reported for a while
        obstacles_at(T, 5, rock(T + 1, "active"), rock(T, number=8)),
        obstacles_at(T, 6, rock(T + 1, "terminated"), rock(T, "terminated", number=9)),
        obstacles_at(T, 7, rock(T + 1, "terminated")),  # ends are announced more than once
    )
    expected = [(7, 0, b"active"), (7, 1, b"stand_by"), (7, 1, b"active"), (8, 0, b"active"), (7, 2, b"terminated")]
    assert contacts(records) == expected
    assert recorder.counters["contacts"] == len(expected)


def test_a_tracker_that_started_anew_begins_its_contacts_anew(tmp_path: Path) -> None:
    lists = [obstacles_at(T, seq, rock(T)) for seq in (41, 0)]
    records, _ = recorded(tmp_path / "x.s7k", pose_at(T), *lists)
    assert contacts(records) == [(7, 0, b"active")] * 2


def test_a_contact_waits_for_a_pose(tmp_path: Path) -> None:
    seconds_later = obstacles_at(T + 2_000_000_000, 2, rock(T))
    records, recorder = recorded(
        tmp_path / "x.s7k", obstacles_at(T, 1, rock(T)), pose_at(T), seconds_later, obstacles_at(T, 3, rock(T))
    )
    assert contacts(records) == [(7, 0, b"active")]
    assert recorder.counters["contacts_without_pose"] == 2


def test_what_does_not_fit_is_counted_and_the_rest_written(tmp_path: Path) -> None:
    bad_pose = msgspec.structs.replace(pose_at(T), position_ned=(math.nan, 0.0, 0.0))
    bad_obstacle = msgspec.structs.replace(rock(T, number=8), radius_m=1e300)
    records, recorder = recorded(
        tmp_path / "x.s7k",
        make_ping(0, scale="db", scale_factor=0.3),
        msgspec.structs.replace(make_ping(1), dr_m=0.0),
        msgspec.structs.replace(make_ping(2), sound_speed=1e300),
        msgspec.structs.replace(make_ping(3), t_ns=10**20, utc_ns=10**20),
        msgspec.structs.replace(make_ping(4), data=b"short"),
        msgspec.structs.replace(make_ping(5), bearing_rad=[0.0]),
        bad_pose,
        pose_at(T + 60_000_000),
        obstacles_at(T, 1, bad_obstacle, rock(T)),
        make_ping(9),
    )
    assert [record.type for record in records] == [1003, 1012, 1013, 3001, 7000, 7004, 7042]
    assert recorder.counters == {
        "unfit_pings": 6, "unfit_poses": 1, "unfit_contacts": 1, "poses": 1, "contacts": 1, "pings": 1, "lost_pings": 3,
    }  # fmt: skip


@pytest.mark.parametrize("step_s", [-3600, 3600])
def test_a_step_of_utc_moves_no_time_in_the_file(tmp_path: Path, step_s: int) -> None:
    """Ping, pose and list each 0.1 s; UTC steps after the fifth of them, an object is seen before and after."""
    messages: list[Ping | Pose | ObstacleList] = []
    for k in range(10):
        t_ns, step_ns = T + k * 100_000_000, (step_s * NS if k >= 5 else 0)
        picture = obstacles_at(t_ns, k, rock(t_ns + step_ns))
        ping = msgspec.structs.replace(make_ping(k), t_ns=t_ns)
        messages += [msgspec.structs.replace(m, utc_ns=t_ns + step_ns) for m in (pose_at(t_ns, k), ping, picture)]
    records, recorder = recorded(tmp_path / "x.s7k", *messages)
    times = [s7k_tables.instant(record.frame["time"]) for record in records]
    assert times == sorted(times)
    assert (times[-1] - times[0]).total_seconds() == pytest.approx(0.9, abs=1e-5)
    seen = [s7k_tables.instant(record.head["time"]) for record in records if record.type == 3001]
    assert [(s - seen[0]).total_seconds() for s in seen] == pytest.approx([0.1 * k for k in range(10)], abs=1e-5)
    assert recorder.counters["utc_steps"] == 1


def test_gaps_in_each_sequence_are_counted_whoever_dropped_what(tmp_path: Path) -> None:
    poses = [pose_at(T + n * 10_000_000, n) for n in (5, 6, 9, 300, 0, 2)]
    lists = [obstacles_at(T, seq) for seq in (3, 5)]
    _, recorder = recorded(tmp_path / "x.s7k", make_ping(0), *poses, *lists, make_ping(3))
    lost = {name: count for name, count in recorder.counters.items() if name.startswith("lost_")}
    assert lost == {"lost_poses": 2 + 290 + 1, "lost_lists": 1, "lost_pings": 2}


def test_what_the_bus_dropped_is_not_counted_beside_the_gaps_that_it_left() -> None:
    counters = Counter({"dropped_ping": 3, "dropped_obstacles": 1, "bad_pose": 2})
    assert record_s7k._unreadable(counters) == {"bad_pose": 2}
    assert not counters


def test_a_heading_to_port_of_north_is_written_from_0_to_2_pi(tmp_path: Path) -> None:
    w, x, y, z = quat_from_euler(0.0, 0.0, -0.5).tolist()
    records, _ = recorded(tmp_path / "x.s7k", msgspec.structs.replace(pose_at(T), attitude=(w, x, y, z)))
    (heading,) = (record.head["heading"] for record in records if record.type == 1013)
    assert heading == pytest.approx(math.tau - 0.5, abs=2e-5)


def test_a_heading_is_written_from_true_north_where_the_vehicle_is(tmp_path: Path) -> None:
    """10 km to the east at 57 deg: to first order the difference in longitude times the sine of the latitude."""
    pose = msgspec.structs.replace(pose_at(T), position_ned=(0.0, 10_000.0, 5.0), attitude=(1.0, 0.0, 0.0, 0.0))
    records, _ = recorded(tmp_path / "x.s7k", pose)
    (heading,) = (record.head["heading"] for record in records if record.type == 1013)
    away = 10_000.0 / (6_393_000.0 * math.cos(math.radians(LATITUDE_DEG)))
    assert heading == pytest.approx(away * math.sin(math.radians(LATITUDE_DEG)), rel=2e-3)


def test_a_sonar_process_that_started_anew_lost_nothing(tmp_path: Path) -> None:
    _, recorder = recorded(tmp_path / "x.s7k", make_ping(700), make_ping(0), make_ping(1))
    assert recorder.counters["lost_pings"] == 0


def test_the_vehicle_s_clock_may_go_back(tmp_path: Path) -> None:
    records, _ = recorded(tmp_path / "x.s7k", pose_at(T), pose_at(T + 1), pose_at(T - 10**10), pose_at(T - 10**10 + 1))
    assert [record.type for record in records] == [1003, 1012, 1013] * 2


def test_simulated_files_have_a_catalogue_too(tmp_path: Path) -> None:
    write_s7k(tmp_path / "x.s7k", [make_ping(0), make_ping(1)])
    records = s7k_tables.read(tmp_path / "x.s7k")
    assert [record.type for record in records] == [7200, *[7000, 7004, 7042] * 2, 7300]
    assert records[-1].head["records"] == 7


def test_text_is_cut_off_between_characters() -> None:
    assert text_field("fjæ", 5) == b"fj\xc3\xa6\0"
    assert text_field("fjæ", 4) == b"fj\0\0"


def test_damage_in_the_middle_costs_what_is_damaged(tmp_path: Path) -> None:
    path = tmp_path / "x.s7k"
    write_s7k(path, [make_ping(n) for n in range(3)])
    whole = s7k_tables.read(path)
    data = bytearray(path.read_bytes()[: whole[-1].at])
    data[whole[4].at + 100] ^= 1
    path.write_bytes(data + b"\xff\xff\x00\x00" * 30)
    assert repair_s7k(path) == len(whole) - 2
    entries = s7k_tables.entries_of(path)
    assert entries["offset"].tolist() == [record.at for record in whole[:-1] if record is not whole[4]]


def test_a_kill_between_catalogue_and_header_is_mended(tmp_path: Path) -> None:
    path = tmp_path / "x.s7k"
    write_s7k(path, [make_ping(0)])
    whole = path.read_bytes()
    header = with_catalogue(whole[: s7k_tables.read(path)[0].frame["size"]], 0, 0)
    path.write_bytes(header + whole[len(header) :])
    assert repair_s7k(path) == 4
    assert path.read_bytes() == whole


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"", "empty"),
        (b"nothing like it", "does not begin with a complete record"),
        (bytes(500), "does not begin with a complete record"),
        (encode_file_header(UTC_NS, "x")[1:], "does not begin with a complete record"),
    ],
)
def test_files_that_cannot_be_mended_are_left_alone(
    tmp_path: Path, content: bytes, reason: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "x.s7k"
    path.write_bytes(content)
    assert main(["record", "--finish", str(path)]) == 2
    assert f"ods record: {path}: {reason}" in capsys.readouterr().err
    assert path.read_bytes() == content


def test_another_program_s_header_without_room_for_a_catalogue(tmp_path: Path) -> None:
    from ods.sonar_link.s7k.drf import DeviceId, encode_record

    path = tmp_path / "x.s7k"
    path.write_bytes(encode_record(7200, bytes(324), UTC_NS, DeviceId(7000)) + b"torn")
    with pytest.raises(ValueError, match="no room for a catalogue"):
        repair_s7k(path)
    assert path.read_bytes().endswith(b"torn")


def test_a_recording_under_way_is_not_mended(tmp_path: Path) -> None:
    path = tmp_path / "x.s7k"
    with path.open("xb", buffering=0) as file:
        S7kWriter(file, path.name, T)
        with pytest.raises(ValueError, match="is being written"):
            repair_s7k(path)
