"""Site of a mission and mounting of the sonar, as formats need them: from a configuration, as a rule the recording's
own."""

from pathlib import Path

import msgspec

from ods.base.errors import OdsError, one_line
from ods.base.frames.mounting import Mounting, MountingSettings
from ods.base.geodesy import LocalFrame, SiteSettings
from ods.base.settings import Settings, complaint_of
from ods.base.settings_file import load, parsed_toml

ATTACHMENT = "config.toml"
"""Name of the configuration in a recording."""


class _Sonar(Settings, frozen=True, forbid_unknown_fields=False):
    mounting: MountingSettings = MountingSettings()


class _File(Settings, frozen=True, forbid_unknown_fields=False):
    """The part of a configuration, of whatever version, that is looked at."""

    site: SiteSettings
    sonar: _Sonar = _Sonar()


class PlaceError(OdsError):
    """There is no site to be had; the text is one line."""


class Place(msgspec.Struct, frozen=True):
    """Site and mounting."""

    frame: LocalFrame
    mounting: Mounting


def place_in(text: bytes, where: str) -> Place:
    """Return the place of a configuration; `where` it comes from, for errors. Raises PlaceError."""
    try:
        found = msgspec.convert(parsed_toml(text), _File)
    except msgspec.ValidationError as error:
        raise PlaceError(f"{where}: {complaint_of(error, _File)}") from error
    except (ValueError, RecursionError) as error:
        raise PlaceError(f"{where}: not valid TOML: {one_line(error)}") from error
    return _place(found)


def place_of(attachments: dict[str, bytes], config: Path | None) -> Place:
    """Return the place of a recording: by `config` if given, else by its own configuration.

    Raises PlaceError, ConfigError.
    """
    if config is None:
        if ATTACHMENT not in attachments:
            raise PlaceError("the recording has no configuration: give one with --config")
        return place_in(attachments[ATTACHMENT], "the recording's configuration")
    return _place(load(config, _File))


def _place(found: _File) -> Place:
    frame = LocalFrame(found.site.latitude_deg, found.site.longitude_deg)
    return Place(frame, Mounting(found.sonar.mounting))
