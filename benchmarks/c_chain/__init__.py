"""ODS's chain beside one written in plain C: `python -m benchmarks.c_chain`."""
