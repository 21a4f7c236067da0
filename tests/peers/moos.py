"""MOOSDB, pShare and one application of MOOS-IvP as processes, spoken to by the datagrams of pShare.

tests/peers/build_moos.sh builds the programs; ODS_MOOS names their folder, without it there is nothing to test with.
"""

import os
import socket
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import pytest

from ods.base import clock
from tests.bridge import moos_datagrams

MOOS = Path(os.environ.get("ODS_MOOS", "nowhere"))

COMMUNITY = """
ServerHost = 127.0.0.1
ServerPort = {db}
Community = test
LatOrigin = 57.048
LongOrigin = 9.9187
Term_Reporting = false
ProcessConfig = pShare
{{
  AppTick = 20
  CommsTick = 20
  Input = route=localhost:{into}
{outputs}
}}
ProcessConfig = {application}
{{
{settings}
}}
"""


def needs(application: str) -> list[pytest.MarkDecorator]:
    """Return the marks of tests with it."""
    there = (MOOS / application).exists()
    return [pytest.mark.slow, pytest.mark.skipif(not there, reason=f"ODS_MOOS names no folder with {application}")]


@contextmanager
def community(application: str, settings: str, said: Sequence[str], into: int, out: int) -> Iterator[None]:
    """Run the programs: they listen at the port `into`; what is said in the variables `said` goes to `out`."""
    outputs = "\n".join(f"  Output = src_name={name}, route=127.0.0.1:{out}" for name in said)
    text = COMMUNITY.format(
        db=free_port(socket.SOCK_STREAM), into=into, outputs=outputs, application=application, settings=settings
    )
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:
        mission = Path(folder) / "test.moos"
        mission.write_text(text)
        started = []
        for program in ("MOOSDB", "pShare", application):
            with (Path(folder) / f"{program}.log").open("wb") as log:
                command = [program, str(mission)]  # its first word is the name by which it finds its block
                started.append(subprocess.Popen(command, executable=MOOS / program, stdout=log, stderr=log, cwd=folder))
        try:
            yield
        finally:
            for process in reversed(started):
                process.kill()
                process.wait()


def free_port(kind: int) -> int:
    """Return a port of this machine that nobody uses."""
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def say(peer: socket.socket, into: int, key: str, value: float | str) -> None:
    """Set a variable. Applications take what comes together in the order of its times, so each has its own."""
    peer.sendto(moos_datagrams.written(key, value, clock.utc_ns() / clock.NS), ("127.0.0.1", into))
