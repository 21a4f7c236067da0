"""What every test on vcan shares. Links are set down and up, deleted and made again by `in_vcan.links`.

Without vcan0 the tests are skipped; with ODS_REQUIRE_VCAN in the environment, as in CI, a skipped test is a failure.
"""

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from in_vcan import links

HERE = Path(__file__).parent
REQUIRED = bool(os.environ.get("ODS_REQUIRE_VCAN"))
collect_ignore = [] if b"guest.py" in Path("/proc/1/cmdline").read_bytes() else ["test_clock_step.py"]
"""The clock of this computer is not a test's to set; that of a guest kernel is."""


def fresh(name: str) -> Iterator[str]:
    if links.exists(name):
        links.delete(name)
    links.make(name)
    yield name
    if not links.is_up(name):
        if links.exists(name):
            links.delete(name)
        links.make(name)


@pytest.fixture
def vcan0() -> Iterator[str]:
    """A vcan0 just made and up, with nobody on it; whatever the test does to it is put right afterwards."""
    yield from fresh("vcan0")


@pytest.fixture
def vcan1() -> Iterator[str]:
    """A second bus, as vcan0."""
    yield from fresh("vcan1")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    if all(links.is_up(name) for name in links.NAMES):
        return
    if REQUIRED:
        pytest.exit("vcan: ODS_REQUIRE_VCAN is set, and vcan0 and vcan1 are not here", 1)
    for item in items:
        if HERE in item.path.parents:
            item.add_marker(pytest.mark.skip(reason="no vcan0 and vcan1 here: make test-vcan"))


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    counts = {kind: len(terminalreporter.stats.get(kind, [])) for kind in ("passed", "failed", "error", "skipped")}
    said = ", ".join(f"{count} {kind}" for kind, count in counts.items() if count)
    terminalreporter.write_line(f"vcan: {said or 'nothing ran'}")


def pytest_sessionfinish(session: pytest.Session) -> None:
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if REQUIRED and reporter and reporter.stats.get("skipped"):
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
