"""An INS with other objects than config/ins.eds: configuration only. EDS files are written here by hand."""

import math
import struct
from pathlib import Path
from typing import Any

import pytest

from ods.base.errors import OdsError
from ods.base.geodesy import LocalFrame
from ods.messages import Pose
from ods.nav_bridge.settings import POSE_OBJECTS, ObjectSettings
from tests.nav_bridge.canopen_samples import MS, PERIOD, Bench, lost

I16, I32, U8, U16, U32, U64, F32 = 3, 4, 5, 6, 7, 0x1B, 8
BITS = {I16: 16, I32: 32, U8: 8, U16: 16, U32: 32, U64: 64, F32: 32}


def variable(section: str, data_type: int, default: str = "", more: str = "") -> str:
    value = f"DefaultValue={default}\n" if default else ""
    return f"[{section}]\nParameterName=x\nObjectType=7\nDataType=0x{data_type:04X}\nAccessType=ro\n{value}{more}\n"


def record(index: int, values: list[tuple[int, str, str]]) -> str:
    text = f"[{index:04X}]\nParameterName=x\nObjectType=9\nSubNumber={len(values) + 1}\n\n"
    text += variable(f"{index:04X}sub0", U8, str(len(values)))
    return text + "".join(variable(f"{index:04X}sub{sub:X}", *value) for sub, value in enumerate(values, 1))


def eds(path: Path, objects: dict[int, list[tuple[int, str]]], tpdos: list[list[tuple[int, int]]]) -> Path:
    """Write an EDS of records `objects` (type and extra lines of each sub-index) mapped as `tpdos` say."""
    text = "".join(record(index, [(kind, "", more) for kind, more in subs]) for index, subs in objects.items())
    for number, mapped in enumerate(tpdos):
        text += record(0x1800 + number, [(U32, f"$NODEID+0x{0x180 + 0x100 * number:X}", "")])
        entries = [(index << 16 | sub << 8 | BITS[objects[index][sub - 1][0]]) for index, sub in mapped]
        text += record(0x1A00 + number, [(U32, hex(entry), "") for entry in entries])
    path.write_text(text)
    return path


GEODETIC: dict[str, Any] = {
    "0x3000:1": ObjectSettings(field="latitude", factor=1e-7),
    "0x3000:2": "longitude",
    "0x3000:3": ObjectSettings(field="altitude", factor=0.01),
    "0x3100:1": "qw",
    "0x3100:2": "qx",
    "0x3100:3": "qy",
    "0x3100:4": "qz",
    "0x3200:1": ObjectSettings(field="velocity_north", factor=0.01),
    "0x3200:2": ObjectSettings(field="velocity_east", factor=0.01),
    "0x3200:3": ObjectSettings(field="velocity_down", factor=0.01),
}


def geodetic(path: Path) -> Path:
    """Write the EDS of an INS with neither status, time nor sequence number, in four PDOs."""
    objects = {
        0x3000: [(I32, "Factor=7.0\n"), (I32, "Factor=1e-7\n"), (I16, "")],
        0x3100: [(I16, "Factor=3.0518509475997192e-05\n")] * 4,
        0x3200: [(I16, "")] * 3,
    }
    return eds(
        path / "geo.eds",
        objects,
        [
            [(0x3000, 1), (0x3000, 2)],
            [(0x3000, 3)],
            [(0x3100, sub) for sub in (1, 2, 3, 4)],
            [(0x3200, 1), (0x3200, 2), (0x3200, 3)],
        ],
    )


def geodetic_pdos(north_m: float, speed: int = 150) -> list[bytes]:
    latitude, longitude, height = LocalFrame(57.0, 9.9).geodetic([north_m, -20.0, 0.0])
    half = math.radians(90.0) / 2.0
    return [
        struct.pack("<ii", round(1e7 * float(latitude)), round(1e7 * float(longitude))),
        struct.pack("<h", round(100.0 * float(height)) - 1250),
        struct.pack("<hhhh", round(32767 * math.cos(half)), 0, 0, round(32767 * math.sin(half))),
        struct.pack("<hhh", 0, speed, 0),
    ]


def feed(bench: Bench, number: int, data: list[bytes], only: tuple[int, ...] = (0, 1, 2, 3)) -> list[Pose]:
    ids = (0x185, 0x285, 0x385, 0x485)
    found = [bench.take(ids[place], data[place], number * PERIOD + place * 250_000) for place in only]
    return [pose for pose in found if pose is not None]


