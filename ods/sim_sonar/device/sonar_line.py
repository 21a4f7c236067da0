"""Which line the simulated sonar and the on-board side share."""

from pathlib import Path

from ods.sim_sonar.device.remote_end import Line
from ods.sim_sonar.device.serial_line import SerialLine
from ods.sim_sonar.device.tcp_line import HOST, TcpLine
from ods.sim_sonar.settings import SimSettings

SERIAL_PORT = "seabat"
"""Name of the simulated sonar's device in the run folder."""


def port_of(sim: SimSettings, run_dir: Path) -> str:
    """Return `sonar.port` for the on-board side."""
    return f"tcp://{HOST}:{sim.sonar_tcp_port}" if sim.sonar_line == "tcp" else str(run_dir / SERIAL_PORT)


def open_line(sim: SimSettings, run_dir: Path) -> Line:
    """Make the line appear."""
    return TcpLine(sim.sonar_tcp_port) if sim.sonar_line == "tcp" else SerialLine(run_dir / SERIAL_PORT)
