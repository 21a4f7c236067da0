"""One ping through a chain: what each stage makes of it, what it costs, what is found."""

import itertools
import statistics
import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import msgspec
import numpy as np

from ods.base.arrays import Floats, Image, Mask
from ods.base.errors import OdsError
from ods.base.frames.mounting import Mounting
from ods.messages import Detections, Ping
from ods.offline.mission import MissionSettings
from ods.pipeline.chain import Chain
from ods.pipeline.image.fan import Fan
from ods.pipeline.prepared.plan import PingError, geometry_key, make_plan
from ods.pipeline.settings import PipelineSettings
from ods.pipeline.stage.configured import ConfiguredStage
from ods.pipeline.stage.step import PreparedDetector
from ods.pipeline.stage.watch import RECORDED, StageImage
from ods.plots.polar import level_db
from ods.pose.buffer import PoseBuffer, PoseEstimate
from ods.pose.head import head_of
from ods.workbench.engine.data import Data
from ods.workbench.engine.ping.look import Coded, Codes, Grid, Look, coded, grid_of, looks_of, of_stage

FORMER_PINGS = 16
"""That go through a chain that compares pings before the one that is looked at."""
KEPT_CHAINS = 4
"""Largest number of prepared chains kept for a geometry, so that returning to one needs no learning. Shown ones are
kept."""
KEPT_CELLS = 1_000_000
"""Largest number of cells of all kept chains: at 512 x 2000 samples each takes 14 MB."""
KEPT_LEARNT = 64
"""Sets of filters and geometry behind which it is remembered what detectors learnt."""
MOST_RUNS, LONGEST_RUNS_NS = 5, 10_000_000
"""Most runs whose time is measured; fewer where they take long."""
PATIENCE_S = 0.3
"""Time for which a detector learns, s, whatever else is requested: a moving slider shows images, too."""
POSES_BEFORE = 64
"""Fields of a ping that hold its pose."""


class AnalysisError(OdsError):
    """A ping cannot be looked at; the text is one line."""


class OvertakenError(AnalysisError):
    """Learning lasted, and something else is wanted by now."""

    def __init__(self) -> None:
        super().__init__("given up: a newer request has come")


Learnt = dict[int, Floats]
"""What a detector learnt, by the number of its plane and ring."""


class Cost(NamedTuple):
    """How long one ping takes, us: medians of a few runs."""

    stages: tuple[tuple[str, float], ...]
    """Name and time of each, in order."""
    whole: float
    """With reading the samples and measuring the echoes, which belong to no stage."""
    prepared: float
    """Once, when the geometry or a setting changes: detectors learn what noise is like."""

    @property
    def rest(self) -> float:
        """Reading and measuring."""
        return max(0.0, self.whole - sum(time_us for _, time_us in self.stages))


@dataclass(frozen=True, eq=False)
class PingAnalysis:
    """What came of one ping."""

    place: int
    ping: Ping
    grid: Grid
    looks: tuple[Look, ...]
    """As recorded, then after each stage that runs. The last one is what the detector compared with its levels."""
    detections: Detections

    @cached_property
    def attended(self) -> Mask:
        """(beams, samples) what this ping was looked at for."""
        return self.looks[-1].processed

    def after(self, place: int, bypassed: tuple[int, ...]) -> Look:
        """Return the image after a place of the whole chain, of which some do not run; -1: as recorded."""
        return self.looks[min(sum(at not in bypassed for at in range(place + 1)), len(self.looks) - 1)]