def test_another_ins_is_configuration_only(tmp_path: Path) -> None:
    bench = Bench(geodetic(tmp_path), objects=GEODETIC, heartbeat_timeout_s=0.0)
    (pose,) = feed(bench, 1, geodetic_pdos(30.0))
    assert pose.position_ned == pytest.approx((30.0, -20.0, 12.5), abs=0.02)
    assert pose.attitude == pytest.approx((math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)), abs=1e-4)
    assert pose.velocity_body == pytest.approx((1.5, 0.0, 0.0), abs=1e-3)  # heading east
    assert pose.sigma_position_ned == (0.5, 0.5, 0.5)
    assert pose.t_ns == PERIOD
    assert lost(bench.counters) == {"epoch_untimed": 1}


@pytest.mark.parametrize("missing", [0, 1, 2, 3])
def test_without_sequence_numbers_order_and_window_keep_epochs_apart(tmp_path: Path, missing: int) -> None:
    bench = Bench(geodetic(tmp_path), objects=GEODETIC)
    for number in range(1, 20):
        only = tuple(place for place in range(4) if place != missing or number % 3)
        assert len(feed(bench, number, geodetic_pdos(number), only)) == (1 if number % 3 else 0)
    # the end of one instant and the beginning of another are lost: what is left is in order, but too far apart
    assert feed(bench, 30, geodetic_pdos(30.0), (0, 1)) == []
    assert feed(bench, 31, geodetic_pdos(31.0), (2, 3)) == []


def test_one_pdo_with_everything_needs_nothing_else(tmp_path: Path) -> None:
    names = ["north", "east", "down", "roll", "pitch", "yaw", "u", "v", "w"]
    table: dict[str, Any] = {f"0x2100:{sub}": name for sub, name in enumerate(names, 1)}
    file = eds(tmp_path / "one.eds", {0x2100: [(U8, "")] * 9}, [[(0x2100, sub) for sub in range(1, 10)]])
    with pytest.raises(OdsError, match="TPDO 1 maps 9 bytes"):
        Bench(file, objects=table)
    file = eds(
        tmp_path / "two.eds",
        {0x2100: [(I16, "")] * 3 + [(U8, "")] * 6, 0x2200: [(U16, "")]},
        [[(0x2100, 1), (0x2100, 2), (0x2100, 3), (0x2200, 1)], [(0x2100, sub) for sub in range(4, 10)] + [(0x2200, 1)]],
    )
    bench = Bench(file, objects=table | {"0x2200:1": "sequence"}, status_bits={})
    found = []
    for number in (65_534, 65_535, 65_536):  # the number is as wide as its object
        sequence = number % 65_536
        bench.take(0x185, struct.pack("<hhhH", 1, 2, 3, sequence), number * PERIOD)
        found.append(bench.take(0x285, struct.pack("<6BH", 0, 0, 0, 4, 5, 6, sequence), number * PERIOD + MS))
    assert [pose.velocity_body for pose in found if pose] == [(4.0, 5.0, 6.0)] * 3
    assert lost(bench.counters) == {"epoch_untimed": 3}


def test_what_status_bits_mean_is_configuration() -> None:
    bench = Bench(status_bits={"position": 7, "time_of_day": 3})
    assert bench.epoch(1) == []
    assert "the INS says that its position is not valid" in bench.source.problems(2 * PERIOD)
    assert len(bench.epoch(2, status=0x80)) == 1
    assert bench.counters["epoch_untimed"] == 1
    assert len(bench.epoch(3, status=0x88)) == 1
    assert bench.counters["epoch_untimed"] == 1


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"0x3000:1": "lattitude"}, "nav.canopen.objects.0x3000:1: not a pose field: 'lattitude' is not one of"),
        ({"3000:1": "north"}, "nav.canopen.objects.3000:1: expected a name like"),
        ({"0x3000:300": "north"}, "nav.canopen.objects.0x3000:300: expected a name like"),
        ({"0x03000:1": "north"}, "nav.canopen.objects.0x03000:1: expected a name like"),
        ({"0x3000:01": "latitude"}, "nav.canopen.objects.0x3000:01: the same object as 0x3000:1"),
        ({"0x3000:4": "latitude"}, "nav.canopen.objects.0x3000:4: 0x3000:1 is latitude already"),
        ({"0x3001": "status"}, "geo.eds: no transmit PDO carries 0x3001 (status)"),
        (
            {"0x3200:1": ObjectSettings(field="status", factor=2.0)},
            "nav.canopen.objects.0x3200:1: status has no factor",
        ),
        ({"0x3200:1": "status"}, "geo.eds: object 0x3200:1 (status) is not an unsigned number"),
        ({"0x3200:1": "sigma_down"}, "a pose needs u, v, w or velocity_north, velocity_east, velocity_down"),
    ],
)
def test_a_mistake_in_the_table_is_one_line_with_its_key(tmp_path: Path, changes: dict[str, Any], said: str) -> None:
    with pytest.raises(OdsError) as error:
        Bench(geodetic(tmp_path), objects=GEODETIC | changes)
    assert str(error.value).startswith(f"{tmp_path / 'geo.eds'}: ")
    assert said in str(error.value)
    assert "\n" not in str(error.value)


