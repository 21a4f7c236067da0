"""NMEA 0183 and PD6 to poses: sentences as their makers publish them, and an INS made by hand, whose truth is known."""

import itertools
import math
import random
import re
from collections import Counter
from functools import reduce
from operator import xor

import msgspec
import pytest
from hypothesis import given, settings as examples, strategies as st
from scipy.spatial.transform import Rotation

from ods.base.geodesy import LocalFrame
from ods.messages import Pose
from ods.nav_bridge.clocks.utc import Utc, WallClock
from ods.nav_bridge.nmea.line import LONGEST, Line, LineSplitter
from ods.nav_bridge.nmea.sentence import BadSentenceError, NotValidError, name_of, parse, read, utc_of
from ods.nav_bridge.nmea.source import NmeaSource
from ods.nav_bridge.settings import TALKER, HeldSettings, NavSettings, NmeaSettings
from ods.nav_bridge.source import SourceHost
from tests.nav_bridge.made_up_clock import utc_ahead

MS, NS = 1_000_000, 1_000_000_000
SITE = LocalFrame(57.0, 9.9)
NOON_MS = 12 * 3600 * 1000
USUAL = NmeaSettings(port="/dev/null", depth="TS", velocity="BS", accuracy="GST")


def summed(text: str) -> bytes:
    """Return a sentence with its checksum, from its text behind the dollar."""
    return f"${text}*{reduce(xor, text.encode(), 0):02X}".encode()


def of(line: bytes) -> dict[str, float]:
    return read(parse(line)).values


# sentences


def test_sentences_as_their_makers_publish_them() -> None:
    """pynmea2's and NovAtel's examples, with the checksums printed there; PD6 by Teledyne RDI's table."""
    gga = read(parse(b"$GPGGA,184353.07,1929.045,S,02410.506,E,1,04,2.6,100.00,M,-33.9,M,,0000*6D"))
    assert gga.values == pytest.approx({"latitude": -19.4840833333, "longitude": 24.1751, "altitude": 100.0})
    assert gga.day_ms == pytest.approx(1000 * (18 * 3600 + 43 * 60 + 53.07))
    pashr = of(b"$PASHR,163029.000,158.09,T,-0.30,+0.31,+0.01,0.029,0.029,0.059,1,1*3B")
    degrees = {name: math.degrees(value) for name, value in pashr.items()}
    assert degrees == pytest.approx(
        {"yaw": 158.09, "roll": -0.3, "pitch": 0.31, "sigma_roll": 0.029, "sigma_pitch": 0.029, "sigma_yaw": 0.059}
    )
    assert of(b":BS,  -123,  +1500,    +45,A") == {"u": 1.5, "v": -0.123, "w": -0.045}
    assert of(b":BE,+1000,-2000,+3000,A") == {"velocity_north": -2.0, "velocity_east": 1.0, "velocity_down": -3.0}
    assert of(b":TS,09051514304045,35.0,+21.0,  12.3,1520.0,000") == {"altitude": -12.3}
    reported = {name: math.degrees(value) for name, value in of(b":SA,+1.00, -2.00,090.0").items()}
    assert reported == pytest.approx({"pitch": 1.0, "roll": -2.0, "yaw": 90.0})


def test_the_other_sentences() -> None:
    north_east = {"velocity_north": 5.0 * math.cos(0.5), "velocity_east": 5.0 * math.sin(0.5), "velocity_down": 0.0}
    course, knots = math.degrees(0.5), 5.0 * 3600 / 1852
    assert of(summed(f"GPVTG,{course:.9f},T,,M,{knots:.9f},N,18.0,K,A")) == pytest.approx(north_east)
    place = {"latitude": 57.05, "longitude": -0.5}
    rmc = f"GPRMC,120000.00,A,5703.000,N,00030.000,W,{knots:.9f},{course:.9f},220926,,,A"
    assert of(summed(rmc)) == pytest.approx(north_east | place)
    assert of(summed("HEHDT,270.0,T")) == pytest.approx({"yaw": math.radians(270.0)})
    assert of(summed("GPGST,120000.00,1.0,,,,0.3,0.4,0.5")) == {
        "sigma_north": 0.3, "sigma_east": 0.4, "sigma_down": 0.5
    }  # fmt: skip
    assert of(summed("SDDPT,10.5,0.5")) == {"altitude": -11.0, "over_bottom": 10.5}
    assert of(summed("SDDPT,10.5,-0.5")) == {"altitude": -10.5, "over_bottom": 10.5}
    for name in ("DBT", "DBS"):
        assert of(summed(f"SD{name},32.8,f,10.0,M,5.4,F")) == {"altitude": -10.0, "over_bottom": 10.0}
    assert utc_of(parse(summed("GPZDA,120000.50,22,09,2026,00,00"))) == 1_790_078_400_500_000_000  # date -u +%s