class PingAnalyzer:
    """Looks at pings of one source of data. May be used from several threads, which wait for each other."""

    def __init__(self, data: Data, overtaken: Callable[[], bool] = lambda: False) -> None:
        """overtaken: whether something newer is asked for, so that long learning is given up."""
        self._data = data
        self._overtaken = overtaken
        self._kept: OrderedDict[Any, _Prepared] = OrderedDict()
        self._learnt: OrderedDict[bytes, Learnt] = OrderedDict()
        self._recorded: tuple[Ping, Codes] | None = None
        """The last ping's amplitudes."""
        self._lock = threading.Lock()

    def analyze(self, settings: MissionSettings, place: int, shown: int = 1) -> PingAnalysis:
        """Return what the pipeline of `settings` makes of a ping. Raises OvertakenError; OdsError, one line.

        shown: how many pipelines take turns at being looked at.
        """
        if not 0 <= place < len(self._data.pings):
            raise AnalysisError(f"ping {place}: there are {len(self._data.pings)}")
        with self._lock:
            try:
                return self._analyze(settings, place, shown)
            except PingError as error:
                raise AnalysisError(f"ping {place}: {error}") from error

    def cost(self, settings: MissionSettings, place: int, give_up: Callable[[], bool]) -> Cost | None:
        """Return what the ping costs that was looked at last, by a few more runs; none: given up."""
        with self._lock:
            ping = self._data.pings[place]
            prepared = self._kept.get(_key(settings.pipeline, ping))
            if prepared is None or prepared.at != place:
                return None
            if not prepared.chain.over_pings:  # the others remember, and must not see it again
                prepared.run_again(ping, place, give_up)
            return None if give_up() else prepared.cost()

    def _analyze(self, settings: MissionSettings, place: int, shown: int) -> PingAnalysis:
        ping = self._data.pings[place]
        prepared = self._prepared(settings.pipeline, ping, place, shown)
        if prepared.chain.over_pings and self._data.timed and prepared.at != place - 1:
            for former in range(max(0, place - FORMER_PINGS), place):
                prepared.run(self._data.pings[former], former, self._pose_of(former, settings))
        pose = self._pose_of(place, settings) if prepared.chain.over_pings else None
        tap = prepared.tap
        try:
            with tap:
                detections = prepared.run(ping, place, pose)
        except OvertakenError:
            self._kept.popitem()  # it has not learnt; it was the last one asked for
            raise
        grid = grid_of(ping)
        looks = looks_of(grid, tap.taken(), [RECORDED, *(stage["use"] for stage in settings.pipeline.chain())])
        looks[0] = replace(looks[0], codes=self._whole(looks[0], ping))
        return PingAnalysis(place, ping, grid, tuple(looks), detections)

    def _prepared(self, settings: PipelineSettings, ping: Ping, place: int, shown: int) -> "_Prepared":
        """Return the chain for these settings and this geometry; one that compares pings if it saw the last one."""
        key = _key(settings, ping)
        kept = self._kept.get(key)
        if kept is None or (kept.chain.over_pings and kept.at != place - 1):
            kept = None
            self._make_room(key, max(shown, min(KEPT_CHAINS, KEPT_CELLS // (ping.beams * ping.samples))))
            kept = self._kept[key] = _Prepared(settings, self._learnt_behind(settings, ping), self._overtaken)
        self._kept.move_to_end(key)
        return kept

    def _make_room(self, key: bytes, most: int) -> None:
        """Give up chains, those longest not looked at, until there are fewer than `most`."""
        self._kept.pop(key, None)
        while len(self._kept) >= most:
            self._kept.popitem(last=False)

    def _learnt_behind(self, settings: PipelineSettings, ping: Ping) -> Learnt:
        """Return what is known of the detector behind these filters, at this geometry. Raises PingError."""
        numbers = make_plan(ping, settings).settings
        *filters, last = numbers.stage
        key = _key(msgspec.structs.replace(numbers, stage=tuple(filters)), ping) + str(last["use"]).encode()
        learnt = self._learnt.setdefault(key, {})
        self._learnt.move_to_end(key)
        while len(self._learnt) > KEPT_LEARNT:
            self._learnt.popitem(last=False)
        return learnt

    def _whole(self, recorded: Look, ping: Ping) -> Codes:
        """Return the recorded image with the ranges that were not processed, too."""
        processed = recorded.processed
        if processed.all():
            return recorded.codes
        if self._recorded is None or self._recorded[0] is not ping:
            levels = level_db(ping).reshape(ping.planes, *processed.shape).max(axis=0)
            self._recorded = ping, coded(np.power(np.float32(10.0), levels / np.float32(20.0)))
        return np.where(processed, recorded.codes, self._recorded[1])

    def _pose_of(self, place: int, settings: MissionSettings) -> PoseEstimate | None:
        """Return where the sonar's head was at a ping, as far as poses are known."""
        t_ns = self._data.pings[place].t_ns
        buffer = PoseBuffer(*msgspec.structs.astuple(settings.pose))
        for pose in self._data.poses_about(t_ns, POSES_BEFORE):
            buffer.insert(pose)
        return head_of(buffer.at(t_ns), Mounting(settings.mounting))


def _key(settings: PipelineSettings, ping: Ping) -> bytes:
    """Return what a chain is prepared for."""
    return msgspec.msgpack.encode((settings, geometry_key(ping)), enc_hook=str)


class _StageTap:
    """Takes what stages make, while it is entered; otherwise it is false, so that nothing is copied for it."""

    def __init__(self) -> None:
        self._shown: list[Coded] = []
        self._looks = False

    def __call__(self, image: StageImage) -> None:
        self._shown.append(of_stage(image))

    def taken(self) -> list[Coded]:
        """Return what it took, and keep none of it."""
        taken, self._shown = self._shown, []
        return taken

    def __bool__(self) -> bool:
        return self._looks

    def __enter__(self) -> None:
        self._shown, self._looks = [], True

    def __exit__(self, *_: object) -> None:
        self._looks = False


class _TimedChain(Chain):
    """A chain that measures how long each stage took with the last ping."""

    def __init__(
        self, settings: PipelineSettings, tap: _StageTap, learnt: Learnt, overtaken: Callable[[], bool]
    ) -> None:
        super().__init__(settings, watch=tap)
        self.spent_ns = [0] * len(settings.chain())
        self._learnt, self._overtaken = learnt, overtaken

    def take_turn(self, turn: int) -> None:
        """Go on with the part of the range whose turn it is at that ping, where attention parts it."""
        self._phase = turn

    def _stages_of(self, settings: PipelineSettings) -> list[ConfiguredStage]:
        stages = super()._stages_of(settings)
        *filters, last = (_timed(stage, self.spent_ns, at) for at, stage in enumerate(stages))
        return [*filters, _learning_once(last, self._learnt, self._overtaken)]


def _timed(stage: ConfiguredStage, spent_ns: list[int], at: int) -> ConfiguredStage:
    def prepare(params: Any, fan: Fan) -> Any:
        made = stage.stage.prepare(params, fan)
        if isinstance(made, PreparedDetector):
            return made._replace(find=clocked(made.find))
        return clocked(made)

    def clocked(step: Callable[..., Any]) -> Callable[..., Any]:
        def run(*args: Any) -> Any:
            began = time.perf_counter_ns()
            made = step(*args)
            spent_ns[at] += time.perf_counter_ns() - began
            return made

        return run

    return stage._replace(stage=replace(stage.stage, prepare=prepare))


def _learning_once(stage: ConfiguredStage, learnt: Learnt, overtaken: Callable[[], bool]) -> ConfiguredStage:
    """Return a detector that takes what one of its kind has learnt there: another setting of it costs no filtering of
    speckle. Where it has to learn it gives up if that lasts and is overtaken."""
    prepared = itertools.count()

    def prepare(params: Any, fan: Fan) -> PreparedDetector:
        made: PreparedDetector = stage.stage.prepare(params, fan)
        learn, place = made.learn, next(prepared)
        if learn is None:
            return made

        def learn_once(kinds: Iterable[Iterable[Image]]) -> None:
            if made.learnt is not None and place in learnt:
                made.learnt[:] = learnt[place]
                return
            learn(_while_wanted(kinds, overtaken))
            if made.learnt is not None:
                learnt[place] = made.learnt

        return made._replace(learn=learn_once)

    return stage._replace(stage=replace(stage.stage, prepare=prepare))


def _while_wanted(kinds: Iterable[Iterable[Image]], overtaken: Callable[[], bool]) -> Iterator[Iterator[Image]]:
    """Yield the same images, until that lasts and is overtaken. Raises OvertakenError."""
    ends_s = time.monotonic() + PATIENCE_S

    def watched(images: Iterable[Image]) -> Iterator[Image]:
        for image in images:
            if time.monotonic() > ends_s and overtaken():
                raise OvertakenError
            yield image

    return map(watched, kinds)


class _Prepared:
    """A chain for one geometry, and its times."""

    def __init__(self, settings: PipelineSettings, learnt: Learnt, overtaken: Callable[[], bool]) -> None:
        self.tap = _StageTap()
        self.chain = _TimedChain(settings, self.tap, learnt, overtaken)
        self.at = -1
        """Place of the last ping."""
        self._names = [str(stage["use"]) for stage in settings.chain()]
        self._prepared_ns = 0
        self._runs: list[list[int]] = []
        """Of each run the times of the stages and of the whole."""

    def run(self, ping: Ping, place: int, pose: PoseEstimate | None = None) -> Detections:
        """Let a ping through. Raises PingError, StageError."""
        self.chain.take_turn(place)
        self.chain.spent_ns[:] = [0] * len(self._names)
        began = time.perf_counter_ns()
        found = self.chain.process(ping, pose=pose)
        whole = time.perf_counter_ns() - began
        if self.chain.was_prepared:
            self._prepared_ns = whole
        else:
            self._runs = [*self._runs[1 - MOST_RUNS :], [*self.chain.spent_ns, whole]]
        self.at = place
        return found

    def run_again(self, ping: Ping, place: int, give_up: Callable[[], bool]) -> None:
        """Measure the time of a ping in a few runs without recording stages."""
        self._runs = []
        began = time.perf_counter_ns()
        while len(self._runs) < MOST_RUNS and time.perf_counter_ns() - began < LONGEST_RUNS_NS and not give_up():
            self.run(ping, place)

    def cost(self) -> Cost:
        """Return medians of the last runs."""
        runs = self._runs or [[*self.chain.spent_ns, self._prepared_ns]]
        *stages, whole = (statistics.median(times) / 1e3 for times in zip(*runs, strict=True))
        return Cost(tuple(zip(self._names, stages, strict=True)), whole, self._prepared_ns / 1e3)
