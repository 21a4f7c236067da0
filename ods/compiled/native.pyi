"""All kernels, compiled from C. What each takes: `native.NAME.__doc__`, and the function in Python that calls it."""

from typing import Any

def __getattr__(name: str) -> Any: ...
