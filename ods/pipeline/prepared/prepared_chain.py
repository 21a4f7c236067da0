"""The chain of stages prepared for one image: a plane of beams, or some of its ranges."""

from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Image
from ods.compiled import native
from ods.messages import Pose
from ods.pipeline.fronts.judge import LEAST_FRONT, LeadingEdgeJudge
from ods.pipeline.image.gained_image import DoubleBuffer
from ods.pipeline.image.image_layout import ImageLayout, RangeBand
from ods.pipeline.image.regions import Regions, select_regions, shared_at
from ods.pipeline.image.samples.amplitude import SampleScale
from ods.pipeline.image.samples.recorded import Frame, Recorded, RegionNumbers, mark_region
from ods.pipeline.measure.echoes import EchoTable, Wanted, joined, split_faint
from ods.pipeline.measure.pieces import measure_pieces
from ods.pipeline.prepared.filter_chain import FilterChain
from ods.pipeline.prepared.frame_reader import FrameReader
from ods.pipeline.prepared.speckle import KeepAlive, filtered_speckle
from ods.pipeline.stage.configured import ConfiguredStage, error_of
from ods.pipeline.stage.params import NotANumberError, StageError
from ods.pipeline.stage.step import PingContext, PreparedDetector
from ods.pipeline.stage.watch import StageImage, Watch
from ods.pose.buffer import PoseEstimate


class Found(NamedTuple):
    """The echoes of an image."""

    echoes: EchoTable
    faint: EchoTable
    """Too weak for the false-alarm rate wanted."""
    heard_from: float | None
    """As in `Regions`."""


class PreparedChain:
    """Frame to image, image through the filters, regions in it, echoes of the regions."""

    def __init__(
        self,
        layout: ImageLayout,
        stages: Sequence[ConfiguredStage],
        learnt_cells: int,
        watch: Watch | None,
        alive: KeepAlive | None,
    ) -> None:
        """Prepare the stages, of which the last one detects. watch: is shown what each makes. Raises StageError."""
        *filters, last = stages
        fan, buffers = layout.fan, DoubleBuffer(layout.fan.shape)
        self.phase = layout.phase
        self._layout = layout
        self._reader = FrameReader(layout, buffers)
        self._fronts = LeadingEdgeJudge(layout)
        self._last = last
        self._watch = watch
        self._detector: PreparedDetector = last.prepared(fan)
        self.learns = self._detector.learn is not None
        """The detector had to see speckle first, which takes long."""
        if self._detector.learn:
            unwatched = FilterChain(filters, fan, buffers)
            self._detector.learn(filtered_speckle(unwatched, layout.stride, learnt_cells, alive))
        self._new_filters = partial(FilterChain, filters, fan, buffers, watch)
        self._filters = self._new_filters()

    def move_to(self, layout: ImageLayout) -> None:
        """Go on with images of the same columns whose ranges differ a little: echoes are where the layout says."""
        self._layout = layout
        self._fronts = LeadingEdgeJudge(layout)

    def detect(self, frame: Frame, ping: PingContext, mask: RegionNumbers | None, before: int) -> Found:
        """Return the detections of these rows and ranges of the frame, and number them in `mask`, from `before` + 1 on.

        mask: (all beams, all samples); faint echoes have no numbers. Raises StageError.
        """
        layout = self._layout
        read, recorded, gaps = self._reader.read(frame)
        image = self._filters.run(read, ping)
        if gaps.size:
            native.blank_gaps(image, gaps)
        if layout.fan.seam is not None:
            image[:, layout.fan.seam] = 0.0  # no data: nothing reaches across
        rows = None if mask is None else mask[layout.rows]
        try:
            regions = self._regions(image, recorded)
            found, faint = self._echoes(image, regions, recorded, frame.scale, ping.pose, rows, before)
        except NotANumberError as error:
            raise self._culprit(frame, ping) from error
        return Found(found, faint, regions.heard_from)

    def _echoes(
        self,
        image: Image,
        regions: Regions,
        recorded: Recorded,
        scale: SampleScale,
        head: Pose | PoseEstimate | None,
        mask: RegionNumbers | None,
        before: int,
    ) -> tuple[EchoTable, EchoTable]:
        """Return the echoes of regions, and the faint ones. Raises NotANumberError.

        head: the sonar's, None: not known. mask: (beams of the image, all samples), in which those that are not faint
        are numbered from `before` + 1 on.
        """
        found: list[EchoTable] = []
        faint: list[EchoTable] = []
        is_judged = regions.fronts and regions.faint is not None and bool(regions.faint.any())
        least_front = LEAST_FRONT if is_judged else -1.0
        for band, inside in _by_band(regions, self._layout.bands):
            pieces, echoes = measure_pieces(image, inside, recorded, band.fan, head)
            if is_judged:
                echoes["front"] = self._fronts.of(echoes["bearing_rad"], echoes["near_m"], recorded.samples, scale)
            strong, weak = split_faint(echoes, pieces.faint, Wanted(band.from_m, band.to_m, least_front))
            if mask is not None:
                mark_region(_strong(pieces, echoes, band), before, recorded, mask)
            found.append(strong)
            faint.append(weak)
            before += len(strong)
        return joined(found), joined(faint)

    def _regions(self, image: Image, recorded: Recorded) -> Regions:
        """Raises NotANumberError, and StageError for what else goes wrong."""
        if not self._detector.refuses_nan and not np.isfinite(image).all():
            raise NotANumberError
        try:
            regions = self._detector.find(image, recorded)
        except NotANumberError:
            raise
        except Exception as error:
            raise error_of(self._last.label, error) from error
        if self._watch and regions.judged:
            judged, low, high = regions.judged
            self._watch(StageImage(self._last.name, judged().copy(), self._layout.fan, (low, high)))
        return regions

    def _culprit(self, frame: Frame, ping: PingContext) -> StageError:
        """Return the complaint about the stage whose image is not finite; all forget what they remember of images."""
        filters, self._filters = self._filters, self._new_filters()
        try:
            filters.run(self._reader.read(frame).image, ping, check=True)
        except StageError as error:
            return error
        return error_of(self._last.label, NotANumberError())


def _strong(regions: Regions, echoes: EchoTable, band: RangeBand) -> Regions:
    """Return the regions of a band whose echoes count and are not faint."""
    strong = (echoes["range_m"] >= band.from_m) & (echoes["range_m"] < band.to_m)
    return select_regions(regions, strong if regions.faint is None else strong & ~regions.faint)


def _by_band(regions: Regions, bands: list[RangeBand]) -> list[tuple[RangeBand, Regions]]:
    """Return the regions in the columns of each band that has any."""
    if len(bands) == 1 or not regions.total:
        return [(band, regions) for band in bands[: regions.total]]
    shares = shared_at(regions, bands[1].columns.start)
    return [(band, share) for band, share in zip(bands, shares, strict=True) if share.total]
