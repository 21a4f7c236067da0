"""Requests to the sonar, to the tracker (operators' vetoes) and to a live replay."""

from pathlib import Path
from typing import Generic, TypeVar

import msgspec
import zmq

from ods.base.errors import OdsError
from ods.messages import ReplayAnswer, ReplayRequest, SonarAnswer, SonarRequest, Veto, VetoAnswer, VetoRequest
from ods.runtime import bus
from ods.runtime.keys.curve import connect_by_key
from ods.runtime.keys.key_files import ClientKey, read_client_key
from ods.runtime.run_dir import RunDirError, is_safe_to_hear

RequestT = TypeVar("RequestT", bound=msgspec.Struct)
AnswerT = TypeVar("AnswerT", SonarAnswer, ReplayAnswer, VetoAnswer)


class SonarError(OdsError):
    """The sonar did not accept the request; the text says why in one line."""


class ReplayError(OdsError):
    """A live replay refused the request; the text says why in one line."""


class VetoError(OdsError):
    """The tracker refused the veto; the text says why in one line."""


class _Requester(Generic[RequestT, AnswerT]):
    """Sends requests to one process and waits for the answers."""

    def __init__(
        self, run_dir: Path, row: str, answer: type[AnswerT], timeout_s: float, key: ClientKey | None = None
    ) -> None:
        self._run_dir, self._row, self._timeout_s = run_dir, bus.REQUESTS[row], timeout_s
        self._silence = ": does it run?" if key is None else ": does it run, and know this key as an operator's?"
        self._decoder: msgspec.msgpack.Decoder[AnswerT] = msgspec.msgpack.Decoder(answer)
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._socket = self._context.socket(zmq.REQ)
        self._socket.setsockopt(zmq.LINGER, 0)
        self._socket.setsockopt(zmq.IMMEDIATE, 1)  # a request never waits for a process that is away
        self._socket.setsockopt(zmq.REQ_RELAXED, 1)  # the next one may be sent though this one was not answered
        self._socket.setsockopt(zmq.REQ_CORRELATE, 1)
        self._socket.setsockopt(zmq.SNDTIMEO, round(timeout_s * 1000))
        self._socket.setsockopt(zmq.RCVTIMEO, round(timeout_s * 1000))
        if key is not None:
            connect_by_key(self._socket, key)
        self._socket.connect(bus.endpoint(run_dir, row))

    def ask(self, request: RequestT, error: type[OdsError]) -> AnswerT:
        """Send a request and wait for its answer. Raises `error` if it is not ok or does not come in time."""
        process = f"{self._row.process} process"
        try:
            is_safe_to_hear(self._run_dir)
            self._socket.send(msgspec.msgpack.encode(request))
            answer = self._decoder.decode(self._socket.recv())
        except RunDirError as unsafe:
            raise error(str(unsafe)) from None
        except zmq.Again:
            why = bus.unreachable_reason(self._run_dir, self._row.name) or self._silence
            raise error(f"no answer from the {process} within {self._timeout_s:g} s{why}") from None
        except bus.UNDECODABLE as wrong:
            raise error(f"bad answer from the {process}: {wrong}") from None
        if not answer.ok:
            raise error(answer.reason)
        return answer

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()
        self._context.term()


class Sonar:
    """Sets the sonar through the sonar process. A setting lasts until the next request."""

    def __init__(self, run_dir: str | Path, timeout_s: float = 6.0) -> None:
        """`timeout_s`: longest time for a request; the sonar process itself gives up after 4 s by default."""
        self._requester: _Requester[SonarRequest, SonarAnswer] = _Requester(
            Path(run_dir), "sonar-requests", SonarAnswer, timeout_s
        )

    def set_range(self, range_m: float) -> SonarAnswer:
        """Set the range, m; return when the sonar uses it. Raises SonarError."""
        return self.ask(SonarRequest(range_m=range_m))

    def ask(self, request: SonarRequest) -> SonarAnswer:
        """Send any request and wait for its answer. Raises SonarError if it is not ok or does not come in time."""
        return self._requester.ask(request, SonarError)

    def close(self) -> None:
        """Close the socket."""
        self._requester.close()


class Replay:
    """Pauses, continues and steps a live replay."""

    def __init__(self, run_dir: str | Path, timeout_s: float = 2.0) -> None:
        """`timeout_s`: longest time for a request."""
        self._requester: _Requester[ReplayRequest, ReplayAnswer] = _Requester(
            Path(run_dir), "replay-requests", ReplayAnswer, timeout_s
        )

    def pause(self) -> ReplayAnswer:
        """Pause after the last published message. Raises ReplayError."""
        return self.ask(ReplayRequest(do="pause"))

    def go(self, speed: float | None = None) -> ReplayAnswer:
        """Continue, at `speed` times the recorded pace (None: unchanged). Raises ReplayError."""
        return self.ask(ReplayRequest(do="go", speed=speed))

    def step(self, steps: int = 1) -> ReplayAnswer:
        """Continue until this number of obstacle lists has been published, then pause. Raises ReplayError."""
        return self.ask(ReplayRequest(do="step", steps=steps))

    def ask(self, request: ReplayRequest) -> ReplayAnswer:
        """Send any request and wait for its answer. Raises ReplayError if it is not ok or does not come in time."""
        return self._requester.ask(request, ReplayError)

    def close(self) -> None:
        """Close the socket."""
        self._requester.close()


class Vetoes:
    """Ignores, forgets or restores obstacles in the tracker, with an operator's key (`ods keys`), on board."""

    def __init__(self, run_dir: str | Path, key: str | Path, timeout_s: float = 2.0) -> None:
        """`key`: the operator's secret file. Raises KeyFileError."""
        self._requester: _Requester[VetoRequest, VetoAnswer] = _Requester(
            Path(run_dir), "veto-requests", VetoAnswer, timeout_s, read_client_key(Path(key))
        )

    def ask(self, request: VetoRequest) -> list[Veto]:
        """Send a request; return the vetoes in force. Raises VetoError if it is refused or no answer comes."""
        return self._requester.ask(request, VetoError).vetoes

    def close(self) -> None:
        """Close the socket."""
        self._requester.close()