@pytest.mark.parametrize(
    "line",
    [
        summed("GPGGA,120000,5700.0,N,00954.0,E,0,04,1.0,0.0,M,,M,,"), summed("GPGGA,120000,,,,,1,04,1.0,0.0,M,,M,,"),
        summed("GPRMC,120000,V,5700.0,N,00954.0,E,1.0,0.0,220926,,,A"), summed("GPVTG,,T,,M,,N,,K,N"),
        b":BS,-32768,-32768,-32768,V", b":BE,0,0,0,V", summed("PASHR,120000.000,,,,,,,,,0,0"), summed("HEHDT,,T"),
    ],
)  # fmt: skip
def test_what_says_that_it_is_not_valid_is_not_used(line: bytes) -> None:
    with pytest.raises(NotValidError):
        read(parse(line))


@pytest.mark.parametrize(
    "line",
    [
        b"$GPGGA,184353.07,1929.045,S,02410.506,E,1,04,2.6,100.00,M,-33.9,M,,0000*6E", b"$HEHDT,270.0,T", b"$*00",
        summed("HEHDT,1_0.0,T"), summed("HEHDT,nan,T"), summed("HEHDT,1e5,T"), summed("HEHDT,inf,T"), b"$PASHR*00",
        summed("GPGGA,120000,5700.0,N,9.0,E,1,04,1.0,0.0,M,,M,,"), b":BS,1,2,A", b":BS,1,2,3,4,A", b":BS", b"",
        summed("GPGGA,120000,5760.0,N,00954.0,E,1,04,1.0,0.0,M,,M,,"), summed("GPGGA,120000"), b"\xff\xfe", b":SA,1,2",
        summed("GPGGA,120000,5700.0,X,00954.0,E,1,04,1.0,0.0,M,,M,,"), summed("GPGGA,120000,57-0.0,N,00954.0,E,1,,,0"),
        summed("GPGGA,120000,5700.0,N,00954.0,E,1,04,1.0,32.8,F,,M,,"), summed("GPVTG,90.0,M,,T,1.0,N,,K"),
        summed("HEHDT,270.0,M"), summed("PASHR,120000.000,270.0,M,0.0,0.0,0.0,0.1,0.1,0.1,1,1"),
    ],
)  # fmt: skip
def test_a_damaged_line_is_no_sentence(line: bytes) -> None:
    with pytest.raises(BadSentenceError):
        of(line)


@pytest.mark.parametrize(
    "head",
    [
        rb"\s:IN0001,c:1795744800*5A" + b"\\", rb"\g:1-2-1234,s:r3669961*00" + b"\\" + rb"\n:5*4F" + b"\\",
        b"UdPbC\0" + rb"\s:IN0001,d:OD0001,n:5*7E" + b"\\", b"UdPbC\0", b"\\\\",
    ],
)  # fmt: skip
def test_tag_blocks_and_heads_of_datagrams_are_passed_over(head: bytes) -> None:
    source, counters = source_of(USUAL)
    assert source.name_of(Line(head + Ins().gga(0), 0)) == "GGA"
    source.take(Line(head + Ins().gga(0), 0))
    assert counters == {"nmea_sentences": 1}


def test_a_tag_block_without_an_end_is_damaged() -> None:
    source, counters = source_of(USUAL)
    source.take(Line(b"\\s:IN0001" + Ins().gga(0), 0))
    assert counters == {"nmea_damaged": 1}


@pytest.mark.parametrize(
    ("latitude", "longitude", "place"),
    [
        ("0612.630", "00154.5", (6.2105, 1.0 + 54.5 / 60)), ("612.630", "154.5", (6.2105, 1.0 + 54.5 / 60)),
        ("12.630", "54.5", (0.2105, 54.5 / 60)), ("4400.6", "8832.5554", (44.01, 88.0 + 32.5554 / 60)),
        ("4521", "1026", (45.35, 10.0 + 26.0 / 60)), ("04521.", "17959.99", (45.35, 179.0 + 59.99 / 60)),
    ],
)  # fmt: skip
def test_degrees_with_and_without_leading_zeros(latitude: str, longitude: str, place: tuple[float, float]) -> None:
    values = of(summed(f"GPGGA,120000,{latitude},N,{longitude},E,1,04,1.0,0.0,M,,M,,"))
    assert (values["latitude"], values["longitude"]) == pytest.approx(place)


