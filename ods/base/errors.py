"""The one error that the `ods` command turns into a line and exit code 2."""


class OdsError(Exception):
    """Something the user can put right: a bad file, key, device or option. Its text is one line."""
