"""NiceGUI reads where it would store when it is imported: nowhere."""

import os

from ods.workbench.command import NO_STORAGE

os.environ["NICEGUI_STORAGE_PATH"] = str(NO_STORAGE)
