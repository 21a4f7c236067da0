"""A menu that cannot be built."""

from ods.workbench.session import Session


def build(_: Session) -> None:
    raise ValueError("no such\nthing")
