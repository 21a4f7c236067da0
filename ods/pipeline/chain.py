"""The chain of stages: one ping in, its detections out."""

import math
from itertools import starmap
from typing import Any, NamedTuple

import numpy as np

from ods.base.arrays import SAMPLE_DTYPES, AnyArray
from ods.compiled import native
from ods.messages import MOST_HEARING_DB, Detection, Detections, Ping, Pose, frame_of
from ods.pipeline.image.missing.no_data import samples_without_data
from ods.pipeline.image.samples.amplitude import SampleScale
from ods.pipeline.image.samples.recorded import Frame, RegionNumbers, unmark_regions
from ods.pipeline.interference.deaf_beams import BeamJudge
from ods.pipeline.interference.pulses import PulseFinder
from ods.pipeline.interference.second_way import MultipathDetector
from ods.pipeline.measure.echoes import ROW, EchoTable, joined
from ods.pipeline.prepared.plan import PingError, Plan, are_alike, geometry_key, make_plan, sample_scale_of
from ods.pipeline.prepared.prepared_chain import PreparedChain
from ods.pipeline.prepared.speckle import LEARNT_CELLS, KeepAlive
from ods.pipeline.range_image.detector import detect_ranges
from ods.pipeline.settings import PipelineSettings
from ods.pipeline.sight import BlindnessMonitor, Unseen, nothing_sent, with_parts
from ods.pipeline.stage.configured import ConfiguredStage, configured_stages
from ods.pipeline.stage.params import STAGES
from ods.pipeline.stage.step import PingContext
from ods.pipeline.stage.watch import Watch
from ods.pose.buffer import PoseEstimate

STABLE_PINGS = 10
"""After a geometry that lasted for fewer pings the next one is not taken to last, either:"""
LEARNING_FACTOR = 10
"""Factor by which detectors learn from fewer cells until then."""
KEPT_GEOMETRIES = 2
"""That stages stay prepared for: a sonar may change between two."""