@pytest.mark.parametrize("time", ["250000", "184724930", "1234.5", "240000.00", "12:00:00", ""])
def test_a_time_that_cannot_be_costs_the_time_only(time: str) -> None:
    read_ = read(parse(summed(f"PASHR,{time},270.0,T,1.0,-2.0,0.0,0.1,0.1,0.1,1,1")))
    assert read_.day_ms is None
    assert read_.values["roll"] == pytest.approx(math.radians(1.0))
    assert read(parse(summed(f"GPGGA,{time},5700.0,N,00954.0,E,1,04,1.0,0.0,M,,M,,"))).values["latitude"] == 57.0


def test_who_hardly_moves_has_no_course_and_stands_still() -> None:
    assert of(summed("GPVTG,,T,,M,0.20,N,0.37,K,A"))["velocity_north"] == 0.0
    still = of(summed("GPRMC,120000.00,A,5703.000,N,00030.000,W,0.12,,220926,,,A"))
    assert (still["velocity_north"], still["velocity_east"]) == (0.0, 0.0)
    with pytest.raises(NotValidError, match=r"no course at 1\.5 m/s"):
        of(summed("GPVTG,,T,,M,2.92,N,5.4,K,A"))
    moving = of(summed("GPRMC,120000.00,A,5703.000,N,00030.000,W,2.92,,220926,,,A"))
    assert moving == pytest.approx({"latitude": 57.05, "longitude": -0.5})


def test_rmc_without_a_course_under_way_gives_no_pose_and_says_why() -> None:
    source, _ = source_of(msgspec.structs.replace(USUAL, place="RMC", velocity="RMC", depth="GGA", accuracy=None))
    ins = Ins()
    rmc = summed("GPRMC,120000.00,A,5703.000,N,00030.000,W,2.92,,220926,,,A")
    for line in (rmc, ins.gga(0), ins.pashr(0)):
        assert source.take(Line(line, 0)) is None
    assert "RMC: has been flagged as not valid since it first came (no velocity)" in source.problems(NS)


def quality_of(quality: int) -> bytes:
    return Ins().gga(0, quality=quality)


@pytest.mark.parametrize("quality", [6, 7, 8])
def test_places_that_are_no_fix_are_used_as_the_settings_say(quality: int, caplog: pytest.LogCaptureFixture) -> None:
    kind = {6: "estimated", 7: "manual", 8: "simulated"}[quality]
    settings = msgspec.structs.replace(USUAL, depth="GGA", velocity="BS", accuracy=None)
    ins = Ins()

    def pose_of(accept: dict[str, float]) -> tuple[Pose | None, Counter[str], list[str]]:
        source, counters = source_of(msgspec.structs.replace(settings, accept=accept))
        pose = [source.take(Line(line, 0)) for line in (ins.gga(0, quality=quality), ins.bs(), ins.pashr(0))][-1]
        return pose, counters, source.problems(NS)

    refused, counters, problems = pose_of({})
    assert refused is None
    assert counters["nmea_not_valid"] == 1
    expected = f"GGA: has been flagged as not valid since it first came (it is {kind}, which nav.nmea.accept excludes)"
    assert expected in problems
    plain, _, _ = pose_of({kind: 0.0})
    wider, counters, _ = pose_of({kind: 7.0})
    assert plain is not None
    assert wider is not None
    assert counters["nmea_no_fix"] == 1
    assert f"are {kind}" in caplog.text
    assert wider.sigma_position_ned[0] == pytest.approx(math.hypot(plain.sigma_position_ned[0], 7.0))


def test_a_dead_reckoning_with_an_accuracy_sentence_is_as_exact_as_that_says() -> None:
    source, _ = source_of(msgspec.structs.replace(USUAL, depth="GGA", velocity="BS", accept={"estimated": 10.0}))
    ins = Ins()
    pose = [source.take(Line(line, 0)) for line in (ins.gga(0, quality=6), ins.gst(0), ins.bs(), ins.pashr(0))][-1]
    assert pose is not None
    assert max(pose.sigma_position_ned[:2]) < 1.0


