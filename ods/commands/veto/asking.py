"""Common parts of the actions of `ods veto`: key, reason, duration; the request; the vetoes in force after it."""

import re
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from datetime import UTC, datetime
from pathlib import Path

from ods.base.clock import NS
from ods.base.settings_file import load
from ods.client import Veto, Vetoes, VetoRequest
from ods.config import OnboardConfig
from ods.messages import LONGEST_VETO_S

_TIME = re.compile(r"(?P<number>\d+(\.\d+)?)(?P<unit>[smh])")
_UNIT_S = {"s": 1.0, "m": 60.0, "h": 3600.0}


def duration_s(text: str) -> float:
    """Return 90s, 10m or 2h, s."""
    found = _TIME.fullmatch(text)
    seconds = float(found["number"]) * _UNIT_S[found["unit"]] if found else 0.0
    if not 0.0 < seconds <= LONGEST_VETO_S:
        raise ArgumentTypeError(
            f"{text!r} is not a duration such as 90s, 10m or 2h, at most {LONGEST_VETO_S / 3600.0:g}h"
        )
    return seconds


def add_key(parser: ArgumentParser) -> None:
    """Whose."""
    parser.add_argument("--key", type=Path, required=True, metavar="FILE", help="the operator's secret: `ods keys`")


def add_reason(parser: ArgumentParser) -> None:
    """Whose, and why."""
    add_key(parser)
    parser.add_argument("--reason", required=True, metavar="TEXT")


def add_time(parser: ArgumentParser) -> None:
    """How long."""
    parser.add_argument("--for", dest="for_s", type=duration_s, required=True, metavar="TIME", help="90s, 10m, 2h")


def ask(args: Namespace, request: VetoRequest) -> None:
    """Send a request; print what holds. Raises OdsError."""
    vetoes = Vetoes(load(args.config, OnboardConfig).bus.run_dir, args.key)
    try:
        held = vetoes.ask(request)
    finally:
        vetoes.close()
    print("\n".join(map(_line, held)) or "no veto is in force")


def _line(veto: Veto) -> str:
    until = datetime.fromtimestamp(veto.until_utc_ns / NS, UTC)
    return f"veto {veto.number}: {_meant(veto)} until {until:%H:%M:%S} UTC, by {veto.author}: {veto.reason}"


def _meant(veto: Veto) -> str:
    region = veto.region
    if region.centre_ne is None:
        where = f"a polygon of {len(region.corners_ne)} corners"
    else:
        where = f"{region.radius_m:.1f} m around {region.centre_ne[0]:.1f} {region.centre_ne[1]:.1f} m north east"
    return f"static obstacles in {where}" if veto.id is None else f"obstacle {veto.id} within {where}"
