"""What tests of missions share."""

from pathlib import Path

import pytest


@pytest.fixture
def campaign(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """The file of the test module's CAMPAIGN."""
    file = tmp_path / "campaign.toml"
    file.write_text(request.module.CAMPAIGN)
    return file
