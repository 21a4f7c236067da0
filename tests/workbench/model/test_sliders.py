"""Controls: each setting of stages and tracker has one, and whatever it gives is a value that the setting takes."""

from typing import Annotated, Any, Literal, get_type_hints

import msgspec
import pytest
from hypothesis import given, strategies as st

from ods.base.settings import NonNegative, OddInt, Positive, Settings, refuse_even, slider
from ods.pipeline.settings import AttentionSettings
from ods.pipeline.stage.params import BUILT_IN
from ods.tracker.settings import TrackerSettings
from ods.workbench.model.paths import tables_of
from ods.workbench.model.sliders import (
    LOG_POSITIONS,
    Choice,
    Control,
    Number,
    Switch,
    Text,
    controls_of,
    text_of,
    value_of,
)

KINDS: list[type[Settings]] = [*BUILT_IN.values(), TrackerSettings, AttentionSettings]
ALL = [(kind, control) for kind in KINDS for control in controls_of(kind)]
NUMBERS = [(kind, control) for kind, control in ALL if isinstance(control.by, Number)]


class Own(Settings, frozen=True):
    """Of a stage of the user's own, without hints."""

    exponent: Positive = 2.0
    """What it says."""
    on: bool = True
    way: Literal["a", "b"] = "b"
    odd: OddInt = 5
    share: Annotated[float, msgspec.Meta(gt=0.0, lt=1.0)] = 0.25
    free: float = 0.0
    offset: NonNegative = 0.0
    below: Annotated[int, msgspec.Meta(le=-3)] = -5
    shown: Annotated[Positive, slider(0.5, 8.0, log=True, unit="m")] = 2.0
    list: tuple[float, ...] = (1.0,)


def takes(kind: type[Settings], path: str, value: Any) -> None:
    """Raise ValueError unless the field of that path takes a value, whatever the others are."""
    *tables, name = path.split(".")
    for table in tables:
        kind = get_type_hints(kind)[table]
    alone = msgspec.defstruct("Alone", [(name, get_type_hints(kind, include_extras=True)[name])], bases=(Settings,),
                              frozen=True, kw_only=True, forbid_unknown_fields=True)  # fmt: skip
    taken = msgspec.convert({name: value}, alone)
    assert isinstance(taken, Settings)
    refuse_even(taken)


def test_every_field_of_every_stage_and_of_the_tracker_has_one_control() -> None:
    for kind in BUILT_IN.values():
        assert [control.path for control in controls_of(kind)] == [item.name for item in msgspec.structs.fields(kind)]
    paths = [control.path for control in controls_of(TrackerSettings)]
    tables = tables_of(TrackerSettings()).items()
    expected = [[f"{key}.{inner}" for inner in value] if isinstance(value, dict) else [key] for key, value in tables]
    assert paths == [path for group in expected for path in group]


@pytest.mark.parametrize(("kind", "control"), ALL, ids=[f"{kind.__name__}.{control.path}" for kind, control in ALL])
def test_defaults_and_ends_pass_and_lie_on_the_slider(kind: type[Settings], control: Control) -> None:
    takes(kind, control.path, control.default)
    assert control.meaning
    if isinstance(control.by, Number):
        low, high = control.by.value_at(0), control.by.value_at(control.by.places - 1)
        takes(kind, control.path, low)
        takes(kind, control.path, high)
        assert low <= control.default <= high
        assert 5 <= control.by.places <= 500
    elif isinstance(control.by, Choice):
        assert control.default in control.by.options
        for option in control.by.options:
            takes(kind, control.path, option)


@given(st.sampled_from(NUMBERS), st.floats(0.0, 1.0))
def test_whatever_a_slider_gives_passes_and_has_its_place(picked: tuple[type[Settings], Control], share: float) -> None:
    kind, control = picked
    assert isinstance(control.by, Number)
    place = round(share * (control.by.places - 1))
    value = control.by.value_at(place)
    takes(kind, control.path, value)
    assert abs(control.by.value_at(control.by.place_of(value)) - value) <= 1e-9 * abs(value)
    if place:
        assert control.by.value_at(place - 1) <= value


@given(st.integers(0, LOG_POSITIONS))
def test_logarithmic_sliders_are_even_in_ratio(place: int) -> None:
    number = Number(0.01, 100.0, 0.0, log=True)
    assert number.value_at(place) == pytest.approx(0.01 * 10.0 ** (4.0 * place / LOG_POSITIONS), rel=5e-3)
    from_zero = Number(0.0, 100.0, 0.01, log=True)
    assert from_zero.value_at(0) == 0.0
    assert from_zero.value_at(1) == 0.01


def test_settings_without_hints_get_controls_by_type_and_default() -> None:
    controls = {control.path: control for control in controls_of(Own)}
    assert controls["exponent"].meaning == "What it says."
    assert isinstance(controls["on"].by, Switch)
    assert controls["way"].by == Choice(("a", "b"))
    assert isinstance(controls["list"].by, Text)
    for control in controls.values():
        if isinstance(control.by, Number):
            for place in range(control.by.places):
                takes(Own, control.path, control.by.value_at(place))
            assert control.by.low <= control.default <= control.by.high
    assert controls["shown"].by == Number(0.5, 8.0, 0.0375, log=True, unit="m")
    assert controls_of(Own, {"way": ["a", "b", "c"]})[2].by == Choice(("a", "b", "c"))


@pytest.mark.parametrize("value", [(), [1.0, 2.5], "text", None, 3, {"a": 1}])
def test_texts_come_back(value: Any) -> None:
    assert value_of(text_of(value)) == msgspec.to_builtins(value) or value == ()


def test_what_is_no_json_is_a_text() -> None:
    assert value_of("my_stage") == "my_stage"
