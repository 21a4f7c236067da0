"""What `ods track` makes of a run: tracks, lists, geographic data, picture, movie, scores."""

import json
from bisect import bisect_right
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import msgspec
import numpy as np
from matplotlib.figure import Figure
from rich.console import Console

from ods.base.errors import OdsError, reason_of
from ods.base.files.out_file import refuse_unwritable
from ods.base.frames.mounting import Mounting
from ods.export.geojson import Tracks
from ods.offline.mission import Step
from ods.offline.picture import View, draw_view
from ods.offline.run_record import RunRecord
from ods.offline.score import position_rms_m, score_objects
from ods.offline.score_table import objects_table
from ods.offline.source import Source
from ods.offline.tracks_file import TracksFile
from ods.plots.style import refuse_undrawable

SETTLE_S = 3.0
"""From the first sight of an object until it counts as missed, as on the bench."""
MOVIES = (".webp", ".gif")


@dataclass(frozen=True)
class Wanted:
    """Which results go where."""

    out: Path | None
    json: bool
    geojson: Path | None
    plot: Path | None
    movie: Path | None

    def check(self, *read: Path | None) -> None:
        """Refuse what cannot be written or would go over a file that is read, before the work. Raises OdsError."""
        if self.movie is not None and self.movie.suffix.lower() not in MOVIES:
            raise OdsError(f"{self.movie}: the ending must be one of {', '.join(MOVIES)}")
        refuse_unwritable(self.out, self.geojson, self.plot, self.movie, read=read)
        refuse_undrawable(self.plot)


class Outputs:
    """Takes the steps of a run, and writes what is wanted of them. Pictures are drawn inside `drawn_in`."""

    def __init__(self, wanted: Wanted, source: Source, pings: int, mounting: Mounting) -> None:
        """`pings`: how many will come. Raises OdsError."""
        self._wanted, self._source, self._mounting = wanted, source, mounting
        self._record = RunRecord()
        self._tracks = TracksFile()
        self._seen = self._detections = 0
        self._ids: set[int] = set()
        self._pose_times = [pose.t_ns for pose in source.poses]
        self._movie = None
        self._geo = None
        if wanted.geojson is not None:
            if source.frame is None:
                raise OdsError("--geojson: the file does not tell where on earth it was: --config with [site] does")
            self._geo = Tracks(source.frame)
        if wanted.movie is not None:
            from ods.track.movie import Movie

            self._movie = Movie(pings, mounting)

    def take(self, step: Step) -> None:
        """Take what came of one ping."""
        told, record = step.list, self._record
        self._tracks.add(step)
        self._ids |= {obstacle.id for obstacle in told.obstacles}
        self._detections += len(step.detections.detections)
        record.lists.append((told.made_ns, told))
        record.image = step.ping, step.detections
        if self._wanted.json:
            print(msgspec.json.encode(told).decode())
        if self._geo is not None:
            self._geo.add(told.utc_ns, told)
        if self._movie is not None and self._movie.wants(self._seen):
            self._movie.add(self._view(), told.t_ns)
        self._seen += 1

    def _view(self) -> View:
        poses, lists = self._source.poses, [item for _, item in self._record.lists]
        until = bisect_right(self._pose_times, lists[-1].t_ns) if lists else len(poses)
        path = np.array([pose.position_ned for pose in poses[:until]]).reshape(-1, 3)
        vehicle = (poses[until - 1].position_ned, poses[until - 1].attitude) if until else None
        truth = self._source.truths.get(lists[-1].ping_number) if lists else None
        return View(self._record.image, path, vehicle, () if truth is None else truth.objects, lists)

    def write(self) -> None:
        """Write the files. Raises OdsError."""
        wanted = self._wanted
        if wanted.out is not None:
            _written(wanted.out, partial(self._tracks.save, wanted.out))
        if self._geo is not None and wanted.geojson is not None:
            for pose in self._source.poses:
                self._geo.add(pose.utc_ns, pose)
            text = json.dumps(self._geo.collection(), allow_nan=False) + "\n"
            _written(wanted.geojson, partial(wanted.geojson.write_text, text, encoding="utf-8"))
        if wanted.plot is not None:
            figure = Figure(figsize=(15, 7.5), layout="constrained")
            draw_view(figure, self._view(), self._mounting)
            _written(wanted.plot, partial(figure.savefig, wanted.plot, dpi=110))
        if self._movie is not None and wanted.movie is not None:
            _written(wanted.movie, partial(self._movie.save, wanted.movie))

    def tell(self, counters: "Counter[str]") -> None:
        """Print what came of it; beside JSON lines on standard error."""
        console = Console(stderr=self._wanted.json, highlight=False)
        found = f"{self._seen} pings, {self._detections} detections, {len(self._ids)} objects"
        console.print(", ".join([found, *_losses(self._source.losses), *_losses(counters)]), soft_wrap=True)
        self._record.truths = dict(self._source.truths)
        if not self._record.truths:
            return
        scores, false_ids = score_objects(self._record, SETTLE_S)
        if scores:
            console.print(objects_table(scores))
        switches = sum(max(0, len(score.ids) - 1) for score in scores)
        error = f"position error {position_rms_m(scores):.2f} m rms, " if scores else ""
        console.print(f"{error}{len(false_ids)} false tracks, {switches} identity switches")


def _losses(counters: Mapping[str, int]) -> list[str]:
    return [f"{name} {count}" for name, count in sorted(counters.items()) if count]


def _written(file: Path, write: Callable[[], object]) -> None:
    """Write a file. Raises OdsError."""
    try:
        write()
    except (OSError, ValueError) as error:
        raise OdsError(f"{file}: {reason_of(error)}") from error
