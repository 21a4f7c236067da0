"""`benchmarks.circles.synthetic`: errors of the circles of bodies of known shape, and whether the sigmas match them.

Echoes are made here, by quadrature over the body, and by nothing of the simulator. A cell receives the sum of the
intensities
over the body's lit points, weighted with a Gaussian beam of -3 dB width 1.5 deg, plus a background of 1, under
exponential speckle, or the mean of so many images. The circle of a front is the sphere's, of a disc the disc's, of a
plate the one around it; the near edge is the body's nearest point, that of a plate its front.

The last table draws radius and range anew for each look: what an echo cannot tell, such as how much of a weak front is
unseen, is then a spread that its standard deviations have to cover, where in a row of one radius it is a bias.
"""

import argparse
from collections.abc import Iterator
from itertools import product
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Floats32
from ods.messages import Detection, Ping
from ods.pipeline.chain import Chain
from ods.pipeline.settings import PipelineSettings

BEAM_REACH = 5.0
"""Standard deviations of a beam's directivity beside its axis from which on it receives nothing: less than 4e-6."""
KINDS = ("front", "disc", "half", "plate", "point")
GATE_SIGMAS = 4.0
"""`tracker.gate_sigmas`."""
LEAST_FOUND = 10
RADII_M, RANGES_M = (0.25, 6.0), (12.0, 92.0)
"""Of bodies that are drawn; radii by their logarithms."""
RIGHT = (0.7, 1.3)
"""Mean of error^2/sigma^2 in a row whose sigmas are right."""


class Sonar(NamedTuple):
    """A fan of beams of Gaussian directivity, side by side at their -3 dB width."""

    beams: int
    samples: int
    spacing: float
    """rad."""
    dr_m: float

    @property
    def bearings(self) -> Floats:
        """Return the beams' axes, rad, (beams,)."""
        return np.asarray((np.arange(self.beams) - 0.5 * (self.beams - 1)) * self.spacing)

    @property
    def sigma(self) -> float:
        """Return the standard deviation of a beam's directivity, rad."""
        return float(self.spacing / np.sqrt(8.0 * np.log(2.0)))


SONAR = Sonar(60, 2000, float(np.radians(1.5)), 0.05)
WIDEST = 0.35
"""Bearings of bodies, rad."""


class Points(NamedTuple):
    """Lit points of a body whose centre is at the origin, (n,)."""

    ahead: Floats
    """Away from the sonar, m."""
    across: Floats
    up: Floats
    weight: Floats


def front(radius: float, cd: float = 0.3, cs: float = 0.3, roughness: float = np.radians(15.0)) -> Points:
    """Return the lit half of a sphere: gamma(alpha) of [SSIE] eqs. 3 and 4 times the surface as seen.

    Its upper half, as a beam receives both halves alike.
    """
    cosine, around = np.meshgrid((np.arange(400) + 0.5) / 400, np.pi * (np.arange(48) + 0.5) / 48, indexing="ij")
    alpha, sine = np.arccos(cosine), np.sqrt(1.0 - cosine**2)
    facets = np.minimum(1.0, 2.0 * cosine**2) * np.exp(-(alpha**2) / (2.0 * roughness**2)) / cosine
    weight = (cd * cosine + cs * facets) * cosine
    points = (-radius * cosine, radius * sine * np.cos(around), radius * sine * np.sin(around), weight)
    return Points(*(values.ravel() for values in points))


def disc(radius: float) -> Points:
    """Return a disc in the sonar's plane that shines all over."""
    ahead, across = np.meshgrid(*[radius * (np.arange(200) + 0.5 - 100) / 100] * 2)
    inside = np.hypot(ahead, across) < radius
    return Points(ahead[inside], across[inside], np.zeros(inside.sum()), np.ones(inside.sum()))


def half(radius: float) -> Points:
    """Return the near half of a disc that shines all over."""
    whole = disc(radius)
    near = whole.ahead < 0.0
    return Points(*(values[near] for values in whole))


def plate(half_width: float) -> Points:
    """Return a line across the line of sight."""
    across = half_width * (np.arange(400) + 0.5 - 200) / 200
    return Points(np.zeros(400), across, np.zeros(400), np.ones(400))


def body(kind: str, size: float) -> Points:
    """Return the points of one of KINDS."""
    return {"front": front, "disc": disc, "half": half, "plate": plate, "point": lambda _: plate(1e-3)}[kind](size)


def mean_intensity(points: Points, range_m: float, bearing: float, sonar: Sonar = SONAR) -> Floats:
    """Return what the body adds to each cell, at most 1, (beams, samples)."""
    away = range_m + points.ahead
    horizontal = np.hypot(away, points.across)
    column = np.rint(np.hypot(horizontal, points.up) / sonar.dr_m).astype(np.int64)
    seen_at = bearing + np.arctan2(points.across, away)
    image = np.zeros((sonar.beams, sonar.samples))
    least, most = seen_at.min() - BEAM_REACH * sonar.sigma, seen_at.max() + BEAM_REACH * sonar.sigma
    for k in np.flatnonzero((least < sonar.bearings) & (most > sonar.bearings)):
        gain = np.exp(-((sonar.bearings[k] - seen_at) ** 2) / (2.0 * sonar.sigma**2))
        image[k] = np.bincount(column, gain * points.weight, sonar.samples)
    return np.asarray(image / image.max())


