"""One Debian, installed and booted for all tests of this folder, which go through its life in their order.

Where it cannot be had the tests are skipped; with ODS_REQUIRE_SYSTEMD in the environment, as in CI, that is a failure.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from in_vcan import modules, uml
from in_vcan.job import NotHereError
from tests.systemd import debian_root
from tests.systemd.guest_machine import Guest
from tests.systemd.life import Life

REQUIRED = bool(os.environ.get("ODS_REQUIRE_SYSTEMD"))
HERE = Path(__file__).parent
GUEST = "usr/local/lib/guest"
figures: list[str] = []


@pytest.fixture(scope="session")
def figure() -> Callable[[str], None]:
    """Return a function that takes a figure for the end of the report."""
    return figures.append


@pytest.fixture(scope="session")
def folder() -> Iterator[Path]:
    """Return a folder for root and disk; beside pytest's own, which keep three of each."""
    with tempfile.TemporaryDirectory(prefix="ods-systemd-", dir="/var/tmp", ignore_cleanup_errors=True) as name:
        yield Path(name)


@pytest.fixture(scope="session")
def kernel() -> uml.Kernel:
    """Return the guest's kernel."""
    try:
        return uml.usable_kernel()
    except NotHereError as error:
        pytest.skip(str(error))


@pytest.fixture(scope="session")
def root(folder: Path, kernel: uml.Kernel) -> Path:
    """Return the root of a Debian with the project's sources in /src, and what pip needs in /wheels.

    As it has no compiler, the wheels of the project are there, too: of this version, and in /newer of a later one.
    """
    try:
        base = debian_root.base()
        wheels = debian_root.wheels(base)
    except NotHereError as error:
        pytest.skip(str(error))
    root = folder / "root"
    subprocess.run(["cp", "-a", base, root], check=True)
    shutil.copytree(wheels, root / "wheels")
    debian_root.put_sources(root / "src")
    for place, version in (("wheels", None), ("newer", "99.0")):
        (root / place).mkdir(exist_ok=True)
        shutil.copy(debian_root.project_wheel(folder / f"wheel-{place}", version), root / place)
    for user in ("planner", "stranger"):
        inside(root, "useradd", user)
    return root


def inside(root: Path, *command: str) -> str:
    """Run a command in the root that must not fail, pip without a network; return what it printed."""
    (wheel,) = (root / "wheels").glob("ods-*.whl")
    done = debian_root.inside(root, *command, PIP_NO_INDEX="1", PIP_FIND_LINKS="/wheels", WHEEL=f"/wheels/{wheel.name}")
    assert done.returncode == 0, done.stdout
    return done.stdout


@pytest.fixture(scope="session")
def containers_lines(root: Path) -> str:
    """Run the line of the Containerfile that installs; return what it printed."""
    lines = (debian_root.PROJECT / "Containerfile").read_text().splitlines()
    (line,) = [line.removeprefix("RUN ") for line in lines if line.startswith("RUN make")]
    return inside(root, "sh", "-c", line.replace("&& rm -rf /src ", ""))


@pytest.fixture(scope="session")
def installed(root: Path, containers_lines: str) -> str:
    """Install by `make install`; return what it printed."""
    return inside(root, "make", "-C", "/src", "install")


@pytest.fixture(scope="session")
def life(root: Path, installed: str, kernel: uml.Kernel, folder: Path) -> Iterator[Life]:
    """Return the computer, booted, with an INS on its CAN bus and a sonar on its serial line."""
    _furnish(root, kernel)
    debian_root.make_disk(root, folder / "disk")
    subprocess.run(["rm", "-rf", root], check=True)
    guest = Guest(kernel, folder)
    guest.switch_on()
    try:
        yield Life(guest)
    finally:
        guest.shut_down()


def _furnish(root: Path, kernel: uml.Kernel) -> None:
    """Add what is not ODS: kernel modules, the far ends of sonar and INS, the planner, the agent of the tests."""
    inside(root, "usermod", "--append", "--groups", "ods,systemd-journal", "planner")
    target = root / "lib" / "modules" / kernel.version
    target.mkdir(parents=True)
    for name, content in modules.in_order(kernel.modules, modules.CAN):
        (target / f"{name}.ko").write_bytes(content)
    for name in ("modules.order", "modules.builtin"):
        shutil.copy(kernel.modules / name, target)
    inside(root, "depmod", kernel.version)
    shutil.copytree(HERE / "guest", root / GUEST)
    units = list((root / GUEST).glob("*.service"))
    for unit in units:
        shutil.move(unit, root / "etc/systemd/system")
    for file in (root / GUEST).glob("can0.*"):
        shutil.move(file, root / "etc/systemd/network")
    shutil.copytree(root / GUEST / "system.conf.d", root / "etc/systemd/system.conf.d")
    inside(root, "systemctl", "enable", "systemd-networkd", *(unit.name for unit in units))
    inside(root, "systemctl", "mask", "e2scrub_reap.service")  # half a minute of nothing that matters here
    pings = str(root / GUEST / "pings.npz")
    words = ["simulate", str(HERE / "scene.toml"), "--sonar", "seabat6012_slow", "--pings", "20", "--out", pings]
    subprocess.run([sys.executable, "-m", "ods", *words], check=True)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    counts = {kind: len(terminalreporter.stats.get(kind, [])) for kind in ("passed", "failed", "error", "skipped")}
    said = ", ".join(f"{count} {kind}" for kind, count in counts.items() if count)
    reasons = {str(report.longrepr[2]) for report in terminalreporter.stats.get("skipped", [])}
    terminalreporter.write_line("; ".join([f"systemd: {said or 'nothing ran'}", *figures, *reasons]))


def pytest_sessionfinish(session: pytest.Session) -> None:
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if REQUIRED and reporter and reporter.stats.get("skipped"):
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
