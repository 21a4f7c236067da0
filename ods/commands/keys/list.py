"""`ods keys list`: who may listen."""

from argparse import ArgumentParser, Namespace

from ods.commands.keys.folder import folder_of


def add_arguments(_parser: ArgumentParser) -> None:
    """It has none of its own."""


def run(args: Namespace) -> None:
    """Print public keys; secrets are never printed. Raises OdsError."""
    folder = folder_of(args.config)
    print(f"{folder.server().public}  this vehicle")
    for name, key in folder.allowed().items():
        waits = f" (its secret is still here: {folder.secret_of(name)})" if folder.secret_of(name).exists() else ""
        print(f"{key}  {name}{waits}")
