"""What all tests share: one hypothesis profile, and what becomes of a test whose tool is missing.

The profile gives the same examples on every machine, no clock, no database on disk.
"""

from __future__ import annotations

import os
import shutil
from importlib import import_module
from typing import Any, NoReturn

import pytest
from hypothesis import HealthCheck, settings

settings.register_profile(
    "fuzzyc",
    derandomize=True,
    deadline=None,
    database=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("fuzzyc")


def without(reason: str) -> NoReturn:
    """Skip the test for what is not installed; fail it where all tools are to be there (FUZZYC_TOOLS=required)."""
    if os.environ.get("FUZZYC_TOOLS") == "required":
        pytest.fail(f"{reason}, and FUZZYC_TOOLS=required", pytrace=False)
    pytest.skip(reason)


def required_tool(name: str) -> str:
    """The path of a program that the test cannot do without."""
    return shutil.which(name) or without(f"{name} is not installed")


def required_package(name: str) -> Any:
    """The Python package that the test cannot do without."""
    try:
        return import_module(name)
    except ImportError:
        without(f"the package {name} is not installed")
