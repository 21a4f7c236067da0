"""The thread that writes a recording: the only one of its process, beside its synchronizer, that waits for the disk."""

import errno
import logging
import os
import threading
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from ods.base import clock
from ods.base.errors import reason_of
from ods.recording.facts import facts
from ods.recording.gaps import Gaps
from ods.recording.inbox import Inbox, Received
from ods.recording.mcap.reader import SUFFIX
from ods.recording.mcap.session import Session, is_finished, new_folder
from ods.recording.settings import RecordConfig
from ods.recording.sync import Syncer
from ods.tracker.map.store import MapError, copy_of_map

log = logging.getLogger(__name__)

NUMBERED = ("ping", "pose", "detections", "obstacles", "clearance", "truth", "vehicle", "set-point", "raw", "health")
"""Topics whose messages have a `seq`."""
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
LOOK_S = 1.0
"""Between attempts while the disk is full, and between checks of its free space, s."""
LONGEST_MAP_BYTES = 32_000_000
WAIT_S = 0.5


class RecordingWriter(threading.Thread):
    """Writes the inbox's messages until it is closed; `problem` is the reason why it cannot.

    `counters`: see those of `record` in the counter table.
    """

    def __init__(self, settings: RecordConfig, inbox: Inbox, give_up: Callable[[], bool]) -> None:
        """`give_up`: says whether to leave what cannot be written, at the end."""
        super().__init__(name="scribe", daemon=True)
        self.counters: Counter[str] = Counter()
        self.problem = ""
        self.busy_since_ns = 0
        """Of the write that is under way; 0: none."""
        self.path: Path | None = None
        self.folder: Path | None = None
        self._settings = settings
        self._inbox = inbox
        self._give_up = give_up
        self._session: Session | None = None
        self._sync = Syncer()
        self._gaps = Gaps()
        self._looked_ns = 0
        self._stopped = False

    def run(self) -> None:
        """Write until the inbox is closed and empty."""
        self._sync.start()
        while not self._inbox.ended:
            batch = self._inbox.take(WAIT_S)
            self.busy_since_ns = clock.monotonic_ns()
            if batch and not self._stopped:
                self._write_patiently(batch)
            elif not batch and self._session is None and not self.problem:
                self._attempt(self._open)
            self.busy_since_ns = 0
        self._end()
        self._sync.stop()

    def _end(self) -> None:
        """Complete the file, even if that is all that can be done: the error of the last write is still to be
        reported."""
        if self._session:
            try:
                self._session.finish()
            except OSError as error:
                self._failed(error)

    def _write_patiently(self, batch: list[Received]) -> None:
        """Write it, however long the disk is full, unless the rule says otherwise."""
        while not self._attempt(lambda: self._write(batch)):
            if self._stopped or self._give_up():
                self.counters["dropped_messages"] += len(batch)
                return
            if not self._made_room():
                threading.Event().wait(LOOK_S)
        for message in batch:
            self._gaps.take(message.topic, message.data)
        self.counters["messages"] += len(batch)
        for topic in NUMBERED:
            self.counters[f"missed_{topic}"] = self._gaps.missed[topic]

    def _attempt(self, job: Callable[[], None]) -> bool:
        """Do something with the disk; return whether it could be done."""
        try:
            job()
        except OSError as error:
            self._failed(error)
            return False
        if self.problem:
            log.info("%s: recording continues", self.path)
        self.problem = ""
        return True

    def _failed(self, error: OSError) -> None:
        self.counters["write_failed"] += 1
        where = self.path or self._settings.out or self._settings.record.folder
        full, rule = error.errno in FULL, self._settings.record.when_full
        self._stopped = full and rule == "stop"
        problem = f"{where}: {reason_of(error)}: not recorded" + (", stopped until restart" if self._stopped else "")
        if not self.problem:
            log.error("%s", problem)
        self.problem = problem
        if self._session and (not full or self._stopped):
            with suppress(OSError):
                self._session.abandon()

    def _write(self, batch: list[Received]) -> None:
        session = self._opened()
        now_ns = clock.monotonic_ns()
        if now_ns - self._looked_ns >= LOOK_S * clock.NS or self.problem:
            self._looked_ns = now_ns
            room = os.statvfs(session.folder)
            if room.f_bavail * room.f_frsize < self._settings.record.keep_free_mb * 1e6:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            session.look_around()
        session.write(batch)
        self.counters["segments"], self.counters["oversized_messages"] = session.segments, session.left_out
        if session.path != self.path:
            self.path = session.path
            self._sync.watch(session.fd)

    def _open(self) -> None:
        self._opened()

    def _opened(self) -> Session:
        """Return the session, begun with the configuration and the map as they are now; a new one if its folder is
        gone."""
        if self._session and self._session.folder.is_dir():
            return self._session
        self._leave()
        settings = self._settings
        folder = settings.out or (new_folder(settings.record.folder) if settings.record.folder else None)
        if folder is None:
            raise OSError(errno.ENOENT, "record.folder is not set")
        folder.mkdir(parents=True, exist_ok=True)
        about = facts(settings.text)
        map_image = self._map_image(about)
        session = Session(folder, about, round(settings.record.segment_min * 60 * clock.NS))
        session.enclose("config.toml", "application/toml", settings.text.encode())
        if map_image:
            session.enclose("map.sqlite", "application/vnd.sqlite3", map_image)
        self._session, self.folder = session, folder
        return session

    def _leave(self) -> None:
        """Give up a recording whose folder was moved, removed or unmounted; where its file still is, it can be read."""
        if self._session:
            log.warning("%s was removed: starting a new recording", self._session.folder)
            with suppress(OSError):
                self._session.abandon()
            self._session = None

    def _map_image(self, about: dict[str, str]) -> bytes:
        """Return the map's file, b"" where there is none; state in `about` why it is left out."""
        path = self._settings.tracker.map.path
        if path is None:
            return b""
        try:
            store = copy_of_map(path)
        except MapError as error:
            if not isinstance(error.__cause__, FileNotFoundError):
                about["map"] = f"left out: {error}"
            return b""
        try:
            image = store.image()
        finally:
            store.close()
        if len(image) > LONGEST_MAP_BYTES:
            about["map"] = f"left out: {len(image)} bytes"
            return b""
        return image

    def _made_room(self) -> bool:
        """Remove the oldest complete segment if the rule says so; return whether one was removed."""
        if self._settings.record.when_full != "delete_oldest":
            return False
        top = self._settings.out or self._settings.record.folder
        try:
            for path in sorted(top.rglob(f"*{SUFFIX}") if top else ()):
                if path != self.path and is_finished(path):
                    path.unlink()
                    self.counters["deleted_segments"] += 1
                    log.warning("%s was deleted: the disk is full", path)
                    return True
        except OSError:
            return False
        return False
