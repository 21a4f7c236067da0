"""Tables of echoes: parted, and read row by row."""

import numpy as np

from ods.pipeline.measure.echoes import ECHO, ROW, EchoTable, Wanted, split_faint

RANGES_M = 5.0, 10.0, 15.0, 20.0, 25.0
FRONTS = 0.9, 0.1, 0.9, 0.1, 0.9
FAINT = False, False, True, True, True


def table() -> EchoTable:
    echoes = np.zeros(len(RANGES_M), ECHO)
    echoes["range_m"], echoes["front"], echoes["cut"], echoes["cells"] = RANGES_M, FRONTS, FAINT, range(5)
    return echoes


def test_rows_are_read_as_numpy_reads_them() -> None:
    echoes = np.frombuffer(np.random.default_rng(0).bytes(50 * ECHO.itemsize), ECHO).copy()
    for name, (kind, *_) in (ECHO.fields or {}).items():
        if kind == np.float64:
            echoes[name] = np.random.default_rng(1).normal(size=50)
    echoes["cut"] = np.arange(50) % 2 == 0
    rows = list(ROW.iter_unpack(echoes.tobytes()))
    assert rows == echoes.tolist()
    assert [list(map(type, row)) for row in rows] == [list(map(type, row)) for row in echoes.tolist()]


def test_echoes_are_parted_by_range_and_the_faint_ones_by_their_fronts() -> None:
    strong, faint = split_faint(table(), np.array(FAINT), Wanted(10.0, 25.0, 0.12))
    assert strong["range_m"].tolist() == [10.0]
    assert faint["range_m"].tolist() == [15.0]


def test_without_faint_ones_all_in_the_ranges_are_echoes() -> None:
    strong, faint = split_faint(table(), None, Wanted(0.0, 20.0, 0.12))
    assert strong["range_m"].tolist() == [5.0, 10.0, 15.0]
    assert not faint.size
