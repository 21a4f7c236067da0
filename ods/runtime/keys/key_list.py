"""The keys of a list for a process that checks it often: by key, and read again when the file changes."""

from ods.runtime.keys.key_files import KeyFileError
from ods.runtime.keys.key_folder import KeyFolder


class KeyList:
    """A list that cannot be used counts as empty."""

    def __init__(self, folder: KeyFolder) -> None:
        self.names: dict[str, str] = {}
        """By public key."""
        self.problem = ""
        """Why the list cannot be used."""
        self._folder = folder
        self._version: tuple[int, ...] | None = None

    def follow(self) -> bool:
        """Read the list again if it has changed; return whether it has, or cannot be used."""
        try:
            version = self._folder.version()
            if version == self._version and not self.problem:
                return False
            allowed = self._folder.allowed()
            self._version, self.problem = version, ""
        except KeyFileError as error:
            allowed, self._version, self.problem = {}, None, str(error)
        self.names = {key: name for name, key in allowed.items()}
        return True
