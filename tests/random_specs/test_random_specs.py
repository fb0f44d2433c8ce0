"""Random specs over the whole language: C equals the integer program, which keeps what its certificate promises."""

from __future__ import annotations

from pathlib import Path

import pytest

from fuzzyspec import SpecError, load
from tests.random_specs.agreement import examine
from tests.random_specs.generator import spec

SHORT, LONG = range(24), range(24, 324)
ABOVE_32_BITS = {"FZ450", "FZ451"}
"""What a sound spec may be refused for: its numbers do not go."""


def agrees(seed: int, folder: Path, cases: int) -> None:
    """The spec of a seed compiles and does what it says; a failure names the seed and keeps the text."""
    text = spec(seed)
    file = folder / f"spec{seed}.fz"
    file.write_text(text)
    try:
        examine(load(file), seed, cases)
    except SpecError as error:
        codes = {d.code for d in error.diagnostics if d.severity == "error"}
        assert codes <= ABOVE_32_BITS, f"seed {seed} ({file}) was refused: {error}"
    except Exception as error:
        raise AssertionError(f"seed {seed} ({file}): {error}") from error


@pytest.mark.parametrize("seed", SHORT)
def test_random_spec(seed: int, tmp_path: Path) -> None:
    """A random spec holds: C is the program bit for bit, the program within its bounds, bands and intervals."""
    agrees(seed, tmp_path, 800)


@pytest.mark.long
@pytest.mark.parametrize("seed", LONG)
def test_random_spec_long(seed: int, tmp_path: Path) -> None:
    """As the short one, with more cases."""
    agrees(seed, tmp_path, 3000)


def test_few_random_specs_are_refused() -> None:
    """The generator writes valid specs: of fifty that no other test looks at, the checker takes all."""
    for seed in range(1000, 1050):
        try:
            load(spec(seed))
        except SpecError as error:
            pytest.fail(f"seed {seed}: {error}")
