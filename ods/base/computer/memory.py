"""Is an error one of too little memory? The loader of shared libraries, and who calls it, say so in words only."""

import errno

TOO_LITTLE = "too little memory: see `ulimit -v`, and the limits of its unit or container"
_WORDS = "failed to map segment", "cannot allocate memory"
"""Of glibc's loader."""


def is_too_little(error: BaseException | None) -> bool:
    """Return whether there was too little memory behind an error."""
    while error is not None:
        if isinstance(error, MemoryError) or (isinstance(error, OSError) and error.errno == errno.ENOMEM):
            return True
        if isinstance(error, (ImportError, OSError)) and any(words in str(error).lower() for words in _WORDS):
            return True
        error = error.__cause__ or error.__context__
    return False
