"""`ods info`: show the contents of a recording."""

from argparse import ArgumentParser, Namespace
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

from ods.base.clock import NS
from ods.base.errors import one_line
from ods.recording.errors import RecordingError
from ods.recording.mcap.reader import ODS, Recording, open_recording
from ods.recording.summary import Summary, summarize

MOST_FAULTS = 40


def add_arguments(parser: ArgumentParser) -> None:
    """What to look into."""
    parser.add_argument("recording", type=Path, metavar="FILE|DIR", help="a file .mcap, or a folder of them")


def run(args: Namespace) -> None:
    """Print it. Raises RecordingError."""
    recording = open_recording(args.recording)
    try:
        summary = summarize(recording)
    except OSError as error:
        raise RecordingError(f"{args.recording}: {error.strerror}") from error
    for line in _lines(recording, summary, args.recording):
        print(line)


def _lines(recording: Recording, summary: Summary, asked: Path) -> Iterator[str]:
    begun = datetime.fromtimestamp(min(summary.first_utc_ns // NS, 2**32), UTC)
    files = f"{len(recording.segments)} file{'s' if len(recording.segments) > 1 else ''}"
    place = asked if asked.is_file() else recording.segments[0].parent
    yield f"{place}: {files}, {summary.size / 1e6:.1f} MB, {summary.duration_s:.1f} s"
    yield f"from {begun:%Y-%m-%d %H:%M:%S} UTC{_of_utc(recording)}"
    yield from _machine(recording.metadata.get(ODS, {}))
    held = {name: len(data) for name, data in recording.attachments.items()}
    yield "with " + (", ".join(f"{name} ({size / 1e3:.1f} kB)" for name, size in held.items()) or "no attachments")
    yield ""
    yield from _topics(summary)
    yield ""
    for (process, pid), at_ns in summary.started.items():
        yield f"{(at_ns - summary.first_ns) / NS:8.1f} s  {process} (pid {pid})"
    yield from _faults(summary)
    yield from (f"truncated: {name} (repair it with ods record --finish)" for name in summary.cut_off)
    if summary.losses:
        yield "lost in reading: " + ", ".join(f"{name} {count}" for name, count in sorted(summary.losses.items()))


def _of_utc(recording: Recording) -> str:
    steps = sum(name.startswith("utc step ") for name in recording.metadata)
    unsure = recording.metadata.get(ODS, {}).get("utc_synchronized") == "false"
    return (", of a clock that was not synchronized" if unsure else "") + (f", {steps} steps of UTC" if steps else "")


def _machine(facts: dict[str, str]) -> Iterator[str]:
    libraries = ("python", "libc", "numpy", "msgspec", "pyzmq")
    yield f"ods {facts.get('version', '?')}; " + ", ".join(f"{name} {facts.get(name) or '?'}" for name in libraries)
    known = (facts[name] for name in ("host", "cpu", "system") if facts.get(name))
    yield one_line(", ".join(known)) or "on an unknown computer"
    yield f"configuration {facts.get('config_sha256', '?')[:12]}" + (f", map {facts['map']}" if "map" in facts else "")


def _topics(summary: Summary) -> Iterator[str]:
    yield f"{'topic':16}{'messages':>10}{'per s':>9}{'missed':>8}{'MB':>9}{'bytes each':>12}"
    for name, topic in sorted(summary.topics.items(), key=lambda item: -item[1].bytes):
        row = f"{one_line(name)[:15]:16}{topic.messages:10}{topic.rate_hz:9.2f}{topic.missed:8}"
        yield f"{row}{topic.bytes / 1e6:9.2f}{topic.bytes / topic.messages:12.0f}"


def _faults(summary: Summary) -> Iterator[str]:
    for (process, text), fault in list(summary.faults.items())[:MOST_FAULTS]:
        from_s, to_s = ((t_ns - summary.first_ns) / NS for t_ns in (fault.first_ns, fault.last_ns))
        yield f"{from_s:8.1f} s to {to_s:.1f} s  {process}: {one_line(text)} ({fault.reports} reports)"
    if len(summary.faults) > MOST_FAULTS:
        yield f"and {len(summary.faults) - MOST_FAULTS} other faults"
