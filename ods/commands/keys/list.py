"""`ods keys list`: who may listen, and who may veto obstacles."""

from argparse import ArgumentParser, Namespace

from ods.commands.keys.folder import folder_of
from ods.runtime.keys.key_folder import CLIENTS, OPERATORS


def add_arguments(_parser: ArgumentParser) -> None:
    """Add no arguments of its own."""


def run(args: Namespace) -> None:
    """Print public keys; secrets are never printed. Raises OdsError."""
    print(f"{folder_of(args.config).server().public}  this vehicle")
    for who, may in ((CLIENTS, ""), (OPERATORS, ", an operator")):
        folder = folder_of(args.config, who)
        for name, key in folder.allowed().items():
            secret = folder.secret_of(name)
            print(f"{key}  {name}{may}" + (f" (its secret is still here: {secret})" if secret.exists() else ""))
