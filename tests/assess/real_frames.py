"""Real frames and their labels; those were drawn by eye, of things that nobody knows the truth of."""

REAL = {
    "tests/data/aris/sample.aris": "tests/data/labels/aris_sample.txt",
    "tests/data/oculus/three_pings_8bit.raw": "tests/data/labels/oculus_three_pings.txt",
}