def ping_of(amplitude: Floats32, sonar: Sonar = SONAR) -> Ping:
    """Return the ping of float32 amplitudes (beams, samples)."""
    return Ping(
        seq=0, ping_number=0, t_ns=0, t_rx_ns=0, utc_ns=0, beams=sonar.beams, samples=sonar.samples, dtype="f4",
        data=amplitude.astype(np.float32).tobytes(), bearing_rad=sonar.bearings.tolist(), range0_m=0.0,
        dr_m=sonar.dr_m, sound_speed=1500.0,
    )  # fmt: skip


class Case(NamedTuple):
    """A row of the table."""

    kind: str
    size: float
    """Radius, m; of a plate half its width."""
    range_m: float
    snr_db: float
    """Highest mean intensity over the background."""
    sonar: Sonar = SONAR


class Look(NamedTuple):
    """One look at a body, and what the chain found of it."""

    case: Case
    bearing: float
    near_m: float
    found: Detection | None


class Errors(NamedTuple):
    """Of near edge, centre, radius and place across of the looks in which something was found: (found, 4)."""

    wrong: Floats
    """m."""
    claimed: Floats
    """Standard deviations, m."""

    def normalized(self) -> Floats:
        """Return the errors in units of what is claimed."""
        return np.asarray(self.wrong / self.claimed)


class Row(NamedTuple):
    """What has been seen of a case."""

    case: Case
    looks: int
    errors: Errors


def looks(chain: Chain, case: Case, count: int, rng: np.random.Generator, speckle: int = 1) -> Iterator[Look]:
    """Look at a body at bearings anywhere between two beams, each time in other speckle: the mean of so many images."""
    points, sonar = body(case.kind, case.size), case.sonar
    near_m = case.range_m + float(points.ahead.min())
    for bearing in rng.uniform(-WIDEST, WIDEST, count) * sonar.bearings[-1] / SONAR.bearings[-1]:
        mean = 1.0 + 10.0 ** (0.1 * case.snr_db) * mean_intensity(points, case.range_m, bearing, sonar)
        amplitude = 30.0 * np.sqrt(mean * rng.gamma(speckle, 1.0 / speckle, mean.shape))
        detections = chain.process(ping_of(amplitude, sonar)).detections
        found = [d for d in detections if is_of(d, case, bearing, points)]
        yield Look(case, bearing, near_m, max(found, key=lambda d: d.snr_db, default=None))


def is_of(found: Detection, case: Case, bearing: float, points: Points) -> bool:
    """Tell whether a detection is of the body: its near edge is between 1 m (20 samples) before it and behind it."""
    before, behind = 20.0 * case.sonar.dr_m, 10.0 * case.sonar.dr_m
    near = case.range_m + points.ahead.min() - before
    far = case.range_m + max(points.ahead.max(), 0.5 * case.size) + behind
    beside = (case.size / case.range_m) + 0.5 * found.bearing_extent_rad + case.sonar.spacing
    return bool(near < found.near_m < far and abs(found.bearing_rad - bearing) < beside)


def errors_of(seen: list[Look]) -> Errors:
    """Return what is wrong with what was found, and what it claims to be."""
    wrong, claimed = [], []
    for (_, size, range_m, *_), bearing, near_m, d in seen:
        if d is not None:
            across = (d.bearing_rad - bearing) * range_m
            wrong.append((d.near_m - near_m, d.range_m - range_m, d.radius_m - size, across))
            claimed.append((d.sigma_near_m, d.sigma_range_m, d.sigma_radius_m, d.sigma_bearing_rad * range_m))
    return Errors(np.array(wrong).reshape(-1, 4), np.array(claimed).reshape(-1, 4))


def figures(errors: Errors) -> str:
    """Return the columns of the table; the last ones leave out errors beyond the tracker's gate."""
    if not len(errors.wrong):
        return " nothing found"
    square = errors.normalized() ** 2
    inside = np.ma.masked_array(square, square > GATE_SIGMAS**2).mean(0).filled(np.nan)
    columns = (errors.wrong.mean(0)[:3], np.sqrt((errors.claimed**2).mean(0))[:3], square.mean(0), inside)
    formats = ("{:+7.2f}", "{:7.2f}", "{:7.2f}", "{:7.2f}")
    return " |".join("".join(f.format(v) for v in values) for f, values in zip(formats, columns, strict=True))


def seen_of(chain: Chain, case: Case, args: argparse.Namespace) -> Row:
    """Return what is seen of a case in so many looks, each at another place in two samples: a column of the chain's.

    In the middle of a column places are reported better than elsewhere, most of all those of points.
    """
    kind, size = KINDS.index(case.kind) + 1, int(10 * case.size)
    rng = np.random.default_rng([args.seed, int(case.range_m), int(case.snr_db), size, kind])
    seen: list[Look] = []
    for _ in range(args.looks):
        moved = case._replace(range_m=case.range_m + rng.uniform(-1.0, 1.0) * case.sonar.dr_m)
        seen += looks(chain, moved, 1, rng, args.speckle)
    return Row(case, args.looks, errors_of(seen))