@pytest.mark.parametrize(
    "line",
    [
        "GPRMC,120000.00,A,5703.000,N,00030.000,W,2.0,10.0,220926,,,{},S", "GPVTG,90.0,T,,M,2.0,N,3.7,K,{}",
    ],
)  # fmt: skip
def test_modes_and_status_say_what_is_no_fix(line: str) -> None:
    kinds = {mode: read(parse(summed(line.format(mode)))).kind for mode in "ADEFMPRS"}
    assert kinds == dict.fromkeys("ADFPR", "") | {"E": "estimated", "M": "manual", "S": "simulated"}
    with pytest.raises(NotValidError):
        of(summed(line.format("N")))
    unsafe = "GPRMC,120000.00,A,5703.000,N,00030.000,W,2.0,10.0,220926,,,A,U"
    assert read(parse(summed(unsafe))).kind == "unsafe"


def test_sentences_without_checksum_are_said_as_such() -> None:
    source, counters = source_of(USUAL)
    for line in (Ins().gga(0), Ins().pashr(0)):
        source.take(Line(line.split(b"*")[0], NS))
    assert counters == {"nmea_no_checksum": 2}
    said = "all useful sentences are without checksum, and dropped: configure the sender to append it (*hh)"
    assert source.problems(2 * NS - 1)[-1] == said
    assert not any("baud" in problem or "never come" in problem for problem in source.problems(2 * NS - 1))


def test_a_sentence_that_comes_without_checksum_or_damaged_is_not_said_never_to_come() -> None:
    source, _ = source_of(USUAL)
    ins = Ins()
    for line in (ins.gga(0).split(b"*")[0], ins.ts(0), ins.bs() + b"\xff", ins.pashr(0)):
        assert source.take(Line(line, NS)) is None
    assert source.unusable() == {
        "GGA": "without checksum, and dropped: configure the sender to append it (*hh)",
        "BS": "damaged, and is dropped: its checksum or its fields are wrong",
    }
    assert source.problems(2 * NS - 1)[1:3] == [
        "GGA (place) comes without checksum, and dropped: configure the sender to append it (*hh)",
        "BS (velocity) comes damaged, and is dropped: its checksum or its fields are wrong",
    ]
    for line in (ins.gga(0), ins.bs()):
        source.take(Line(line, NS))
    assert source.unusable() == {}


@pytest.mark.parametrize(("late_ms", "said"), [(40, False), (990, False), (3_000, True)])
def test_a_line_that_is_less_late_than_poses_may_be_old_is_no_reason(late_ms: int, said: bool) -> None:
    source, _ = source_of(USUAL)
    source.take(Line(Ins().pashr(0), NS))
    source._clock.estimator.held_back_ns = late_ms * MS
    problems = source.problems(2 * NS)
    assert any("late by the INS's clock" in problem for problem in problems) == said
    assert "GGA (place) has never come" in problems


def test_wrong_checksums_of_all_sentences_are_one_reason_without_hints_at_the_line() -> None:
    source, _ = source_of(USUAL)
    ins = Ins()
    for line in (ins.gga(0), ins.gst(0), ins.pashr(0)):
        source.take(Line(line[:-2] + b"xx", NS))
    for line in (ins.ts(0), ins.bs()):
        source.take(Line(line + b"\xff", NS))
    assert source.problems(2 * NS - 1)[1:] == [
        "all useful sentences are damaged, and is dropped: its checksum or its fields are wrong"
    ]


def test_an_attitude_that_becomes_damaged_is_said() -> None:
    source, _ = source_of(USUAL)
    ins = Ins()
    for second in range(4):
        t_ns = second * NS
        pashr = ins.pashr(t_ns) if second < 2 else ins.pashr(t_ns)[:-2] + b"xx"
        for line in (ins.gga(t_ns), ins.gst(t_ns), ins.ts(t_ns), ins.bs(), pashr):
            source.take(Line(line, t_ns))
    assert source.problems(3 * NS)[1:] == ["PASHR comes damaged, and is dropped: its checksum or its fields are wrong"]


def test_an_attitude_that_is_not_valid_is_said() -> None:
    source, _ = source_of(USUAL)
    ins = Ins()
    for line in (ins.gga(0), ins.gst(0), ins.ts(0), ins.bs(), summed("PASHR,120000.000,,T,1.0,-2.0,0.0,,,,1,1")):
        assert source.take(Line(line, 0)) is None
    assert "PASHR: flagged as not valid (no heading)" in source.problems(NS - 1)


def test_a_seapaths_attitude_makes_poses() -> None:
    assert of(summed("PSXN,23,1.50,-2.25,270.00,0.10")) == pytest.approx(
        {"roll": math.radians(1.5), "pitch": math.radians(-2.25), "yaw": math.radians(270.0)}
    )
    assert of(summed("PSXN,20,1,0,0,0")) == {}
    source, counters = source_of(msgspec.structs.replace(USUAL, attitude="PSXN", heading="PSXN"))
    ins = Ins()
    lines = ins.gga(0), ins.gst(0), ins.ts(0), ins.bs(), summed("PSXN,20,1,0,0,0"), summed("PSXN,23,1.5,-2.2,27.0,0.1")
    pose = [source.take(Line(line, 0)) for line in lines][-1]
    assert pose is not None
    assert counters["nmea_other"] == 1


