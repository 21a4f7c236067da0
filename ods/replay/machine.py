"""Is this the computer, and are these the programs, on which the same floating-point numbers come out?"""

from collections.abc import Mapping

COUNTS = ("version", "cpu_flags", "libc", "numpy")
"""Facts of a recording that must be the same here."""
_WORDS = {"cpu_flags": "type of CPU", "version": "version of ods"}


def differences(recorded: Mapping[str, str], here: Mapping[str, str]) -> list[str]:
    """Return the differences, a text each; empty: bytes have to be the same."""
    found = []
    for name in COUNTS:
        if recorded.get(name) == here.get(name):
            continue
        what = _WORDS.get(name, name)
        if name == "cpu_flags":
            found.append(f"another {what}: {recorded.get('cpu') or 'unknown'}, here {here.get('cpu') or 'unknown'}")
        else:
            found.append(f"another {what}: {recorded.get(name) or 'unknown'}, here {here.get(name) or 'unknown'}")
    return found
