"""Summary of a recording in numbers: topics, rates, gaps, sizes, processes, and the faults that these reported."""

import re
from collections import Counter
from dataclasses import dataclass, field

import msgspec

from ods.base.clock import NS
from ods.messages import Health
from ods.recording.gaps import Gaps
from ods.recording.mcap.reader import Recorded, Recording
from ods.recording.mcap.session import is_finished
from ods.runtime import bus

LONGEST_TEXT, MOST_TOLD = 300, 1000
"""Characters of a fault, and the numbers of faults and processes that are listed: a hostile file has millions."""
NUMBER = re.compile(r"\d+(\.\d+)?")


@dataclass
class TopicSummary:
    """One topic."""

    messages: int = 0
    bytes: int = 0
    missed: int = 0
    """Published and not recorded, by the gaps in `seq`."""
    first_ns: int = 0
    last_ns: int = 0

    @property
    def rate_hz(self) -> float:
        """Messages a second from the first to the last one; 0 for a single one."""
        spent_ns = self.last_ns - self.first_ns
        return (self.messages - 1) * NS / spent_ns if spent_ns > 0 else 0.0


@dataclass
class Fault:
    """A problem that a process reported."""

    first_ns: int
    last_ns: int
    reports: int = 0


@dataclass
class Summary:
    """A whole recording. Times are CLOCK_MONOTONIC of the recorded computer, ns."""

    topics: dict[str, TopicSummary] = field(default_factory=dict)
    started: dict[tuple[str, int], int] = field(default_factory=dict)
    """When each process, by name and id, was received from first."""
    faults: dict[tuple[str, str], Fault] = field(default_factory=dict)
    """By process and text, numbers in it left out."""
    first_ns: int = 0
    last_ns: int = 0
    first_utc_ns: int = 0
    size: int = 0
    """Bytes on the disk."""
    cut_off: list[str] = field(default_factory=list)
    """Files without their end."""
    losses: Counter[str] = field(default_factory=Counter)

    @property
    def duration_s(self) -> float:
        """From the first message to the last."""
        return (self.last_ns - self.first_ns) / NS


def summarize(recording: Recording) -> Summary:
    """Read a whole recording. Raises RecordingError, OSError."""
    found, gaps = Summary(losses=recording.losses), Gaps()
    for path in recording.segments:
        found.size += path.stat().st_size
        if not is_finished(path):
            found.cut_off.append(path.name)
    for each in recording.messages():
        if not found.topics:
            found.first_ns, found.first_utc_ns = each.log_ns, each.utc_ns
        found.last_ns = max(found.last_ns, each.log_ns)
        _count(found.topics.setdefault(each.topic, TopicSummary(first_ns=each.log_ns)), each)
        gaps.take(each.topic, each.data)
        if each.topic == bus.HEALTH:
            _hear(found, each)
    for topic, count in gaps.missed.items():
        found.topics[topic].missed = count
    return found


def _count(topic: TopicSummary, message: Recorded) -> None:
    topic.messages += 1
    topic.bytes += len(message.data)
    topic.last_ns = message.log_ns


def _hear(found: Summary, message: Recorded) -> None:
    try:
        health = msgspec.convert(message.message(), Health)
    except ValueError:
        return
    if len(health.process) > LONGEST_TEXT:
        return
    if health.rss_mb > 0.0 and len(found.started) < MOST_TOLD:  # not reported by `ods run` in its place
        found.started.setdefault((health.process, health.pid), message.log_ns)
    for problem in health.problems:
        text = NUMBER.sub("#", problem[:LONGEST_TEXT])
        if len(found.faults) >= MOST_TOLD and (health.process, text) not in found.faults:
            continue
        fault = found.faults.setdefault((health.process, text), Fault(message.log_ns, message.log_ns))
        fault.last_ns = message.log_ns
        fault.reports += 1
