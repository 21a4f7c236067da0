"""Every examination in turn."""

from collections.abc import Iterator
from pathlib import Path

from ods.base.errors import OdsError
from ods.base.settings_file import load
from ods.config import OnboardConfig
from ods.doctor import chain, disk, machine, mounting, navigation, plugins, running, unusual
from ods.doctor.finding import Finding
from ods.doctor.lines import nav_line, sonar_port
from ods.runtime.run_dir import is_locked


def findings(config: Path, listen_s: float = 0.0, run_dir: Path | None = None) -> Iterator[Finding]:
    """Yield what is found, good or not. run_dir: where the processes meet, if not where the configuration says."""
    yield from machine.versions()
    yield from machine.wall_clock()
    yield from machine.sqlite_rtree()
    try:
        settings = load(config, OnboardConfig)
    except OdsError as error:
        yield Finding("wrong", "configuration", str(error))
        return
    yield Finding("good", "configuration", f"{config} is complete, with every value in range")
    yield from unusual.examine(settings)
    yield from chain.examine(settings.pipeline)
    yield from plugins.examine(settings)
    yield from disk.map_file(settings.tracker.map.path, settings.site)
    yield from disk.recordings(settings.record)
    line = list(sonar_port.examine(settings.sonar.port, in_use=is_locked(settings.bus.run_dir, "sonar")))
    yield from line
    if listen_s and not _is_wrong(line):
        yield from sonar_port.listen(settings, listen_s)
    yield from mounting.examine(settings.sonar.mounting, settings.nav.lever_arm_m)
    line = list(nav_line.examine(settings.nav))
    yield from line
    source = list(navigation.files(settings))
    yield from source
    if listen_s and source[-1].level == "good" and not _is_wrong(line):
        yield from navigation.listen(settings, listen_s)
    yield from running.sockets(run_dir or settings.bus.run_dir)


def _is_wrong(line: list[Finding]) -> bool:
    """Return whether a line cannot be used: to listen to it would only say so again."""
    return any(item.level == "wrong" for item in line)
