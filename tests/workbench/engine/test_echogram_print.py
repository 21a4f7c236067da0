"""An echogram on paper: the format that was asked for, with the configuration's hash, in the right folder."""

import math
from pathlib import Path

import msgspec
import pytest
from PIL import Image

from ods.base.errors import OdsError
from ods.workbench.engine.echogram.layers import Layers, Span, layers_of
from ods.workbench.engine.echogram.paper import print_echogram
from ods.workbench.engine.files.prints import config_hash
from ods.workbench.model.state import State, View
from tests.workbench.engine.test_echogram_layers import echogram
from tests.workbench.pages.test_observer_views import ONE, tracked

WHOLE = echogram(-math.pi, math.pi)
LAYERS = msgspec.structs.replace(
    layers_of(tracked({4: ONE}), WHOLE, None), faults=[Span(3, 3, "1 ping missing")], invalid=[Span(0, 2, "no pose")]
)


def test_what_is_switched_on_is_drawn(tmp_path: Path) -> None:
    def drawn(view: View, layers: Layers = LAYERS) -> str:
        file = tmp_path / "e.svg"
        print_echogram(WHOLE, layers, State(view=view), file, [tmp_path], name="made up", style="light")
        return file.read_text()

    text = drawn(View())
    for word in ("<!-- detection -->", "<!-- stand-by -->", "<!-- image -->", "<!-- list -->"):
        assert word in text
    assert f"configuration {config_hash(State().tuning)}" in text
    bare = drawn(View(echogram_layers=("tracks",)))
    assert "<!-- detection -->" not in bare
    assert "<!-- list -->" not in bare
    assert "<!-- stand-by -->" in bare
    assert "<!-- detection -->" not in drawn(View(), Layers())  # nothing was tracked


def test_a_picture_has_its_caption_and_goes_nowhere_else(tmp_path: Path) -> None:
    file = print_echogram(WHOLE, LAYERS, State(), tmp_path / "e.png", [tmp_path], name="made up", style="dark")
    with Image.open(file) as picture:
        assert picture.info["Title"] == f"made up: 8 pings; configuration {config_hash(State().tuning)}"
    with pytest.raises(OdsError):
        print_echogram(WHOLE, LAYERS, State(), tmp_path / ".." / "e.png", [tmp_path], name="x", style="dark")
