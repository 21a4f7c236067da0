"""`ods simulate`: a scene file to recorded pings or pictures, by the same code as the live simulator."""

from argparse import Namespace
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import msgspec
import numpy as np
from rich.console import Console
from rich.progress import track

from ods.base import clock
from ods.base.errors import OdsError
from ods.base.files.out_file import refuse_unwritable, written_whole
from ods.offline.truths import TRUTH_SUFFIX
from ods.plots.style import DARK, drawn_in, refuse_undrawable
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.device.sonars.seabat import refuse_beyond_s7k
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.scene.timeline import load_scene
from ods.sim_sonar.shots import Shot, shots_of
from ods.sonar_link.files.npz_writer import write_ping_file
from ods.sonar_link.files.s7k.writer import write_s7k


def run(args: Namespace) -> None:
    """Write, print and draw the requested results. Raises OdsError."""
    refuse_undrawable(args.chart)
    if args.scene and args.out:
        simulate(args.scene, args.sonar, args.out, args.pings, args.seed, args.style)
    if args.table:
        from ods.simulate.speed import print_table

        print_table(find_sonar(args.sonar))
    if args.chart:
        from ods.simulate.chart import draw_chart

        draw_chart(find_sonar(args.sonar), args.chart, args.style)


def simulate(
    scene: Path, sonar: str, out: Path, pings: int | None = None, seed: int | None = None, style: str = DARK
) -> None:
    """Write the pings of a scene from its beginning.

    `sonar` is the name of a file in config/sonars, or a path. The ending of `out` chooses what is written: .npz or
    .s7k, the whole scene where `pings` is not given, and beside it `<stem>.truth.jsonl`, one Truth a line; .png, one
    picture a ping in that style, one where it is not given. Raises OdsError: a bad file or option, or a scene that the
    format cannot carry.
    """
    if out.suffix not in PING_WRITERS:
        raise OdsError(f"{out}: the ending must be one of {', '.join(PING_WRITERS)}")
    truths_file = None if out.suffix == ".png" else out.with_suffix(TRUTH_SUFFIX)
    refuse_unwritable(out, truths_file, read=(scene,))
    loaded = load_scene(scene)
    model = find_sonar(sonar, scene)
    if out.suffix == ".s7k":
        refuse_beyond_s7k(scene, loaded, sonar, model)
    whole = 1 if out.suffix == ".png" else int(loaded.file.duration_s / model.ping_period_s) + 1
    try:
        images = ImageSimulator(model, loaded, seed)
        shots = _progress(shots_of(images), whole if pings is None else pings, out)
        if truths_file is None:
            with drawn_in(style):
                _write_png(out, shots)
            return
        with written_whole(out) as part, written_whole(truths_file) as truths_part, truths_part.open("wb") as truths:
            PING_WRITERS[out.suffix](part, _noting(shots, truths.write))
    except ValueError as error:
        raise OdsError(f"{scene}: {error}") from error
    except OSError as error:
        raise OdsError(f"{out}: {error.strerror}") from error


def _progress(shots: Iterator[Shot], count: int, out: Path) -> Iterator[Shot]:
    console = Console(stderr=True)
    for _ in track(range(count), f"{out.name}:", console=console, disable=not console.is_terminal):
        yield next(shots)


def _noting(shots: Iterable[Shot], write: Callable[[bytes], object]) -> Iterator[Shot]:
    """Write the truth of each shot that passes."""
    for shot in shots:
        write(msgspec.json.encode(shot.truth) + b"\n")
        yield shot


def _write_npz(path: Path, shots: Iterable[Shot]) -> None:
    pings, truths = zip(*shots, strict=True)
    objects = [[[*item.position_ned, *item.velocity_ned, item.radius_m] for item in truth.objects] for truth in truths]
    write_ping_file(
        path,
        pings,
        position_ned=[truth.position_ned for truth in truths],
        attitude=[truth.attitude for truth in truths],
        truth=np.array(objects).reshape(len(truths), -1, 7),
    )


def _write_s7k(path: Path, shots: Iterable[Shot]) -> None:
    write_s7k(path, (shot.ping for shot in shots))


def _write_png(path: Path, shots: Iterable[Shot]) -> None:
    """One picture is `path` itself; of more, each has its ping's number before the ending."""
    from ods.plots.fan import draw_fan, new_figure, polar_image

    drawn: Path | None = None
    for shot in shots:
        ping = shot.ping
        image = polar_image(ping)
        figure, axes = new_figure(f"{path.stem}, {ping.t_ns / clock.NS:.2f} s", image.bearing_rad)
        draw_fan(axes, image)
        if ping.ping_number == 1 and drawn is not None:
            drawn.rename(_numbered(path, 0))
        drawn = path if ping.ping_number == 0 else _numbered(path, ping.ping_number)
        figure.savefig(drawn)


def _numbered(path: Path, number: int) -> Path:
    return path.with_name(f"{path.stem}-{number:04d}{path.suffix}")


PING_WRITERS: dict[str, Callable[[Path, Iterable[Shot]], None]] = {
    ".npz": _write_npz,
    ".s7k": _write_s7k,
    ".png": _write_png,
}
"""What each ending of the output writes."""