ONE_NUMBER = {
    "0x3000:1": "sequence", "0x3000:2": "north", "0x3000:3": "east", "0x3000:4": "down",
    "0x3100:1": "roll", "0x3100:2": "pitch", "0x3100:3": "yaw",
    "0x3200:1": "u", "0x3200:2": "v", "0x3200:3": "w",
}  # fmt: skip


def one_number(path: Path) -> Path:
    """Write the EDS of an INS whose first of three PDOs alone carries the sequence number."""
    objects = {
        0x3000: [(U8, ""), (I16, ""), (I16, ""), (I16, "")],
        0x3100: [(I16, "Factor=1e-4\n")] * 3,
        0x3200: [(I16, "")] * 3,
    }
    mapped = [[(index, sub + 1) for sub in range(len(subs))] for index, subs in objects.items()]
    return eds(path / "one.eds", objects, mapped)


def test_behind_the_last_number_a_pdo_must_come_within_the_window(tmp_path: Path) -> None:
    bench = Bench(one_number(tmp_path), objects=ONE_NUMBER)

    def send(number: int, only: tuple[int, ...]) -> list[Pose]:
        data = [struct.pack("<Bhhh", number, number, 0, 0), struct.pack("<hhh", 0, 0, 100 * number), bytes(6), b""]
        return feed(bench, number, data, only)

    assert len(send(1, (0, 1, 2))) == 1
    assert send(2, (0,)) == []
    assert send(3, (1, 2)) == []  # three frames in a row were lost: in order, but of the next instant
    assert len(send(4, (0, 1, 2))) == 1


@pytest.mark.parametrize(
    ("cob_id", "mapped"),
    [
        ("$NODEID+0x480", [0x60000101, 0x60000201]),
        ("", [0x60000108]),
        ("$NODEID+0x480", None),
        ("$NODEID+0x180", [0x60000108]),
    ],
    ids=["single bits", "no COB-ID", "no mapping", "a COB-ID of the set"],
)
def test_pdos_that_carry_no_pose_may_be_anything(tmp_path: Path, cob_id: str, mapped: list[int] | None) -> None:
    file = geodetic(tmp_path)
    text = record(0x1808, [(U32, cob_id, "")])
    if mapped is not None:
        text += record(0x1A08, [(U32, hex(entry), "") for entry in mapped])
    file.write_text(file.read_text() + text)
    assert len(feed(Bench(file, objects=GEODETIC), 1, geodetic_pdos(30.0))) == 1


def test_status_bits_of_a_status_that_is_not_there_are_refused() -> None:
    without = {name: entry for name, entry in POSE_OBJECTS.items() if entry not in ("status", "over_bottom")}
    with pytest.raises(ValueError, match=r'status_bits: no object of nav\.canopen\.objects is the "status"'):
        Bench(status_bits={"position": 0}, objects=without)
    nothing: dict[str, int] | None
    for nothing in ({}, None):
        assert Bench(status_bits=nothing, objects=without).epoch(1, status=0)


def test_a_bit_beyond_the_status_is_refused() -> None:
    """It would never be set, and no pose ever valid."""
    with pytest.raises(
        OdsError, match=r"ins\.eds: nav\.canopen\.status_bits\.attitude: no bit 8: the status has 8 bits"
    ):
        Bench(status_bits={"position": 7, "attitude": 8})
