"""One hypothesis profile for everybody: the same examples on every machine, no clock, no database on disk."""

from hypothesis import HealthCheck, settings

settings.register_profile(
    "fuzzyc",
    derandomize=True,
    deadline=None,
    database=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("fuzzyc")
