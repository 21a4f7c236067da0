"""The line between the simulated sonar and the on-board side, and the choice of the sonar."""

from pathlib import Path

from ods.base.errors import OdsError
from ods.base.settings_file import load
from ods.sim_sonar.device.lines.multicast_line import MulticastLine
from ods.sim_sonar.device.lines.serial_line import SerialLine
from ods.sim_sonar.device.lines.tcp_line import HOST, FramedTcpLine, TcpLine
from ods.sim_sonar.device.lines.udp_line import UdpLine
from ods.sim_sonar.device.remote_control_server import Line
from ods.sim_sonar.device.simulated_sonar import SimulatedSonar
from ods.sim_sonar.device.sonars.norbit import SimulatedNorbit
from ods.sim_sonar.device.sonars.oculus import SimulatedOculus
from ods.sim_sonar.device.sonars.ping360 import SimulatedPing360
from ods.sim_sonar.device.sonars.seabat import SimulatedSeaBat, refuse_beyond_s7k
from ods.sim_sonar.device.sonars.sonar3d15 import SimulatedSonar3d15
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.settings import SimSettings
from ods.sim_sonar.sonar.settings import SonarFile

GROUP = "224.0.0.96"
"""To which a Sonar 3D-15 sends."""
SERIAL_PORT = "seabat"
"""Name of the simulated sonar's device in the run folder."""


def port_of(sim: SimSettings, run_dir: Path) -> str:
    """Return `sonar.port` for the on-board side."""
    if sim.sonar_line in ("serial", "ping360"):
        return str(run_dir / SERIAL_PORT)
    if sim.sonar_line == "sonar3d15":
        return f"udp://{GROUP}:{sim.sonar_udp_port}"
    scheme, port = ("udp", sim.sonar_udp_port) if sim.sonar_line == "ping360_udp" else ("tcp", sim.sonar_tcp_port)
    return f"{scheme}://{HOST}:{port}"


def has_numbers(sim: SimSettings) -> bool:
    """Return whether the sonar numbers its pings."""
    return sim.sonar_line not in ("ping360", "ping360_udp")


def open_sonar(sim: SimSettings, run_dir: Path, images: ImageSimulator) -> tuple[SimulatedSonar, Line]:
    """Make the line appear, with the sonar at its far end; `images`: those after switching on. Raises OdsError."""
    if sim.sonar_line == "oculus":
        plain = TcpLine(sim.sonar_tcp_port)
        return SimulatedOculus(load(sim.sonar, SonarFile), images, plain, sim.sonar_status_port), plain
    if sim.sonar_line == "norbit":
        plain = TcpLine(sim.sonar_tcp_port)
        return SimulatedNorbit(images, plain, TcpLine(sim.sonar_command_port)), plain
    if sim.sonar_line == "sonar3d15":
        try:
            return SimulatedSonar3d15(images), MulticastLine(GROUP, sim.sonar_udp_port)
        except ValueError as error:
            raise OdsError(f"{sim.scene}: {error}") from error
    if sim.sonar_line in ("ping360", "ping360_udp"):
        scanned: Line = (
            SerialLine(run_dir / SERIAL_PORT) if sim.sonar_line == "ping360" else UdpLine(sim.sonar_udp_port)
        )
        return SimulatedPing360(images, scanned), scanned
    refuse_beyond_s7k(sim.scene, images.scene, sim.sonar, images.sonar)
    line: Line = FramedTcpLine(sim.sonar_tcp_port) if sim.sonar_line == "tcp" else SerialLine(run_dir / SERIAL_PORT)
    return SimulatedSeaBat(images, line), line
