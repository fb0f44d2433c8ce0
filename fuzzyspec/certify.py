"""Certificates of verifications: made with a spec at hand, checked again with nothing but the certificate."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fuzzyspec.api import Spec, accept, beside

if TYPE_CHECKING:
    from fuzzyspec.verify import Report, Sweep
    from fuzzyspec.verify.evidence import Asked

__all__ = ["certify", "recheck"]

Progress = Callable[[int, int, str], None]


def certify(
    spec: Spec,
    asked: Asked,
    c: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
    sweep: Sweep | None = None,
) -> tuple[Report, dict[str, Any]]:
    """Verify as asked, and give the report with the certificate: what was shown, and how.

    ``c``: a C file to verify instead of the generated one. ``sweep``: how every input is to be tried, where that is
    asked for, and otherwise than by default. Raises as ``Spec.verify``, and MissingTool where a machine that is asked
    for cannot be run.
    """
    from fuzzyspec.lower import Options
    from fuzzyspec.verify import LEVELS, Sweep, find_machines
    from fuzzyspec.verify.evidence import Verified, document

    tolerance = spec.tolerance if asked.tolerance is None else Fraction(asked.tolerance)
    options = Options(asked.bounds, asked.optimize, asked.chosen_for, tolerance=tolerance)
    levels = LEVELS if asked.levels is None else asked.levels
    wanted = (asked.targets, levels, asked.compiler, asked.target_cases, asked.emulator)
    machines = find_machines(*wanted) if asked.targets else None
    report = spec.verify(
        seed=asked.seed,
        cases=asked.cases,
        only=asked.only,
        c=c,
        sanitize=asked.sanitize,
        worst=asked.worst,
        options=options,
        machines=machines,
        sweep=(sweep or Sweep()) if asked.exhaustive else None,
        progress=progress,
    )
    files = spec.compile(options).files
    verified = Verified(spec.source, files if c is None else beside(Path(c), tuple(files), spec.name), c is not None)
    asked = replace(asked, tolerance=None if tolerance is None else str(tolerance))
    return report, document(verified, asked, report)


def recheck(certificate: Any, progress: Progress | None = None) -> tuple[list[str], list[str]]:
    """Run a certificate's verification again, from what the certificate holds.

    Gives what of it does not hold any more (nothing, if all is well), and what else is other than it was. Raises
    Refusal for what is no certificate or was altered, SpecError where its spec is not accepted any more, and as
    ``certify``.
    """
    from fuzzyspec.verify.evidence import differences, opened

    verified, asked = opened(certificate)
    spec = accept(verified.source)
    with tempfile.TemporaryDirectory(prefix="fuzzyc-") as folder:
        for name, content in verified.c.items():
            (Path(folder) / name).write_bytes(content)
        c = Path(folder) / f"{spec.name}.c" if verified.theirs else None
        _, again = certify(spec, asked, c, progress)
    return differences(certificate, again)
