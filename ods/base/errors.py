"""The one error that the `ods` command turns into a line and an exit code, and other people's errors in one line."""

import os
from typing import ClassVar

IN_UTF8 = "set one of UTF-8, such as LC_ALL=C.UTF-8, and no PYTHONUTF8=0"


class OdsError(Exception):
    """Something the user can put right: a bad file, key, device or option. Its text is one line."""

    exit_code: ClassVar[int] = 2
    """Of the `ods` command that it ends."""


class UnfitFileError(OSError):
    """What is there is not to be read, whatever the operating system says; its `strerror` is why."""


def missing_kernels_reason(error: BaseException) -> str:
    """Return why the kernels in C cannot be loaded, where that is what `error` says, else nothing."""
    if not isinstance(error, ImportError):
        return ""
    if error.name == "ods.compiled":  # has no module `native`
        return "the kernels are not built: run `make kernels`"
    if error.name in ("ods.compiled.native", "native"):  # for the dynamic linker it has its short name
        return f"cannot load the kernels: {one_line(error)}"
    return ""


def one_line(error: object) -> str:
    """Return a text, usually of another library's error, as one line."""
    return " ".join(str(error).split())


def reason_of(error: BaseException) -> str:
    """Return the operating system's text for the cause of `error`, otherwise its own text, as one line."""
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, OSError) and cause.errno:
            text = str(cause.strerror) if isinstance(cause, UnfitFileError) else os.strerror(cause.errno)
            return text[:1].lower() + text[1:]
        if isinstance(cause, UnicodeEncodeError):
            beyond = ascii(cause.object[cause.start : cause.end])
            return f"no file can have {beyond} in its name in this locale: {IN_UTF8}"
        cause = cause.__cause__
    return one_line(error)