def print_summary(rows: list[Row]) -> None:
    """Print, of the rows in which enough was found, how many have sigmas that are right, and the worst of them."""
    for row_kind in [*dict.fromkeys(row.case.kind for row in rows), "all"]:
        chosen = [row for row in rows if row_kind in (row.case.kind, "all") and len(row.errors.wrong) >= LEAST_FOUND]
        if not chosen:
            continue
        square = [np.minimum(row.errors.normalized() ** 2, GATE_SIGMAS**2).mean(0) for row in chosen]
        bias = max(chosen, key=lambda row: abs(row.errors.wrong[:, 0].mean()))
        print(
            f"{row_kind:8}{len(chosen):4} rows{shares(np.array(square))}"
            f" | near edge {bias.errors.wrong[:, 0].mean():+.2f} m at worst: {bias.case.size:g} m,"
            f" {bias.case.range_m:g} m, {bias.case.snr_db:g} dB"
        )


def shares(square: Floats) -> str:
    """Return what print_summary tells of means of squares (rows, 4)."""
    right = (RIGHT[0] <= square) & (square <= RIGHT[1])
    counts = {"right": right, "over 2": square > 2.0, "under 0.5": square < 0.5}
    text = "".join(f" | {name}:" + "".join(f"{v:5.0%}" for v in reported.mean(0)) for name, reported in counts.items())
    values = {"least": square.min(0), "median": np.median(square, 0), "most": square.max(0)}
    return text + "".join(f" | {name}:" + "".join(f"{v:6.2f}" for v in reported) for name, reported in values.items())


def drawn(kind: str, snr_db: float, rng: np.random.Generator) -> Case:
    """Draw radius and range of a body."""
    size = 0.0 if kind == "point" else float(np.exp(rng.uniform(*np.log(RADII_M))))
    return Case(kind, size, float(rng.uniform(*RANGES_M)), snr_db)


def print_drawn(chain: Chain, args: argparse.Namespace) -> None:
    """Print the means of error^2/sigma^2 by kind and level over radii and ranges that are drawn."""
    print(f"\nradii {RADII_M} m and ranges {RANGES_M} m drawn, {args.drawn} looks; near edge, centre, radius, across")
    print(f"{'body':8}" + "".join(f"{f'{snr_db:g} dB':^25}" for snr_db in args.snr))
    for kind in args.kinds:
        line = f"{kind:8}"
        for snr_db in args.snr:
            rng = np.random.default_rng([args.seed, 1, int(snr_db), KINDS.index(kind) + 1])
            cases = (drawn(kind, snr_db, rng) for _ in range(args.drawn))
            errors = errors_of([look for case in cases for look in looks(chain, case, 1, rng, args.speckle)])
            square = np.minimum(errors.normalized() ** 2, GATE_SIGMAS**2)
            line += "|" + ("".join(f"{v:6.2f}" for v in square.mean(0)) if len(square) >= LEAST_FOUND else " " * 24)
        print(line, flush=True)


def arguments() -> argparse.Namespace:
    """Return the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--looks", type=int, default=60, help="images a row")
    parser.add_argument("--drawn", type=int, default=100, help="images a kind and level of bodies drawn at random")
    parser.add_argument("--speckle", type=int, default=1, help="images that are averaged")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--kinds", nargs="+", default=KINDS, choices=KINDS)
    parser.add_argument("--radii", nargs="+", type=float, default=[1.5, 3.0], metavar="M")
    parser.add_argument("--ranges", nargs="+", type=float, default=[20.0, 50.0, 90.0], metavar="M")
    parser.add_argument("--snr", nargs="+", type=float, default=[6.0, 10.0, 15.0, 25.0], metavar="DB")
    return parser.parse_args()


def main() -> None:
    """Print the table."""
    args = arguments()
    chain = Chain(PipelineSettings())
    print("                               | near edge, centre, radius | near edge, centre, radius, across:")
    print(
        "body     radius range SNR found|       bias, m       | claimed sigma, m    |     error^2/sigma^2        |",
        end="",
    )
    print(" within 4 sigma")
    rows: list[Row] = []
    for kind in args.kinds:
        for size in [0.0] if kind == "point" else args.radii:
            for range_m, snr_db in product(args.ranges, args.snr):
                row = seen_of(chain, Case(kind, size, range_m, snr_db), args)
                rows.append(row)
                share = len(row.errors.wrong) / row.looks
                print(f"{kind:8}{size:6.1f}{range_m:7.0f}{snr_db:4.0f}{share:6.2f}|{figures(row.errors)}", flush=True)
    print(f"\nrows with {LEAST_FOUND} looks or more that found it; mean of error^2/sigma^2, each no more than 16,")
    print(f"right: {RIGHT[0]} to {RIGHT[1]}; near edge, centre, radius, across")
    print_summary(rows)
    print_drawn(chain, args)


if __name__ == "__main__":
    main()
