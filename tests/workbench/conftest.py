"""NiceGUI reads where it would store when it is imported: nowhere. What users keep is kept in a folder of the tests."""

import os
from pathlib import Path

import pytest

from ods.workbench.command import NO_STORAGE

os.environ["NICEGUI_STORAGE_PATH"] = str(NO_STORAGE)


@pytest.fixture(scope="session", autouse=True)
def _own_data(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Keep uploads and the list of recent files away from the user's."""
    os.environ["ODS_DATA_DIR"] = str(tmp_path_factory.mktemp("user"))


@pytest.fixture
def own_data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a user's folder of data of this test alone."""
    folder = tmp_path / "user"
    folder.mkdir()
    monkeypatch.setenv("ODS_DATA_DIR", str(folder))
    return folder / "ods"
