"""The folder of keys that the configuration names."""

from pathlib import Path

from ods.base.settings_file import ConfigError, load_table
from ods.config import OnboardConfig
from ods.runtime.bus import BusSettings
from ods.runtime.keys.key_folder import CLIENTS, KeyFolder


def folder_of(config: Path, who: str = CLIENTS) -> KeyFolder:
    """Return it with one of its lists: CLIENTS or OPERATORS. Raises ConfigError."""
    keys = load_table(config, "bus", BusSettings, OnboardConfig).keys
    if keys is None:
        raise ConfigError(f'{config}: bus.keys: missing: name a folder for the keys, such as keys = "keys"')
    return KeyFolder(keys, who)