@pytest.mark.parametrize(
    ("qualities", "used"), [("0,0,0,0", True), ("2,2,1,1", True), ("0,0,2,0", False), ("0,0,0,2", False)]
)
def test_an_attitude_that_a_seapath_calls_invalid_makes_no_pose_until_it_is_valid_again(
    qualities: str, used: bool
) -> None:
    source, counters = source_of(msgspec.structs.replace(USUAL, attitude="PSXN", heading="PSXN"))
    ins = Ins()
    attitude = summed("PSXN,23,1.5,-2.2,27.0,0.1")
    for line in (ins.gga(0), ins.gst(0), ins.ts(0), ins.bs(), summed(f"PSXN,20,{qualities}")):
        source.take(Line(line, 0))
    assert (source.take(Line(attitude, 0)) is not None) == used
    assert counters["nmea_not_valid"] == (not used)
    source.take(Line(summed("PSXN,20,0,0,0,0"), 0))
    assert source.take(Line(attitude, 0)) is not None


def test_a_makers_sentence_has_a_name_up_to_the_comma_and_no_talker() -> None:
    """The maker's three letters, and what it adds; nobody's talker begins with P."""
    for name in ("PXYZ", "PXYZA", "PXYZATT", "PASHR", "PNORI", "PUBX"):  # pynmea2 has classes for the last three
        assert parse(summed(f"{name},1.0,-2.0")) == ("", name, ["1.0", "-2.0"])
        assert name_of(summed(f"{name}")) == ("", name)
        assert TALKER.sub("", name) == name
    assert parse(summed("HEHDT,270.0,T"))[:2] == ("HE", "HDT")


def test_an_age_that_a_sentence_tells_counts() -> None:
    assert read(parse(b":BD,+1.0,+2.0,+3.0,0012.30,045.00")).age_s == 45.0
    source, _ = source_of(msgspec.structs.replace(USUAL, altitude="BD", held={"BD": HeldSettings(max_age_s=2.0)}))
    ins = Ins()

    def altitude(age_s: float) -> float | None:
        lines = (
            ins.gga(0),
            ins.gst(0),
            ins.ts(0),
            ins.bs(),
            f":BD,+0,+0,+0,0012.30,{age_s:06.2f}".encode(),
            ins.pashr(0),
        )
        pose = [source.take(Line(line, 0)) for line in lines][-1]
        assert pose is not None
        return pose.altitude_m

    assert altitude(0.0) == pytest.approx(12.3, abs=0.1)
    assert altitude(45.0) is None
    corrected = "GPGGA,120000,5700.0,N,00954.0,E,2,04,1.0,0.0,M,0.0,M,{},0120"
    assert [read(parse(summed(corrected.format(age)))).corrections_s for age in ("", "9.5")] == [0.0, 9.5]


@given(st.binary(max_size=90) | st.from_regex(rb"\$..(GGA|RMC|VTG|HDT|GST|DPT|ZDA),[ -~]{0,60}", fullmatch=True))
@examples(max_examples=300, deadline=None)
def test_any_bytes_are_read_or_refused(text: bytes) -> None:
    for line in (text, summed(text[1:].decode("latin-1").replace("*", "")) if text.isascii() else text):
        source, counters = source_of(USUAL)
        source.take(Line(line, NS))
        assert sum(counters.values()) == 1 or counters["time"]


# lines


@given(st.lists(st.binary(min_size=1, max_size=20)), st.integers(1, 9))
def test_lines_come_out_whole_however_they_come_in(parts: list[bytes], step: int) -> None:
    lines = [part.replace(b"\n", b".").replace(b"\r", b".") for part in parts]
    data = b"".join(line + b"\r\n" for line in lines)
    splitter = LineSplitter(Counter())
    found = [line for at in range(0, len(data), step) for line in splitter.feed(data[at : at + step], at)]
    assert [line.data for line in found] == lines
    begun = [sum(len(line) + 2 for line in lines[:n]) for n in range(len(lines))]
    assert all(begin - step < line.t_ns <= begin for line, begin in zip(found, begun, strict=True))


