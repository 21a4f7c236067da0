"""The sim process: the far ends of the sonar's line and the CAN bus, and the truth for the bench."""

import queue
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import can

from ods.base import clock
from ods.base.errors import OdsError
from ods.base.frames.mounting import lever_arm_in, mounting_in
from ods.base.geodesy import LocalFrame, SiteSettings
from ods.base.settings_file import load, load_table
from ods.runtime.service import Service, Worker
from ods.sim_sonar.device.lines.serial_line import SerialLine
from ods.sim_sonar.device.live import Device, LiveIns, LiveSonar, Mission
from ods.sim_sonar.device.sonar_line import open_sonar
from ods.sim_sonar.device.vehicle import LiveVehicle, VehicleNode, steered_of
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.ins.can_bus import SLCAN_PORT, can_of, planner_can_of
from ods.sim_sonar.ins.canopen_ins import SimulatedIns
from ods.sim_sonar.ins.canopen_node import SharedEnd, shared
from ods.sim_sonar.ins.dbc_ins import SimulatedDbcIns
from ods.sim_sonar.ins.nmea_ins import PORT, SimulatedNmeaIns
from ods.sim_sonar.ins.place import InsPlace
from ods.sim_sonar.ins.slcan_hub import SlcanHub
from ods.sim_sonar.scene.settings import SceneFile
from ods.sim_sonar.scene.timeline import load_scene
from ods.sim_sonar.settings import SimConfig
from ods.sim_sonar.sonar.model import load_sonar

THREAD_SWITCH_S = 0.001
"""The INS thread must not wait long for the image thread."""
NMEA_PATIENCE_S = 0.005
"""What nobody reads by then is lost, as on a real line."""


class SimWorker(Worker[SimConfig]):
    """Runs the simulated devices in their own threads and publishes the truth behind every ping."""

    def __init__(self, service: Service, settings: SimConfig) -> None:
        super().__init__(service, settings)
        self._hub: SlcanHub | None = None
        self._vehicle: LiveVehicle | None = None
        self._devices: list[Device] = []
        self._closing: list[Callable[[], object]] = []

    def start(self) -> None:
        """Load the scene, make both lines appear, start the devices."""
        sys.setswitchinterval(THREAD_SWITCH_S)
        sim, run_dir = self.settings.sim, self.settings.bus.run_dir
        vehicle = steered_of(sim.vehicle, load(sim.scene, SceneFile).vehicle) if sim.vehicle is not None else None
        scene = load_scene(sim.scene, mounting_in(self.settings.onboard), vehicle)
        sonar_model = load_sonar(sim.sonar)
        try:
            images = ImageSimulator(sonar_model, scene)
            images.render(0.0, 0)
        except ValueError as error:
            raise OdsError(f"{sim.scene}: {error}") from error
        end, self._line = open_sonar(sim, run_dir, images)
        site = load_table(self.settings.onboard, "site", SiteSettings)
        frame = LocalFrame(site.latitude_deg, site.longitude_deg)
        ends = self._can_ends(run_dir)
        ins_end = self._ins(run_dir, frame, ends)
        mission = Mission(clock.monotonic_ns() + round(sim.boot_s * clock.NS), sim.fault)
        self._sonar = LiveSonar(images, end, sim, mission, self._line)
        ins = LiveIns(scene, sim, mission, ins_end, InsPlace(frame, lever_arm_in(self.settings.onboard)))
        self._devices = [Device("simulated sonar", self._sonar.step), Device("simulated INS", ins.step)]
        if sim.vehicle is not None and vehicle is not None:
            node = VehicleNode(ends[-1], sim.vehicle.eds, sim.vehicle.node_id)
            self._vehicle = LiveVehicle(vehicle, node, mission, sonar_model.ping_period_s)
            self._devices.append(Device("simulated vehicle", self._vehicle.step))
        for device in self._devices:
            device.start()

    def _can_ends(self, run_dir: Path) -> list[SharedEnd]:
        """Return an end of the CAN bus for each device that has one: INS, vehicle."""
        sim = self.settings.sim
        count = (sim.ins != "nmea") + (sim.vehicle is not None)
        if not count:
            return []
        bus = self._open_can(run_dir)
        self._closing.append(bus.shutdown)
        return shared(bus, count)

    def _ins(
        self, run_dir: Path, frame: LocalFrame, ends: list[SharedEnd]
    ) -> SimulatedIns | SimulatedDbcIns | SimulatedNmeaIns:
        """Make the INS's line appear, with the INS at its far end."""
        sim = self.settings.sim
        if sim.ins == "nmea":
            line = SerialLine(run_dir / PORT)
            self._closing.append(line.unplug)
            return SimulatedNmeaIns(lambda sentences: line.write(sentences, NMEA_PATIENCE_S), frame)
        if sim.ins == "canopen":
            assert sim.ins_eds is not None  # `SimSettings` has seen to it
            return SimulatedIns(ends[0], sim.ins_eds)
        assert sim.ins_dbc is not None
        return SimulatedDbcIns(ends[0], sim.ins_dbc, frame)

    def _open_can(self, run_dir: Path) -> can.BusABC:
        interface, channel = can_of(self.settings.sim.can, run_dir)
        if interface == "socketcan":
            return can.Bus(interface=interface, channel=channel)
        own_end = run_dir / f"{SLCAN_PORT}-sim"
        _, planners = planner_can_of(self.settings.sim.can, run_dir)
        self._hub = SlcanHub([Path(channel), own_end, Path(planners)])
        return can.Bus(interface=interface, channel=str(own_end), sleep_after_open=0.0)

    def tick(self) -> None:
        """Publish the truth of pings that have been sent, and of the vehicle that obeys."""
        with suppress(queue.Empty):
            while True:
                self.service.publish("truth", self._sonar.truths.get_nowait())
        if self._vehicle is not None:
            with suppress(queue.Empty):
                while True:
                    self.service.publish("vehicle", self._vehicle.truths.get_nowait())
            self.service.counters["vehicle_stops"] = self._vehicle.stops
        self.service.counters["pings_late"] = self._sonar.pings_late
        self.service.counters["sonar_bytes_lost"] = self._line.lost_bytes

    def problems(self) -> list[str]:
        """Say which device has failed."""
        return [device.failure for device in self._devices if device.failure]

    def stop(self) -> None:
        """End the devices and take the lines away."""
        for device in self._devices:
            device.stop()
        for close in self._closing:
            close()
        self._line.unplug()
        if self._hub is not None:
            self._hub.close()
