"""For all tests: hypothesis without deadlines, as first calls compile, and the same in CI; unknown counters refused."""

import os

from hypothesis import settings

from ods.runtime import counters

os.environ[counters.REFUSE] = "1"  # for the processes that tests start, too

settings.register_profile("ods", deadline=None, derandomize=True)
settings.load_profile("ods")
