"""A value's type has the same name without numba as numba's type of it."""

from typing import Any, NamedTuple

import numba
import numpy as np
import pytest

from ods.compiled.type_names import name_of_type, name_of_value, shape_of_values

typeof: Any = numba.typeof


class Record(NamedTuple):
    """Arrays and a number."""

    rows: Any
    number: Any


READ_ONLY = np.zeros((2, 3), np.uint8)
READ_ONLY.flags.writeable = False
UNALIGNED = np.zeros(17, np.uint8)[1:].view(np.float64)
VALUES = [
    1,
    -1,
    2**63,
    0.5,
    True,
    None,
    np.float32(1.0),
    np.float64(1.0),
    np.int64(1),
    np.bool_(True),
    np.zeros(3),
    np.zeros(3, np.float32)[::2],
    np.zeros((3, 4), np.int32).T,
    np.zeros((3, 4, 5), bool)[:, ::2],
    READ_ONLY,
    READ_ONLY[:, 1:],
    UNALIGNED,
    (1, 2.0),
    (np.zeros(2), np.zeros(2)),
    Record(np.zeros((1, 3)), 0),
    np.zeros(3, np.dtype([("number", np.int32), ("level", np.float64)], align=True)),
    np.zeros(3, np.dtype([("number", np.int32), ("level", np.float64)])),
    Record(np.zeros((3, 4)).T, Record(True, np.ones(2))),
]


@pytest.mark.parametrize("value", VALUES, ids=repr)
def test_the_name_is_that_of_numbas_type(value: Any) -> None:
    assert name_of_value(value) == name_of_type(typeof(value))


def test_values_of_one_shape_have_one_name() -> None:
    names: dict[Any, str] = {}
    for value in VALUES:
        if value is not VALUES[2]:  # numbers as large as that are no argument of a kernel
            assert names.setdefault(shape_of_values((value,)), name_of_value(value)) == name_of_value(value)
