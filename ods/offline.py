"""`ods detect` and `ods track`: the same code as on board, on recorded files."""

import sys
from pathlib import Path

from ods.config import OnboardConfig
from ods.errors import OdsError
from ods.settings_file import load