def test_a_line_without_an_end_is_given_up() -> None:
    counters: Counter[str] = Counter()
    splitter = LineSplitter(counters)
    for _ in range(1000):
        assert list(splitter.feed(b"x" * 1000, 0)) == []
        assert splitter.endless
    assert [line.data for line in splitter.feed(b"x\n$A\n" + b"y" * LONGEST + b"\n", 0)] == [b"$A", b"y" * LONGEST]
    assert counters == {"line_overlong": 1}


# poses


def source_of(settings: NmeaSettings, utc: Utc | None = None) -> tuple[NmeaSource, Counter[str]]:
    counters: Counter[str] = Counter()
    host = SourceHost(SITE, lambda *_: None, counters, 0, utc or utc_ahead(0))
    return NmeaSource(NavSettings(source="nmea", nmea=settings), settings, host), counters


YAW, PITCH, ROLL, SPEED = 2.0, -0.15, 0.1, 2.5
TURN = Rotation.from_euler("ZYX", [YAW, PITCH, ROLL])
VELOCITY = TURN.apply([SPEED, 0.0, 0.0])
"""North, east, down; it never changes."""


class Ins:
    """Moves evenly from the site's origin, at depth 20 m; reported by hand."""

    def __init__(self, start_ms: float = NOON_MS) -> None:
        self._start_ms = start_ms

    def time(self, t_ns: int) -> str:
        seconds = (self._start_ms + t_ns / MS) / 1000 % 86400
        minutes, rest = divmod(seconds, 60)
        return f"{int(minutes // 60):02d}{int(minutes % 60):02d}{rest:06.3f}"

    @staticmethod
    def place(t_ns: int) -> list[float]:
        return [*(part * t_ns / NS for part in VELOCITY[:2]), 20.0 + VELOCITY[2] * t_ns / NS]

    def pashr(self, t_ns: int) -> bytes:
        angles = (f"{math.degrees(angle):.6f}" for angle in (YAW, ROLL, PITCH))
        heading, roll, pitch = angles
        return summed(f"PASHR,{self.time(t_ns)},{heading},T,{roll},{pitch},0.0,0.1,0.2,0.3,1,1")

    def gga(self, t_ns: int, talker: str = "IN", quality: int = 1) -> bytes:
        latitude, longitude, height = (float(x) for x in SITE.geodetic(self.place(t_ns)))
        parts = [f"{int(angle):02d}{60 * (angle % 1):012.9f}" for angle in (latitude, longitude)]
        reported = f"{talker}GGA,{self.time(t_ns)},{parts[0]},N,0{parts[1]},E,{quality},9,1.0,{height:.4f},M,0.0,M,,"
        return summed(reported)

    def gst(self, t_ns: int) -> bytes:
        return summed(f"INGST,{self.time(t_ns)},1.0,,,,0.3,0.4,0.5")

    def ts(self, t_ns: int) -> bytes:
        return f":TS,26092212000000,35.0,+10.0,{self.place(t_ns)[2]:.4f},1500.0,000".encode()

    @staticmethod
    def bs(status: str = "A") -> bytes:
        return f":BS,+0,{round(1000 * SPEED):+d},+0,{status}".encode()

    @staticmethod
    def bd() -> bytes:
        return b":BD,+1.0,-2.0,+0.1,12.34,0.2"


def fly(source: NmeaSource, ins: Ins, seconds: float, late_ms: random.Random | None = None) -> list[Pose]:
    """Send attitude at 50 Hz, place and its deviations at 1 Hz and 80 ms old, depth at 10 Hz, Doppler log at 5 Hz."""
    poses = []
    for number in range(round(50 * seconds)):
        t_ns = number * 20 * MS
        sent = [ins.pashr(t_ns)]
        if number % 50 == 0:
            sent += [ins.gga(t_ns - 80 * MS), ins.gst(t_ns - 80 * MS)]
        sent += [ins.ts(t_ns)] if number % 5 == 0 else []
        sent += [ins.bs()] if number % 10 == 0 else []
        arrival_ns = t_ns + (late_ms.randrange(8 * MS) if late_ms else 0)
        poses += [source.take(Line(line, arrival_ns)) for line in sent]
    return [pose for pose in poses if pose is not None]


