"""`ods set-sonar`: sets the sonar's range, power or gain, or shows them."""

from argparse import ArgumentParser, Namespace

from ods.base.command_line.arguments import number
from ods.base.settings_file import load
from ods.client import Sonar, SonarRequest
from ods.config import OnboardConfig

DECIBELS = number(-200.0, 300.0, "dB")


def add_arguments(parser: ArgumentParser) -> None:
    """Add the settings; those not given are not changed."""
    parser.add_argument("--range", type=number(0.1, 20_000.0, "metres"), metavar="METRES")
    parser.add_argument("--power", type=DECIBELS, metavar="DB", help="re 1 uPa at 1 m")
    parser.add_argument("--gain", type=DECIBELS, metavar="DB")


def run(args: Namespace) -> None:
    """Send the request; print the settings that the sonar reports. Raises OdsError."""
    sonar = Sonar(load(args.config, OnboardConfig).bus.run_dir)
    try:
        says = sonar.ask(SonarRequest(range_m=args.range, power_db=args.power, gain_db=args.gain))
    finally:
        sonar.close()
    print(f"the sonar reports: range {says.range_m} m, power {says.power_db} dB, gain {says.gain_db} dB")
