"""Writes the C of two filters of one row of cells: nine-tap FIR and median of nine (rows.h, which sonar.c includes)."""

from benchmarks.c_chain.networks import RUNS, WINDOW, Cell, Operation, Step, median_of_window, sorted_run

BLOCK = 128
"""Cells whose sorted runs are kept at a time."""
LANES = {"__AVX512F__": 16, "__AVX2__": 8, "": 4}
"""Numbers that the processor's widest registers hold, by what the compiler defines; "": else."""
SUMS = 8
"""Registers of sums that are filled together."""


def rows_h() -> str:
    """Return the header."""
    parts = ["#define MIN(a, b) ((a) < (b) ? (a) : (b))", "#define MAX(a, b) ((a) < (b) ? (b) : (a))", *_median_row()]
    for number, (macro, lanes) in enumerate(LANES.items()):
        parts += [f"#{'elif' if number else 'if'} defined({macro})" if macro else "#else", *_fir_row(lanes)]
    return "\n".join([*parts, "#endif", ""])


def _median_row() -> list[str]:
    """Return a function that fills out (count,) with the medians of padded (count + 8)."""
    lines = [
        "static void median_row(const float *restrict padded, float *restrict out, long count)", "{",
        *(f"    float run{length}[{length}][{BLOCK + 64}] __attribute__((aligned(64)));" for length in RUNS),
        f"    for (long begin = 0; begin < count; begin += {BLOCK}) {{",
        f"        const long cells = count - begin < {BLOCK} ? count - begin : {BLOCK};",
        "        const float *restrict run1 = padded + begin;",
        "        float *restrict median = out + begin;",
    ]  # fmt: skip
    for length in RUNS:
        targets = [f"run{length}[{member}][j]" for member in range(length)]
        lines += _loop(f"cells + {WINDOW - length}", sorted_run(length), targets)
    return [*lines, *_loop("cells", median_of_window(), ["median[j]"]), "    }", "}"]


def _loop(count: str, step: Step, targets: list[str]) -> list[str]:
    lines = [f"        for (long j = 0; j < {count}; j++) {{"]
    lines += [f"            const float v{one.result} = {_value(one)};" for one in step.operations]
    lines += [f"            {target} = v{result};" for target, result in zip(targets, step.results, strict=True)]
    return [*lines, "        }"]


def _value(one: Operation) -> str:
    if isinstance(one.what, Cell):
        run, member, shift = one.what
        return f"run1[j + {shift}]" if run == 1 else f"run{run}[{member}][j + {shift}]"
    return f"{one.what.upper()}(v{one.of[0]}, v{one.of[1]})"


def _fir_row(lanes: int) -> list[str]:
    """Return a function that fills out (count,) with the weighted means of padded (count + 8).

    What is read from one place serves all taps that are a whole register apart.
    """
    vector = f"typedef float Lanes __attribute__((vector_size({4 * lanes}), aligned(4), may_alias));"
    head = "static void fir_row(const float *restrict padded, float *restrict out, long count, const float *tap)"
    lines = [vector, head, "{", "    long i = 0;", f"    for (; i + {lanes * SUMS} <= count; i += {lanes * SUMS}) {{"]
    lines += [f"        Lanes sum{k} = {{0}};" for k in range(SUMS)]
    for shift in range(min(lanes, WINDOW)):
        taps = range(shift, WINDOW, lanes)
        for k in range(SUMS + len(taps) - 1):
            lines += ["        {", f"            const Lanes x = *(const Lanes *)(padded + i + {shift + lanes * k});"]
            for number, tap in enumerate(taps):
                if 0 <= k - number < SUMS:
                    lines.append(f"            sum{k - number} += tap[{tap}] * x;")
            lines.append("        }")
    lines += [f"        *(Lanes *)(out + i + {lanes * k}) = sum{k};" for k in range(SUMS)]
    return [
        *lines, "    }", "    for (; i < count; i++) {", "        float sum = 0.0f;",
        f"        for (int k = 0; k < {WINDOW}; k++)", "            sum += tap[k] * padded[i + k];",
        "        out[i] = sum;", "    }", "}",
    ]  # fmt: skip
