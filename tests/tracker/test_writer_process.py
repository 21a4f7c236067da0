"""The map's process, where the computer cannot start it."""

import errno
import os
import socket
import subprocess
from pathlib import Path

import psutil
import pytest

from ods.base.clock import NS
from ods.tracker.map.link import FIRST_DELAY_S, LinkEndedError
from ods.tracker.map.writer_process import WriterProcess


@pytest.mark.parametrize(("module", "name"), [(socket, "socketpair"), (subprocess, "Popen")])
def test_no_descriptor_or_process_left_costs_the_map_for_a_while_and_not_the_tracker(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, module: object, name: str
) -> None:
    def none_left(*_: object, **__: object) -> None:
        raise OSError(errno.EMFILE, os.strerror(errno.EMFILE))

    writer = WriterProcess(tmp_path / "map.sqlite", (57.0, 10.0), tmp_path)
    with monkeypatch.context() as patch:
        patch.setattr(module, name, none_left)
        with pytest.raises(LinkEndedError, match="Too many open files"):
            writer.start(0)
    writer.lost(0)
    assert not writer.start(round(FIRST_DELAY_S * NS) - 1)
    assert writer.start(2 * NS)
    writer.finish([], 10.0)


def test_ctrl_c_in_a_terminal_does_not_reach_it(tmp_path: Path) -> None:
    """Until it takes no signals, which it says itself, it would end with a traceback."""
    writer = WriterProcess(tmp_path / "map.sqlite", (57.0, 10.0), tmp_path)
    before = set(psutil.Process().children())
    writer.start(0)
    (process,) = set(psutil.Process().children()) - before
    assert os.getpgid(process.pid) == process.pid != os.getpgrp()
    writer.finish([], 10.0)
