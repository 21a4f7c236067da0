"""`ods compile` where plug-ins are named; the compiling itself is tested in tests/install."""

from pathlib import Path

import msgspec

from ods.base.settings_file import load
from ods.commands.compile import _job
from ods.config import OnboardConfig


def test_another_plug_in_or_another_text_of_it_is_another_job(tmp_path: Path) -> None:
    plain = load(Path("config/onboard.toml"), OnboardConfig)
    file = tmp_path / "mine.py"
    plugged = msgspec.structs.replace(plain, tracker=msgspec.structs.replace(plain.tracker, plugins=(file,)))
    file.write_text("first")
    jobs = [_job(plain), _job(plugged), _job(plugged)]
    file.write_text("second")
    jobs.append(_job(plugged))
    assert jobs[1] == jobs[2]
    assert len(set(jobs)) == 3