def test_sentences_of_any_rate_become_poses_of_the_instants_of_attitude() -> None:
    source, counters = source_of(USUAL)
    poses = fly(source, Ins(), 4.0)
    assert len(poses) == 199  # the first attitude has no place yet
    for number, pose in enumerate(poses, 1):
        t_ns = number * 20 * MS
        assert pose.t_ns == pytest.approx(t_ns, abs=500_000)
        assert pose.position_ned == pytest.approx(Ins.place(t_ns), abs=2e-3)
        assert pose.velocity_body == pytest.approx((SPEED, 0.0, 0.0))
        assert abs(float(TURN.as_quat(scalar_first=True) @ pose.attitude)) == pytest.approx(1.0, abs=1e-9)
        assert [math.degrees(sigma) for sigma in pose.sigma_attitude] == pytest.approx([0.1, 0.2, 0.3])
        age_s, depth_age_s = (number - 1) % 50 * 0.02 + 0.1, (number - 1) % 5 * 0.02 + 0.02
        grown = [(0.3, age_s), (0.4, age_s), (0.5, depth_age_s)]
        expected = [math.hypot(sigma, 0.2 * age) for sigma, age in grown]
        assert pose.sigma_position_ned == pytest.approx(expected, abs=1e-3)
    assert source.problems(4 * NS) == []
    assert {name for name, count in counters.items() if count} == {"nmea_sentences", "epoch_aged"}


def test_instants_are_the_devices_not_those_of_arrival_and_midnight_is_no_event() -> None:
    source, counters = source_of(USUAL)
    poses = fly(source, Ins(start_ms=86_400_000 - 2000), 6.0, random.Random(3))
    steps = [second.t_ns - first.t_ns for first, second in itertools.pairwise(poses[100:])]
    assert max(abs(step - 20 * MS) for step in steps) < 1.5 * MS
    assert counters["ins_clock_jumps"] == counters["ins_clock_wild"] == 0


def test_what_is_old_not_valid_or_missing_is_said_by_name() -> None:
    settings = msgspec.structs.replace(USUAL, held={"BS": HeldSettings(max_age_s=0.3)}, accuracy=None)
    source, counters = source_of(settings)
    ins = Ins()
    for line in (ins.gga(0), ins.bs(), ins.pashr(0)):
        assert source.take(Line(line, 0)) is None
    assert source.problems(NS)[1] == "TS (depth) has never come"
    source.take(Line(ins.ts(NS), NS))
    source.take(Line(ins.bs("V"), NS))
    source.take(Line(ins.gga(NS), NS))
    assert source.take(Line(ins.pashr(NS), NS)) is None
    assert source.problems(NS) == [
        "no pose for 1.0 s", "BS: has been flagged as not valid for 1.0 s (no bottom track)"
    ]  # fmt: skip
    source.take(Line(ins.bs(), NS))
    assert source.take(Line(ins.pashr(NS + MS), NS + MS)) is not None
    assert source.problems(2 * NS + 400 * MS) == ["no pose for 1.4 s: no data arrive on the line any more"]
    source.take(Line(summed("GPGSV,1,1,00"), 2 * NS + 399 * MS))
    assert source.problems(2 * NS + 400 * MS) == [
        "no pose for 1.4 s",
        "GGA: last came 1.4 s ago, nav.nmea.held.GGA.max_age_s is 0.5",
        "TS: last came 1.4 s ago, nav.nmea.held.TS.max_age_s is 0.5",
        "BS: last came 1.4 s ago, nav.nmea.held.BS.max_age_s is 0.3",
    ]
    assert (counters["epoch_aged"], counters["nmea_not_valid"]) == (2, 1)


def test_two_talkers_are_said_and_one_can_be_named() -> None:
    ins = Ins()
    lines = [ins.gga(0, "GP", 0), ins.gga(0, "IN")]
    source, counters = source_of(USUAL)
    for line in lines:
        source.take(Line(line, 0))
    assert "GGA comes from several talkers, GP and IN: name one in nav.nmea, such as GPGGA" in source.problems(NS)
    source, counters = source_of(msgspec.structs.replace(USUAL, place="INGGA"))
    for line in lines:
        source.take(Line(line, 0))
    assert not any("comes from" in problem for problem in source.problems(NS))
    assert counters == {"nmea_other": 1, "nmea_sentences": 1}


def test_a_second_talker_that_is_silent_again_is_no_problem_any_more(caplog: pytest.LogCaptureFixture) -> None:
    ins = Ins()
    source, counters = source_of(USUAL)
    for second in range(30):
        source.take(Line(ins.gga(second * NS, "IN"), second * NS))
        if second in (3, 18):
            source.take(Line(ins.gga(second * NS, "GP"), second * NS))
        reported = any("comes from several talkers, GP and IN" in problem for problem in source.problems(second * NS))
        assert reported == (3 <= second <= 13 or 18 <= second <= 28), second
    assert counters["nmea_talkers"] == 22
    assert [record.getMessage() for record in caplog.records] == [
        "GGA comes from several talkers, GP and IN: name one in nav.nmea, "
        "such as GPGGA (logged once, then counted as nmea_talkers)"
    ]


