"""Figures of merit of detections and of filtered images. Pure."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.stats import bootstrap

from ods.assess.images.labelled import Target
from ods.base.arrays import Image, Ints, Mask
from ods.messages import Detection

RESAMPLES = 500
"""Draws of a bootstrap."""
CONFIDENCE = 0.95
"""Of its intervals."""


@dataclass
class Score:
    """Counts of correct and false detections on labelled images; summed by `count_image`."""

    images: int = 0
    targets: int = 0
    found: int = 0
    false_alarms: int = 0
    position_error_m: list[float] = field(default_factory=list)
    """Distance of centre to true centre, of each found body whose circle is known."""
    radius_error: list[float] = field(default_factory=list)
    """Relative error of its radius."""
    by_image: list[tuple[int, int, int]] = field(default_factory=list)
    """Targets, found, false alarms of each image."""

    @property
    def detection_probability(self) -> float:
        """Share of the targets that were found; 0 without targets."""
        return self.found / max(1, self.targets)

    @property
    def false_per_image(self) -> float:
        """Detections an image that lie in no target's box; 0 without images."""
        return self.false_alarms / max(1, self.images)

    def count_image(self, detections: Sequence[Detection], targets: Sequence[Target]) -> None:
        """Add one image. A target is found when a detection's centre lies in its box, the nearest one is measured;
        more detections in a box are neither found targets nor false alarms."""
        false = sum(not any(t.holds(d) for t in targets) for d in detections)
        counted = [target for target in targets if target.counts]
        found = 0
        for target in counted:
            inside = [d for d in detections if target.holds(d)]
            found += bool(inside)
            if inside and target.circle is not None:
                self._measure(inside, target.circle)
        self.images += 1
        self.targets += len(counted)
        self.found += found
        self.false_alarms += false
        self.by_image.append((len(counted), found, false))

    def _measure(self, inside: Sequence[Detection], circle: tuple[float, float, float]) -> None:
        distance, bearing, radius = circle
        errors = [_distance(d.range_m, d.bearing_rad, distance, bearing) for d in inside]
        nearest = int(np.argmin(errors))
        self.position_error_m.append(errors[nearest])
        self.radius_error.append(inside[nearest].radius_m / radius - 1.0)


def _distance(range_a: float, bearing_a: float, range_b: float, bearing_b: float) -> float:
    """Return the distance of two places in the sonar's plane, by the law of cosines without cancellation."""
    half = np.sin(0.5 * (bearing_a - bearing_b))
    return float(np.sqrt((range_a - range_b) ** 2 + 4.0 * range_a * range_b * half**2))


def at_false_alarms(scores: Sequence[Score], wanted: float) -> float:
    """Return the detection probability at `wanted` false alarms an image, from scores of a swept threshold.

    Interpolated over the logarithm of the false alarms; beyond the sweep's ends 0 on the side of fewer false alarms, as
    the threshold is never that high, and the last value on the side of more.
    """
    best: dict[float, float] = {}
    for score in scores:
        rate = max(score.false_per_image, 0.5 / max(1, score.images))
        best[rate] = max(best.get(rate, 0.0), score.detection_probability)
    rates = sorted(best)
    if not rates or wanted < rates[0]:
        return 0.0
    return float(np.interp(np.log(wanted), np.log(rates), np.maximum.accumulate([best[rate] for rate in rates])))


def interval_at_false_alarms(scores: Sequence[Score], wanted: float) -> tuple[float, float]:
    """Return the CONFIDENCE interval of `at_false_alarms` by bootstrap over the images, the same ones at each step.

    nan where there are fewer than two images.
    """
    images = scores[0].images if scores else 0
    if images < 2:
        return float("nan"), float("nan")
    counts = np.array([score.by_image for score in scores])  # (steps, images, 3)

    def probability(drawn: Ints) -> float:
        totals = counts[:, drawn].sum(axis=1).tolist()
        return at_false_alarms([Score(images, targets, found, false) for targets, found, false in totals], wanted)

    interval = bootstrap(
        (np.arange(images),), probability, vectorized=False, method="percentile", n_resamples=RESAMPLES,
        confidence_level=CONFIDENCE, rng=np.random.default_rng(0),
    ).confidence_interval  # fmt: skip
    return float(interval.low), float(interval.high)


def nearest_score(scores: Sequence[Score], wanted: float) -> int:
    """Return the index of the score whose false alarms an image are nearest to `wanted`, by their ratio."""
    rates = np.array([max(score.false_per_image, 0.5 / max(1, score.images)) for score in scores])
    return int(np.argmin(np.abs(np.log(rates / wanted))))


def noise_suppression_db(before: Image, after: Image, quiet: Mask) -> float:
    """Return how far filters lower the fluctuation (standard deviation over mean) where no object is.

    before, after: (beams, samples); quiet: the cells that show background alone.
    """
    return float(20.0 * np.log10(_fluctuation(before[quiet]) / max(_fluctuation(after[quiet]), 1e-9)))


def _fluctuation(cells: Image) -> float:
    return float(cells.std() / max(float(cells.mean()), 1e-9))


def edge_preservation(before: Image, after: Image) -> float:
    """Return the correlation of the range differences of two images, 1 for edges that stay as they are.

    That is the edge preservation index of F. Sattar et al. (IEEE Trans. Image Processing 6(6), 1997), with differences
    along the beam in place of the Laplacian; before: the image without speckle; 0 where one of them has no edge.
    """
    a, b = (np.diff(image.astype(np.float64), axis=1) for image in (before, after))
    a, b = a - a.mean(), b - b.mean()
    power = float((a**2).sum() * (b**2).sum())
    return float((a * b).sum() / np.sqrt(power)) if power > 0.0 else 0.0


def pareto_front(ms: Sequence[float], accuracy: Sequence[float]) -> list[int]:
    """Return the indices, fastest first, of the points that no other one beats in both time and accuracy."""
    front: list[int] = []
    for index in sorted(range(len(ms)), key=lambda i: (ms[i], -accuracy[i])):
        if not front or accuracy[index] > accuracy[front[-1]]:
            front.append(index)
    return front
