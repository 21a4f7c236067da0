"""The changelog: versions in order, the newest one is the program's."""

import re
from datetime import date
from pathlib import Path

import ods

TEXT = (Path(__file__).parents[2] / "CHANGELOG.md").read_text()
KINDS = {"Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"}


def test_versions_fall_and_the_newest_is_the_programs() -> None:
    first, *released = re.findall(r"^## (.+)$", TEXT, re.MULTILINE)
    assert first == "Unreleased"
    versions = [tuple(map(int, heading.split(" - ")[0].split("."))) for heading in released]
    days = [date.fromisoformat(heading.split(" - ")[1]) for heading in released]
    assert versions == sorted(set(versions), reverse=True)
    assert days == sorted(days, reverse=True)
    assert ".".join(map(str, versions[0])) == ods.__version__


def test_every_line_is_of_a_kind() -> None:
    for version in re.split(r"^## .+$", TEXT, flags=re.MULTILINE)[1:]:
        kinds = re.findall(r"^### (.+)$", version, re.MULTILINE)
        assert sorted(kinds) == sorted(KINDS & set(kinds))  # each once
        assert not re.search(r"^- ", version.split("### ")[0], re.MULTILINE)
