"""Settings of all tests."""

import os

from hypothesis import HealthCheck, settings

# No test depends on how fast the machine is; the checks run the same examples every time.
settings.register_profile(
    "fivtui",
    deadline=None,
    derandomize="CI" in os.environ,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("fivtui")
