"""Runs the generated C on this machine: finds a compiler, builds, loads, and evaluates batches of raws."""

from __future__ import annotations

from fuzzyspec.native.layout import Result
from fuzzyspec.native.module import NativeModule
from fuzzyspec.native.process import Death, NativeProcess
from fuzzyspec.native.toolchain import BuildError, Toolchain, find_toolchain

__all__ = [
    "BuildError",
    "Death",
    "NativeModule",
    "NativeProcess",
    "Result",
    "Toolchain",
    "find_toolchain",
]
