"""`ods run` and its processes go on while nobody reads what they log: they stood still, and nothing was restarted."""

import os
import subprocess
import sys
from contextlib import suppress

PROGRAM = """
import logging
import ods.commands.run as command

def run(_):
    for number in range({lines}):
        logging.getLogger("ods").warning("line %d", number)

command.run = run
from ods.cli import main
raise SystemExit(main(["run"]))
"""
LINES = 3000
"""More than the queue holds."""


def test_a_pipe_that_nobody_reads_holds_nobody_up() -> None:
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    with suppress(BlockingIOError):
        while True:
            os.write(writer, b"x" * 4096)
    os.set_blocking(writer, True)
    process = subprocess.Popen([sys.executable, "-c", PROGRAM.format(lines=LINES)], stderr=writer)
    try:
        assert process.wait(60.0) == 0
    finally:
        process.kill()
        os.close(writer)
        os.close(reader)


def test_all_lines_come_where_they_are_read() -> None:
    reported = subprocess.run(
        [sys.executable, "-c", PROGRAM.format(lines=200)], stderr=subprocess.PIPE, text=True, check=True
    )
    assert [line.partition("run: ")[2] for line in reported.stderr.splitlines()] == [f"line {k}" for k in range(200)]
