"""What a terminal shows, where there is none."""

import pytest

from ods.base.command_line.terminal import StatusLine, coloured


def test_closed_streams_are_no_terminals(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setattr("sys.stdout", None)
    monkeypatch.setattr("sys.stderr", None)
    assert coloured("good", "green") == "good"
    StatusLine().show("1: kernel")
