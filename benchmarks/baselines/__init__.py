"""Plain C behind the interface of the generated C, made from the checked model: what fuzzyc is measured against."""

from __future__ import annotations

from benchmarks.baselines.float_c import SAMPLES, float_c
from benchmarks.baselines.interface import DoesNotFit
from benchmarks.baselines.lookup import Lookup, lookup_c, lookup_of

__all__ = ["SAMPLES", "DoesNotFit", "Lookup", "float_c", "lookup_c", "lookup_of"]
