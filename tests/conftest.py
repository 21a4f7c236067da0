"""Settings of hypothesis for all tests: first calls compile, and CI repeats to the letter."""

from hypothesis import settings

settings.register_profile("ods", deadline=None, derandomize=True)
settings.load_profile("ods")
