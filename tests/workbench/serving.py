"""A workbench in a process of its own, and a client that has its cookie."""

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import httpx

PROJECT = Path(__file__).parents[2]


class Serving(NamedTuple):
    """A server that runs."""

    link: str
    """Of the first browser."""
    process: "subprocess.Popen[str]"

    @property
    def origin(self) -> str:
        return self.link.partition("/?")[0]

    def line(self) -> str:
        """Return the next line that it prints."""
        assert self.process.stdout is not None
        return self.process.stdout.readline()

    def client(self, link: str = "") -> httpx.Client:
        """Return a browser without a window that came by a link."""
        client = httpx.Client(base_url=self.origin, trust_env=False)
        assert client.get(link or self.link).status_code == 303
        return client


@contextmanager
def serving(*words: str, module: str = "ods", folder: Path | None = None) -> Iterator[Serving]:
    """Run `python -m module words` until it serves; words of the workbench go without its name."""
    own = ("workbench", "--no-browser", "--port", "0") if module == "ods" else ()
    environment = {**os.environ, "PYTHONPATH": str(PROJECT)}
    process = subprocess.Popen(
        [sys.executable, "-m", module, *own, *words],
        cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    try:
        assert process.stdout is not None
        said = []
        found = None
        while found is None and (line := process.stdout.readline()):  # a warning may come first
            said.append(line)
            found = re.search(r"http://127\.0\.0\.1:\d+/\?token=\S+", line)
        assert found, "".join(said)
        yield Serving(found[0], process)
    finally:
        process.terminate()
        process.wait(timeout=20)
        assert process.stdout is not None
        process.stdout.close()
