"""The `pipeline` process: detections for every ping."""

from typing import Any

from ods.base import clock
from ods.base.plugins import PluginError
from ods.messages import Ping
from ods.pipeline.prepared.plan import PingError
from ods.pipeline.processor import PingProcessor
from ods.pipeline.settings import PipelineConfig
from ods.pipeline.stage.params import StageError
from ods.pipeline.warm_up import warm_up
from ods.runtime import bus
from ods.runtime.backlog import Backlog
from ods.runtime.service import Service, StartError, Worker, notify_watchdog

FAILURE_SAID_NS = clock.NS
"""Time for which a failure of a stage stays a problem, so that one that fails repeatedly is reported without gaps."""
LONGEST_WORK_NS = bus.TOPICS["detections"].stale_s / 2 * clock.NS
"""Processing time, ns, from which on a ping that had to wait is stale before it is tracked."""


class PipelineWorker(Worker[PipelineConfig]):
    """Publishes `detections` for each `ping`; reads `pose` to cut walls into pieces that stay, and for the stages
    that compare pings.

    A chain that is too slow for every ping gets the newest each time. Counters: skipped_pings (the others), bad_ping,
    failed_stage, drop_out_image, unseen_images, detections, process_mean_us, process_max_us, those of the pose buffer
    and, where a stage compares pings, pings_without_pose; what a lagging subscription drops is counted there
    (dropped_ping).
    """

    def __init__(self, service: Service, settings: PipelineConfig) -> None:
        super().__init__(service, settings)
        self._processor: PingProcessor
        self._backlog: Backlog[Ping] = Backlog()
        self._failure, self._failed_ns = "", 0
        self._dropped, self._worked_ns = "", 0
        """Why the newest ping was dropped, "" when it was not, and when one was not."""
        self._was_prepared = False

    def start(self) -> None:
        """Build the chain and try it."""
        try:
            self._processor = PingProcessor(self.settings, self.service.counters, notify_watchdog)
            warm_up(self.settings.pipeline)
        except (PluginError, StageError) as error:
            raise StartError(str(error)) from error

    def handle(self, topic: str, message: Any) -> None:
        """Take one message; pings wait for the end of the round, when all poses are in."""
        if topic == "ping":
            self._backlog.add(message, message.seq, message.t_ns)
        else:
            self._processor.add_pose(message)

    def tick(self) -> None:
        """Process the pings that came, or the newest if that is all there is time for."""
        pings, skipped = self._backlog.take()
        for _ in range(skipped):
            why = self.service.overload() or self._backlog.slowness()
            self.service.log_once("skipped_pings", f"{why}: some are skipped")
        for ping in pings:
            self._process(ping)

    def _process(self, message: Ping) -> None:
        began = clock.monotonic_ns()
        try:
            result = self._processor.process(message)
        except PingError as error:
            self._dropped = f"dropped ping {message.ping_number}: {error}"
            self.service.log_once("bad_ping", self._dropped)
            return
        except StageError as error:
            self._failure, self._failed_ns = str(error), began
            self.service.log_once("failed_stage", f"ping {message.ping_number}: {error}")
            return
        self.service.publish("detections", result)
        self._dropped, self._worked_ns = "", began
        self._failure = self._failure if began - self._failed_ns < FAILURE_SAID_NS else ""
        self.service.counters["geometry_changes"] = self._processor.chain.geometry_changes
        self.service.counters["unseen_images"] += result.unseen_share > 0.0
        self.service.counters["detections"] += len(result.detections)
        self.service.counters["drop_out_image"] += not result.usable
        self._keep_time(clock.monotonic_ns() - began)

    def _keep_time(self, spent_ns: int) -> None:
        prepared, self._was_prepared = self._was_prepared, self._processor.chain.was_prepared
        if prepared or not self._was_prepared:  # the first ping of a geometry shows nothing of those that follow
            self._backlog.worked(spent_ns)
        counters = self.service.counters
        counters["process_mean_us"] = round(self._backlog.work_ns / 1000)
        counters["process_max_us"] = max(counters["process_max_us"], round(spent_ns / 1000))

    def problems(self) -> list[str]:
        """Return the problems: a stage that fails, no usable ping, or a chain that is too slow."""
        problems = [self._failure] if self._failure else []
        if self._dropped and clock.monotonic_ns() - self._worked_ns > bus.TOPICS["detections"].stale_s * clock.NS:
            problems.append(self._dropped)
        if self._backlog.work_ns > LONGEST_WORK_NS:
            problems.append(self._backlog.slowness())
        return problems