def test_noise_is_reported_from_silence() -> None:
    source, counters = source_of(USUAL)
    source.take(Line(b"\x81\x00\xff", NS))
    assert "the data received are not NMEA: are nav.nmea.port, baud, ground and polarity right?" in source.problems(NS)
    assert counters == {"nmea_damaged": 1}
    by_network = msgspec.structs.replace(USUAL, port="udp://0.0.0.0:10110")
    source, _ = source_of(by_network)
    source.take(Line(b"\x81\x00\xff", NS))
    said = "the data received are not NMEA: is nav.nmea.port right, and is what is sent there NMEA 0183?"
    assert source.problems(NS)[1:] == [said]


def test_utc_is_the_inss_where_this_computers_clock_is_not_synchronized() -> None:
    utc = Utc(lambda: WallClock(0, synchronized=False))
    source, counters = source_of(USUAL, utc)
    for second in range(3):
        source.take(Line(summed(f"INZDA,12000{second}.50,22,09,2026,00,00"), second * NS))
    assert utc.at(5 * NS) == (1_790_078_405_500_000_000, "ins")
    source.take(Line(summed("INZDA,,,,,,"), 3 * NS))
    assert utc.at(5 * NS)[1] == "unsure"
    assert counters["nmea_not_valid"] == 1


@pytest.mark.parametrize("year", ["99", "1980", "2007", "2117", "2300", "9999"])
def test_a_year_that_cannot_be_is_no_utc(year: str) -> None:
    """No message carries the last ones: `nav` ended as it sent its pose, or nobody believed the pose."""
    utc = Utc(lambda: WallClock(NS, synchronized=False))
    source, counters = source_of(USUAL, utc)
    for second in range(6):
        source.take(Line(summed(f"INZDA,12000{second}.50,22,09,{year},00,00"), second * NS))
    assert utc.at(5 * NS) == (6 * NS, "unsure")
    assert counters["time_bad"] == 6


def test_heading_and_velocity_of_single_sensors() -> None:
    settings = NmeaSettings(port="/dev/null", depth="DBS", heading="HEHDT", velocity="VTG")
    source, counters = source_of(settings)
    ins = Ins()
    course, knots = math.degrees(math.atan2(VELOCITY[1], VELOCITY[0])), math.hypot(*VELOCITY[:2]) * 3600 / 1852
    for line in (
        ins.gga(0), summed("SDDBS,,f,20.0,M,,F"), summed(f"HEHDT,{math.degrees(YAW):.6f},T"),
        summed(f"GPVTG,{course % 360:.6f},T,,M,{knots:.6f},N,,K"),
    ):  # fmt: skip
        source.take(Line(line, 0))
    pose = source.take(Line(ins.pashr(0), 0))
    assert pose is not None, (source.problems(0), counters)
    assert pose.position_ned == pytest.approx((0.0, 0.0, 20.0), abs=1e-3)
    assert TURN.apply(pose.velocity_body) == pytest.approx([*VELOCITY[:2], 0.0], abs=1e-4)
    assert abs(float(TURN.as_quat(scalar_first=True) @ pose.attitude)) == pytest.approx(1.0, abs=1e-9)
    assert pose.sigma_attitude == (0.005, 0.005, 0.005)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"place": "GLL"}, "place: 'GLL' is not one of GGA, RMC"),
        ({"attitude": "HDT"}, "attitude: 'HDT' is not one of PASHR, PSXN, SA"),
        ({"velocity": "GPVTQ"}, "velocity: 'GPVTQ' is not one of VTG, RMC, BS, BE"),
        ({"held": {"VGT": HeldSettings()}}, "held: 'VGT' is not one of "),
        ({"port": "udp://host:1"}, "port: udp://host:1: needs an IP address"),
        ({"port": "udp://127.0.0.1"}, "port: udp://127.0.0.1: needs a port number"),
        ({"port": "udp://127.0.0.1:70000"}, "port: udp://127.0.0.1:70000: needs a port number from 1 to 65535"),
        ({"sender": "ins.local"}, "sender: ins.local: not an IP address"),
        ({"port": "tsp://127.0.0.1:1"}, "port: tsp://127.0.0.1:1: neither a device nor an address"),
    ],
)
def test_settings_that_do_not_fit_are_one_line(changes: dict[str, object], said: str) -> None:
    with pytest.raises(ValueError, match=f"^{re.escape(said)}"):
        msgspec.structs.replace(USUAL, **changes)
