"""Files with secret keys of CURVE (RFC 7748's X25519, as ZeroMQ has it): their owner's alone, or refused.

A file is TOML; keys are Z85, 40 characters. The vehicle's has `public` and `secret`, a client's `server` besides: the
vehicle's public key.
"""

import os
import stat
import tomllib
from pathlib import Path
from typing import NamedTuple

from ods.base.errors import OdsError

KEY_CHARACTERS = 40
SECRET_MODE = 0o600
MOST_BYTES = 64 * 1024


class KeyFileError(OdsError):
    """A file of keys cannot be used; the text says why in one line."""


class KeyPair(NamedTuple):
    """A public key and its secret, Z85."""

    public: str
    secret: str


class ClientKey(NamedTuple):
    """Keys of a client: its own pair, and the vehicle's public key."""

    own: KeyPair
    server: str


def read_pair(path: Path) -> KeyPair:
    """Read the vehicle's secret file. Raises KeyFileError."""
    found = _read(path, ("public", "secret"))
    return KeyPair(found["public"], found["secret"])


def read_client_key(path: Path) -> ClientKey:
    """Read a client's secret file. Raises KeyFileError."""
    found = _read(path, ("public", "secret", "server"))
    return ClientKey(KeyPair(found["public"], found["secret"]), found["server"])


def text_of_own(path: Path, forbidden: int) -> str:
    """Return the text of a file of one's own, or of root's. Raises KeyFileError, for `forbidden` modes, too."""
    try:
        fd = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    except OSError as error:
        raise KeyFileError(f"{path}: {os.strerror(error.errno or 0)}") from error
    with os.fdopen(fd, "rb") as file:
        state = os.fstat(fd)
        if not stat.S_ISREG(state.st_mode):
            raise KeyFileError(f"{path}: not a file")
        if state.st_uid not in (0, os.geteuid()):
            raise KeyFileError(f"{path}: belongs to another user")
        if state.st_mode & forbidden:
            raise KeyFileError(f"{path}: others have access to it: chmod {SECRET_MODE:o} {path}")
        content = file.read(MOST_BYTES + 1)
    try:
        if len(content) > MOST_BYTES:
            raise ValueError(f"longer than {MOST_BYTES} bytes")
        return content.decode()
    except ValueError as error:
        raise KeyFileError(f"{path}: not a key file: {error}") from None


def is_key(text: object) -> bool:
    """Return whether a text can be a key: 40 characters of Z85."""
    return isinstance(text, str) and len(text) == KEY_CHARACTERS and all(c.isalnum() or c in SIGNS for c in text)


SIGNS = ".-:+=^!/*?&<>()[]{}@%$#"
"""The characters of Z85 (ZeroMQ RFC 32) that are neither letters nor digits."""


def _read(path: Path, names: tuple[str, ...]) -> dict[str, str]:
    try:
        found = tomllib.loads(text_of_own(path, 0o077))
    except tomllib.TOMLDecodeError as error:
        raise KeyFileError(f"{path}: not a key file: {error}") from None
    for name in names:
        if not is_key(found.get(name)):
            raise KeyFileError(f"{path}: {name}: expected a key of {KEY_CHARACTERS} characters")
    return found