class Chain:
    """Turns pings into detections by the configured stages. Keeps buffers and prepared stages for the geometry of the
    last ping, so that a stream of like pings costs no more than the work on their samples."""

    def __init__(
        self,
        settings: PipelineSettings,
        *,
        learnt_cells: int = LEARNT_CELLS,
        watch: Watch | None = None,
        alive: KeepAlive | None = None,
    ) -> None:
        """Find the stages and check their parameters. Raises PluginError, StageError.

        learnt_cells: of speckle, from which detectors learn, at the first ping of a geometry, what rate a level has.
        watch: is shown what each stage makes of each ping; that costs time. alive: is called while detectors learn.
        """
        STAGES.load(settings.plugins)
        self._settings = settings
        self._learnt_cells = learnt_cells
        self._watch = watch
        self._alive = alive
        self.over_pings = any(entry.stage.kind == "ping" for entry in configured_stages(settings))
        """A stage compares pings, so the pose is of use."""
        self.geometry_changes = 0
        """Since the first ping, to one that is not alike."""
        self.was_prepared = False
        """For the last ping, as its geometry was new: detectors may have learned from images, which takes long."""
        self._geometry: tuple[Any, ...] = ()
        self._lasted = STABLE_PINGS
        self._sampling: tuple[Any, ...] = ()
        self._scale: SampleScale
        self._plan: Plan
        self._kept: list[_Prepared] = []
        """The one in use first."""
        self._phase = 0
        self._sight = BlindnessMonitor()
        self._beams = BeamJudge()
        self._pulses = PulseFinder()
        self._second_ways = MultipathDetector()

    def process(
        self, ping: Ping, mask: RegionNumbers | None = None, pose: Pose | PoseEstimate | None = None
    ) -> Detections:
        """Return the detections of one ping; mark their cells in `mask`, (beams, samples) of zeros, when given.

        pose: where the sonar's head was at `ping.t_ns`, for the stages that compare pings and for range images.

        Raises PingError for an invalid ping, StageError for a stage that fails.
        """
        if ping.sweep is not None:
            raise PingError("single beams of a mechanically scanned sonar are not images: `ods track` joins them")
        frame = _checked_frame(ping)
        if ping.range_grid is not None:
            return detect_ranges(ping, frame, self._settings, pose, mask)
        self._prepare(ping)
        first = self._plan.first
        usable = native.shows_something(frame, first)  # else a drop-out: all samples are alike
        phase = self._phase % len(self._plan.processed_ranges_m)
        if usable:
            seen = self._look(ping, frame, phase, PingContext(ping.t_ns, pose), mask)
            self._phase += 1
        else:
            seen = _PingResult([], [], nothing_sent(ping, frame, first, self._scale.top), None, [])
        return Detections(
            seq=ping.seq,
            ping_number=ping.ping_number,
            t_ns=ping.t_ns,
            t_rx_ns=ping.t_rx_ns,
            utc_ns=ping.utc_ns,
            sound_speed=ping.sound_speed,
            sector=self._plan.sector,
            detections=seen.detections,
            usable=usable,
            processed_ranges_m=self._plan.processed_ranges_m[phase],
            unseen=seen.unseen.parts,
            unseen_share=seen.unseen.share,
            unseen_why=seen.unseen.why,
            faint=seen.faint,
            second_ways_m=seen.second_ways_m,
            heard_from_db=seen.heard_from_db,
        )

    def _look(
        self, ping: Ping, frame: AnyArray, phase: int, context: PingContext, mask: RegionNumbers | None
    ) -> "_PingResult":
        first = self._plan.first
        _check_gaps(ping)
        missing = samples_without_data(ping, frame, first, self._scale.top)
        whole = Frame(frame, self._scale, missing, ping.seq % 2**32)
        deaf = self._beams.judge(ping, whole, first)
        whole = whole._replace(missing=deaf.missing)
        unseen = self._sight.judge(ping, whole, first, deaf)
        found: list[EchoTable] = []
        faint: list[EchoTable] = []
        heard_from: list[float] = []
        count = 0
        for prepared in self._kept[0].images:
            if prepared.phase in (None, phase):
                more = prepared.detect(whole, context, mask, count)
                found.append(more.echoes)
                faint.append(more.faint)
                count += len(more.echoes)
                heard_from += [] if more.heard_from is None else [more.heard_from]
        echoes, weak = joined(found), joined(faint)
        pulses = self._pulses.classify(ping, frame, echoes, weak)
        if pulses.why:
            echoes, weak = echoes[~pulses.of_echoes], weak[~pulses.of_faint]
            unseen = with_parts(unseen, pulses.parts, pulses.why, self._plan.sector)
            if mask is not None:
                unmark_regions(mask, pulses.of_echoes)
        from_db = _heard_from_db(heard_from)
        ways_m = self._second_ways.of(ping, self._scale.db_a_count, echoes, weak, from_db or 0.0)
        return _PingResult(_detections(echoes), _detections(weak), unseen, from_db, ways_m)

    def _prepare(self, ping: Ping) -> None:
        sampling = (ping.dtype, ping.scale, ping.scale_factor)
        if sampling != self._sampling:
            self._scale = sample_scale_of(ping)
            self._sampling = sampling
        geometry = geometry_key(ping)
        self.was_prepared = False
        if geometry != self._geometry:
            plan = make_plan(ping, self._settings, over_pings=self.over_pings)
            self._change_to(plan)
            self._geometry, self._plan = geometry, plan  # all or, when one fails, none
        if self._kept[0].hurried and self._lasted >= STABLE_PINGS:
            self._kept[0] = self._prepared_for(self._plan, hurried=False)
        self._lasted += 1

    def _change_to(self, plan: Plan) -> None:
        """Use the stages that are prepared for such a geometry, or prepare them. Raises StageError."""
        kept = (each for each in self._kept if are_alike(each.plan, plan, over_pings=self.over_pings))
        alike = next(kept, None)
        is_other = alike is None or alike is not self._kept[0]
        if alike is None:
            alike = self._prepared_for(plan, hurried=self._lasted < STABLE_PINGS)
        else:
            alike.move_to(plan)
        self.geometry_changes += is_other and bool(self._geometry)
        self._lasted = 0 if is_other else self._lasted
        self._kept = [alike, *(each for each in self._kept if each is not alike)][:KEPT_GEOMETRIES]

    def _prepared_for(self, plan: Plan, hurried: bool) -> "_Prepared":
        self.was_prepared = True
        cells = self._learnt_cells // LEARNING_FACTOR if hurried else self._learnt_cells
        stages = self._stages_of(plan.settings)
        images = [PreparedChain(image, stages, cells, self._watch, self._alive) for image in plan.images]
        return _Prepared(plan, images, hurried and any(each.learns for each in images))

    def _stages_of(self, settings: PipelineSettings) -> list[ConfiguredStage]:
        """Return the stages of settings that have all numbers."""
        return configured_stages(settings)


class _Prepared(NamedTuple):
    """The stages for geometries that are alike."""

    plan: Plan
    """The one for which they were prepared."""
    images: list[PreparedChain]
    hurried: bool
    """They learnt from few cells."""

    def move_to(self, plan: Plan) -> None:
        """Continue with a similar geometry."""
        for image, layout in zip(self.images, plan.images, strict=True):
            image.move_to(layout)


class _PingResult(NamedTuple):
    """Results of a ping."""

    detections: list[Detection]
    faint: list[Detection]
    unseen: Unseen
    heard_from_db: float | None
    second_ways_m: list[float]


def _detections(echoes: EchoTable) -> list[Detection]:
    return [*starmap(Detection, ROW.iter_unpack(echoes.tobytes()))]


def _heard_from_db(heard_from: list[float]) -> float | None:
    """Return `Found.heard_from` of all images as reported: levels set in absolute numbers may be anywhere."""
    highest = max(heard_from, default=0.0)
    return min(max(20.0 * math.log10(highest), 0.0), MOST_HEARING_DB) if highest > 0.0 else None


def _checked_frame(ping: Ping) -> AnyArray:
    try:
        frame = frame_of(ping)
    except ValueError as error:
        raise PingError(str(error)) from error
    if frame.dtype == SAMPLE_DTYPES["f4"] and not np.isfinite(frame).all():
        raise PingError("samples are not finite")
    return frame


def _check_gaps(ping: Ping) -> None:
    for beam, begin, stop in ping.no_data:
        if not (0 <= beam < ping.beams and 0 <= begin < stop <= ping.samples):
            raise PingError(f"no_data: there are no samples {begin} to {stop} of beam {beam}")
