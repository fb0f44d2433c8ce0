"""The one registry of diagnostic codes, joined from one file per hundred."""

from __future__ import annotations

from fuzzyspec.diagnostics import codes_budgets, codes_internal, codes_names, codes_numbers, codes_rules, codes_syntax
from fuzzyspec.diagnostics.code import Code

__all__ = ["REGISTRY", "Code"]

_ALL: tuple[Code, ...] = (
    *codes_syntax.CODES,
    *codes_names.CODES,
    *codes_rules.CODES,
    *codes_numbers.CODES,
    *codes_budgets.CODES,
    *codes_internal.CODES,
)

REGISTRY: dict[str, Code] = {code.code: code for code in _ALL}
"""Every code that a diagnostic may carry."""

if len(REGISTRY) != len(_ALL):
    raise ImportError("a diagnostic code is registered twice")
