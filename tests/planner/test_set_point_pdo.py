"""The set point on CAN, byte by byte."""

import math
from pathlib import Path

import pytest

from ods.base.errors import OdsError
from ods.planner.set_point_pdo import pdo_of

EDS = Path(__file__).parents[2] / "config" / "vehicle.eds"


def test_it_is_rpdo_1_of_the_vehicle() -> None:
    pdo = pdo_of(EDS, 6)
    assert (pdo.can_id, pdo.deadline_s) == (0x206, 1.0)


@pytest.mark.parametrize(
    ("heading", "speed", "down", "data"),
    [
        (0.0, 0.0, 0.0, "0000000000000000"),
        (1.5, 2.0, 20.0, "983ad007204e0000"),  # 15000, 2000, 20000
        (-0.1, 1.25, -0.5, "88f1e2040cfeffff"),  # 61832 = (2 pi - 0.1) 10^4, 1250, -500
        (2.0 * math.pi - 1e-6, 32.0, 1e5, "70f5007d00e1f505"),  # 62832, 32000, 10^8
    ],
)
def test_bytes_by_hand(heading: float, speed: float, down: float, data: str) -> None:
    pdo = pdo_of(EDS, 6)
    assert pdo.encode(heading, speed, down).hex() == data
    decoded = pdo.decode(bytes.fromhex(data))
    assert decoded is not None
    assert decoded == pytest.approx((heading % (2.0 * math.pi), speed, down), abs=6e-5)


def test_a_frame_that_is_too_short_holds_nothing() -> None:
    assert pdo_of(EDS, 6).decode(bytes(7)) is None


@pytest.mark.parametrize(
    ("was", "is_", "said"),
    [
        ("[1400sub5]", "[1400sub6]", "no RPDO 1"),
        ("0x21000110", "0x21000210", "must hold"),
        ("=1000", "=0", "must hold"),
    ],
)
def test_another_eds_is_refused_in_one_line(tmp_path: Path, was: str, is_: str, said: str) -> None:
    file = tmp_path / "other.eds"
    file.write_text(EDS.read_text().replace(was, is_))
    with pytest.raises(OdsError, match=said) as refused:
        pdo_of(file, 6)
    assert "\n" not in str(refused.value)


def test_no_file_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(OdsError, match=r"none\.eds"):
        pdo_of(tmp_path / "none.eds", 6)
