"""The folder of keys: the vehicle's own pair, lists of those who are allowed, and secrets yet to be handed over.

`server.secret` is the vehicle's; `allowed` has a line for each client that may listen, its name and its public key,
`operators` for each who may veto obstacles; `NAME.secret` is what one of them needs, until somebody moves it to where
it is used.
"""

import contextlib
import fcntl
import os
import re
from collections.abc import Iterator
from pathlib import Path

import zmq

from ods.base.errors import reason_of
from ods.runtime.keys.key_files import SECRET_MODE, KeyFileError, KeyPair, is_key, read_pair, text_of_own

SERVER = "server"
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}")
CLIENTS, OPERATORS = "allowed", "operators"
HEADS = {
    CLIENTS: "# Clients that may listen: name and public key. `ods keys` writes this file.\n",
    OPERATORS: "# Operators who may veto obstacles: name and public key. `ods keys` writes this file.\n",
}


class KeyFolder:
    """Where keys are, and one list of them. Every method raises KeyFileError."""

    def __init__(self, path: Path, who: str = CLIENTS) -> None:
        """`who`: CLIENTS or OPERATORS."""
        self.path = path
        self._who = who
        self._allowed = path / who

    def secret_of(self, name: str) -> Path:
        """Return the file of a secret."""
        return self.path / f"{name}.secret"

    def server(self) -> KeyPair:
        """Return the vehicle's pair."""
        return read_pair(self.secret_of(SERVER))

    def allowed(self) -> dict[str, str]:
        """Return the public keys of the list by name; it is empty where there is none."""
        return {} if self.version() is None else _parsed(self._allowed, text_of_own(self._allowed, 0o022))

    def version(self) -> tuple[int, ...] | None:
        """Return what changes when the list does; None: there is none."""
        try:
            state = self._allowed.stat()
        except FileNotFoundError:
            return None
        except OSError as error:
            raise KeyFileError(f"{self._allowed}: {reason_of(error)}") from error
        return state.st_dev, state.st_ino, state.st_size, state.st_mtime_ns, state.st_ctime_ns

    def make(self, name: str) -> Path:
        """Make a client's pair and allow it; return the file with its secret. The vehicle's is made with the first."""
        with self._changed(name) as allowed:
            pair, server = _new_pair(), self._server_or_new()
            self._write(self.secret_of(name), pair, server.public)
            allowed[name] = pair.public
        return self.secret_of(name)

    def allow(self, name: str, public: str) -> None:
        """Allow a client that made its pair itself."""
        if not is_key(public):
            raise KeyFileError(
                f"{public[:50]!r}: not a public key: expected 40 characters, as zmq.curve_keypair() gives"
            )
        with self._changed(name) as allowed:
            self._server_or_new()
            allowed[name] = public

    def revoke(self, name: str) -> None:
        """Take a client from the list, and its secret from the folder if it is still there."""
        with self._locked():
            allowed = self.allowed()
            if name not in allowed:
                raise KeyFileError(f"{self._allowed}: has no {name}")
            del allowed[name]
            self._write_allowed(allowed)
            self.secret_of(name).unlink(missing_ok=True)

    @contextlib.contextmanager
    def _changed(self, name: str) -> Iterator[dict[str, str]]:
        """Give the list, to add a new name to it; then it is written."""
        if not NAME.fullmatch(name) or name == SERVER:
            raise KeyFileError(f"{name}: not a name: use letters, digits and ._- only, and not {SERVER}")
        with self._locked():
            allowed = self.allowed()
            if name in allowed:
                raise KeyFileError(f"{self._allowed}: already has a {name}: revoke it, or use another name")
            yield allowed
            self._write_allowed(allowed)

    @contextlib.contextmanager
    def _locked(self) -> Iterator[None]:
        """Keep others from changing the folder meanwhile: what is revoked must not come back by a race."""
        try:
            self.path.mkdir(mode=0o700, parents=True, exist_ok=True)
            fd = os.open(self.path, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        except OSError as error:
            raise KeyFileError(f"{self.path}: {reason_of(error)}") from error
        try:
            fcntl.flock(fd, fcntl.LOCK_EX)
            yield
        except OSError as error:
            raise KeyFileError(f"{self.path}: {reason_of(error)}") from error
        finally:
            os.close(fd)

    def _server_or_new(self) -> KeyPair:
        if not self.secret_of(SERVER).exists():
            self._write(self.secret_of(SERVER), _new_pair())
        return self.server()

    def _write(self, path: Path, pair: KeyPair, server: str = "") -> None:
        lines = ["# A secret of ODS", f'public = "{pair.public}"', f'secret = "{pair.secret}"']
        if server:
            lines.append(f'server = "{server}"')
        _write_new(path, "\n".join(lines) + "\n")

    def _write_allowed(self, allowed: dict[str, str]) -> None:
        part = self.path / f"{self._who}.{os.getpid()}.part"
        part.unlink(missing_ok=True)
        _write_new(part, HEADS[self._who] + "".join(f"{name} {key}\n" for name, key in allowed.items()))
        part.replace(self._allowed)


def _write_new(path: Path, text: str) -> None:
    """Write a file that its owner alone may read, whatever the umask; never over another. Raises OSError."""
    fd = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, SECRET_MODE)
    with os.fdopen(fd, "w") as file:
        os.fchmod(fd, SECRET_MODE)
        file.write(text)
        file.flush()
        os.fsync(fd)


def _new_pair() -> KeyPair:
    public, secret = zmq.curve_keypair()
    return KeyPair(public.decode(), secret.decode())


def _parsed(path: Path, text: str) -> dict[str, str]:
    found: dict[str, str] = {}
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split()
        if not words or line.startswith("#"):
            continue
        if len(words) != 2 or not is_key(words[1]):
            raise KeyFileError(f"{path}: line {number}: expected a name and a public key of 40 characters")
        if words[0] in found:
            raise KeyFileError(f"{path}: line {number}: {words[0]} is listed twice")
        found[words[0]] = words[1]
    return found
