"""Reads config/*.toml into typed settings; an unknown key or a bad value is one line that names the key."""

import math
import re
import tomllib
from pathlib import Path
from typing import Annotated, Any, TypeVar

import msgspec

from ods.nav_bridge.settings import NavSettings
from ods.pipeline.settings import PipelineSettings
from ods.settings import Settings
from ods.sonar_link.settings import SonarSettings
from ods.tracker.settings import TrackerSettings

T = TypeVar("T", bound=Settings)


class ConfigError(Exception):
    """The configuration is wrong; the text is one line: file, key, what is wrong with it."""


class BusSettings(Settings, frozen=True):
    """Where the processes meet."""

    run_dir: Path
    """Folder of sockets and locks; its path must stay under 80 characters."""

    def __post_init__(self) -> None:
        if len(str(self.run_dir)) > 80:
            raise ValueError(f"run_dir: {self.run_dir} is longer than 80 characters, too long for a socket path")


class SiteSettings(Settings, frozen=True):
    """The place: origin of the local north-east-down frame."""

    latitude_deg: Annotated[float, msgspec.Meta(ge=-90.0, le=90.0)]
    longitude_deg: Annotated[float, msgspec.Meta(ge=-180.0, le=180.0)]


class OnboardConfig(Settings, frozen=True):
    """Everything the four on-board processes need."""

    bus: BusSettings
    site: SiteSettings
    sonar: SonarSettings
    pipeline: PipelineSettings
    tracker: TrackerSettings
    nav: NavSettings


def load(path: Path, kind: type[T]) -> T:
    """Read a TOML file as `kind`. Relative paths inside are taken from the file's own folder.

    Raises ConfigError.
    """
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError(f"{path}: {error.strerror}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path}: not valid TOML: {error}") from error
    _refuse_non_finite(data, path, "")
    folder = path.resolve().parent

    def hook(wanted: type, value: Any) -> Any:
        if wanted is Path and isinstance(value, str):
            return folder / Path(value).expanduser()
        raise TypeError(f"Expected `str`, got `{type(value).__name__}`")

    try:
        return msgspec.convert(data, kind, dec_hook=hook)
    except msgspec.ValidationError as error:
        raise ConfigError(f"{path}: {_in_plain_words(str(error))}") from error


def _refuse_non_finite(value: Any, path: Path, key: str) -> None:
    if isinstance(value, dict):
        for name, item in value.items():
            _refuse_non_finite(item, path, f"{key}.{name}" if key else name)
    elif isinstance(value, list):
        for index, item in enumerate(value):
            _refuse_non_finite(item, path, f"{key}[{index}]")
    elif isinstance(value, float) and not math.isfinite(value):
        raise ConfigError(f"{path}: {key}: must be a finite number, got {value}")


def _in_plain_words(text: str) -> str:
    """Turn "Expected `float`, got `str` - at `$.a.b`" into "a.b: expected `float`, got `str`"."""
    match = re.fullmatch(r"(.*) - at `\$\.?(.*)`", text, re.DOTALL)
    message, key = (match[1], match[2]) if match else (text, "")
    field = re.search(r"(unknown|required) field `([^`]+)`", message)
    if field:
        key = f"{key}.{field[2]}" if key else field[2]
        message = "unknown key" if field[1] == "unknown" else "missing"
    return f"{key}: {message[:1].lower()}{message[1:]}" if key else message
