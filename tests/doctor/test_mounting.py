"""The mounting in words, so that whoever knows the vehicle sees a wrong sign."""

import pytest

from ods.base.frames.mounting import MountingSettings
from ods.doctor.mounting import examine, words_of


@pytest.mark.parametrize(
    ("mounting", "words"),
    [
        (MountingSettings(), "at the vehicle's origin and looks straight ahead"),
        (
            MountingSettings(position_m=(3.7, 0.3, 0.9), pitch_deg=-15.0),
            "3.7 m ahead, 0.3 m to starboard, 0.9 m down of the vehicle's origin and looks 15 deg down",
        ),
        (
            MountingSettings(position_m=(-1.0, -0.5, -0.25), roll_deg=180.0, pitch_deg=2.5, yaw_deg=-90.0),
            "1 m astern, 0.5 m to port, 0.25 m up of the vehicle's origin and looks 90 deg to port and 2.5 deg up, "
            "rolled 180 deg to starboard",
        ),
    ],
)
def test_words(mounting: MountingSettings, words: str) -> None:
    assert words_of(mounting) == words


def test_an_ins_away_from_the_origin_is_a_note() -> None:
    assert len(list(examine(MountingSettings(), (0.0, 0.0, 0.0)))) == 1
    _, ins = examine(MountingSettings(), (-3.0, 0.0, 0.0))
    assert (ins.level, ins.text) == ("good", "the INS is 3 m astern of the vehicle's origin")


def test_angles_that_may_be_radians_are_noted() -> None:
    _, note = examine(MountingSettings(pitch_deg=-0.26, yaw_deg=1.5708), (0.0, 0.0, 0.0))
    told = (
        "angles of sonar.mounting are degrees; if these are radians, -0.26 would be -14.9 deg and 1.5708 would be 90.0"
    )
    assert (note.level, note.text) == ("note", f"{told} deg")
    assert len(list(examine(MountingSettings(pitch_deg=-15.0, yaw_deg=0.5), (0.0, 0.0, 0.0)))) == 1


def test_a_fan_that_stands_upright_is_noted() -> None:
    _, note = examine(MountingSettings(roll_deg=-90.0), (0.0, 0.0, 0.0))
    text = "sonar.mounting puts the fan 90 deg from level: beyond 50 deg position errors exceed their reported sigma"
    assert (note.level, note.text) == ("note", text)
    for mounting in (MountingSettings(roll_deg=180.0, pitch_deg=-20.0), MountingSettings(roll_deg=45.0)):
        assert len(list(examine(mounting, (0.0, 0.0, 0.0)))) == 1
