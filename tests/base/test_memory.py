"""Too little memory, as the operating system, the loader of libraries and Python say it."""

import errno

import pytest

from ods.base.computer.memory import is_too_little


def caused(error: Exception, cause: Exception) -> Exception:
    error.__cause__ = cause
    return error


@pytest.mark.parametrize(
    ("error", "reported"),
    [
        (MemoryError(), True),
        (OSError(errno.ENOMEM, "Cannot allocate memory"), True),
        (ImportError("libscipy_openblas64_.so: failed to map segment from shared object"), True),
        (OSError("libgomp.so: cannot allocate memory in static TLS block"), True),
        (caused(RuntimeError("could not be imported"), MemoryError()), True),
        (OSError(errno.ENOSPC, "No space left on device"), False),
        (ImportError("libfoo.so: cannot open shared object file: No such file or directory"), False),
        (ValueError("failed to map segment"), False),
        (None, False),
    ],
)
def test_who_says_so(error: Exception | None, reported: bool) -> None:
    assert is_too_little(error) is reported
