"""Numbers on the command line: of the wrong unit, or none at all, they are refused before anything is done."""

import pytest

from ods.cli import main


@pytest.mark.parametrize(
    ("arguments", "reported"),
    [
        ("map prune map --existence-below 50", "--existence-below: '50' is not a number, 0 to 1"),
        ("map prune map --older-than -1", "--older-than: '-1' is not a number of days, 0 to 1e+06"),
        ("map prune map --older-than nan", "--older-than: 'nan' is not a number of days, 0 to 1e+06"),
        ("map prune map --outside 0 0 -5", "--outside: METRES is -5: must not be negative"),
        ("map list map --within nan 0 5", "--within: 'nan' is not a number of metres, -1e+07 to 1e+07"),
        ("set-sonar --range nan", "--range: 'nan' is not a number of metres, 0.1 to 20000"),
        ("set-sonar --gain loud", "--gain: 'loud' is not a number of dB, -200 to 300"),
        ("calibrate x.s7k --depth inf", "--depth: 'inf' is not a number of metres, -12000 to 12000"),
        ("assess sea --clearance nan", "--clearance: 'nan' is not a number of metres, 0 to 1000"),
        ("bench --seconds nan", "--seconds: 'nan' is not a number of seconds above 0"),
        ("replay x --live --speed 1e9", "--speed: '1e9' is not a number, 0.01 to 100"),
        ("replay x --live --from -1", "--from: '-1' is not a number of seconds, 0 to 1e+09"),
    ],
)
def test_what_no_such_number_can_be_is_one_line(
    arguments: str, reported: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(arguments.split())
    assert ended.value.code == 2
    command = arguments.partition(" -")[0].removesuffix(" x").removesuffix(" x.s7k").removesuffix(" map")
    assert capsys.readouterr().err == f"ods {command}: argument {reported} (see ods {command} --help)\n"


def test_names_with_a_comma_are_distinguished(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["assess", "track", "--trackers", "coupled"]) == 2
    assert "is not one of 'independent, nearest', 'independent, probabilistic', " in capsys.readouterr().err
