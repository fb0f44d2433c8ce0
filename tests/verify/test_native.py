"""The host build: compilers found, C built and loaded, batches in and out."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import numpy as np
import pytest

from fuzzyspec import fixed
from fuzzyspec.diagnostics.refusal import MissingTool
from fuzzyspec.fixed.program import Program
from fuzzyspec.native import BuildError, Death, NativeModule, NativeProcess, find_toolchain
from fuzzyspec.native.toolchain import Toolchain
from tests.conftest import without


def _cases(n: int = 500) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    draw = np.random.default_rng(1)
    inputs = {
        "offset": draw.integers(-1000, 1001, n),
        "items.count": draw.integers(0, 256, n),
        "items.value": draw.integers(0, 256, (n, 3)),
    }
    return inputs, {"total": draw.integers(0, 256, n)}


@pytest.mark.parametrize("kind", ["module", "process", "sanitized"])
def test_c_and_program_agree_over_a_batch(kind: str, sums: Program, sums_files: dict[str, bytes]) -> None:
    """Scalars, lists past their capacity, status and state pass through every kind of build as through the model."""
    inputs, state = _cases()
    wanted = fixed.run(sums, "sums", inputs, state)
    if kind == "module":
        with NativeModule(sums, sums_files) as module:
            got = module.run("sums", inputs, state)
            assert module.selftest() == 0
    else:
        with NativeProcess(sums, sums_files, sanitize=kind == "sanitized") as process:
            ran = process.run("sums", inputs, state)
            assert not isinstance(ran, Death)
            got = ran
            assert process.selftest() == 0
            assert bool(process.sanitizers) == (kind == "sanitized")
    np.testing.assert_array_equal(got.outputs["total"], wanted.outputs["total"])
    np.testing.assert_array_equal(got.status, wanted.status)
    np.testing.assert_array_equal(got.state["total"], wanted.state["total"])


def test_the_first_state_is_the_default(sums: Program, sums_files: dict[str, bytes]) -> None:
    """Without a state each case starts from what init stores."""
    with NativeModule(sums, sums_files) as module:
        got = module.run("sums", {"offset": [0], "items.count": [0], "items.value": np.zeros((1, 0), dtype=int)})
    assert got.outputs["total"][0] == 1007


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"offset": None}, "wants an input `offset`"),
        ({"other": np.zeros(4, dtype=int)}, "no input `other`"),
        ({"offset": np.zeros(3, dtype=int)}, "shape"),
        ({"offset": np.zeros(4)}, "wants integers"),
        ({"offset": np.full(4, 40000)}, "outside int16_t"),
        ({"items.count": np.full(4, 3)}, "hold 2 elements"),
    ],
)
def test_wrong_inputs_are_named(
    change: dict[str, np.ndarray | None], message: str, sums: Program, sums_files: dict[str, bytes]
) -> None:
    """A signal that is missing, unknown, of the wrong shape or type is a ValueError that names it."""
    inputs = {
        "offset": np.zeros(4, dtype=int),
        "items.count": np.ones(4, dtype=int),
        "items.value": np.ones((4, 2), dtype=int),
    }
    given = {k: v for k, v in {**inputs, **change}.items() if v is not None}
    with NativeModule(sums, sums_files) as module, pytest.raises(ValueError, match=message):
        module.run("sums", given)


def test_out_of_bounds_is_a_death_with_its_case(sums: Program, sums_files: dict[str, bytes]) -> None:
    """Reading a record past the count is caught by the sanitizers, at the case that did it."""
    sums_files["sums.c"] = sums_files["sums.c"].replace(b"i < count", b"i <= count")
    counts = np.array([3, 0, 2, 1])
    inputs = {"offset": np.zeros(4, dtype=int), "items.count": counts, "items.value": np.ones((4, 3), dtype=int)}
    with NativeProcess(sums, sums_files, sanitize=True) as process:
        if "address" not in process.sanitizers:
            without("this compiler has no address sanitizer")
        ran = process.run("sums", inputs)
    assert isinstance(ran, Death)
    assert ran.case == 0
    assert "address sanitizer: heap-buffer-overflow" in ran.what


def test_endless_loops_end(sums: Program, sums_files: dict[str, bytes]) -> None:
    """C that does not come back is stopped, and the case is known."""
    sums_files["sums.c"] = sums_files["sums.c"].replace(b"uint8_t i;", b"uint8_t i;\n    while (in->offset == 5) { }")
    inputs = {"offset": [1, 2, 5, 3], "items.count": [0] * 4, "items.value": np.ones((4, 3), dtype=int)}
    with NativeProcess(sums, sums_files, seconds=1.0) as process:
        ran = process.run("sums", inputs)
    assert ran == Death(2, "no end after 1 s", "")


def test_crashes_are_told(sums: Program, sums_files: dict[str, bytes]) -> None:
    """A crash names its signal and its case."""
    sums_files["sums.c"] = sums_files["sums.c"].replace(
        b"uint8_t i;", b"uint8_t i;\n    if (in->offset == 2) { *(volatile int *)0 = 1; }"
    )
    inputs = {"offset": [1, 2, 5, 3], "items.count": [0] * 4, "items.value": np.ones((4, 3), dtype=int)}
    with NativeProcess(sums, sums_files, warnings_are_errors=False) as process:
        ran = process.run("sums", inputs)
    assert isinstance(ran, Death)
    assert (ran.case, ran.what) == (1, "crashed with SIGSEGV")


def test_rejected_c_carries_the_compilers_words(sums: Program, sums_files: dict[str, bytes]) -> None:
    """What does not compile is a BuildError with the compiler's message, and names no temporary folder."""
    sums_files["sums.c"] = sums_files["sums.c"].replace(b"return status;", b"return statsu;")
    with pytest.raises(BuildError) as caught:
        NativeModule(sums, sums_files)
    assert "statsu" in caught.value.output
    assert tempfile.gettempdir() not in caught.value.output


def test_temporary_folders_vanish(
    sums: Program, sums_files: dict[str, bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A temporary folder with spaces in its name works, and nothing is left in it."""
    folder = tmp_path / "with some spaces"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    inputs, state = _cases(3)
    with NativeModule(sums, sums_files) as module, NativeProcess(sums, sums_files) as process:
        module.run("sums", inputs, state)
        assert not isinstance(process.run("sums", inputs, state), Death)
    assert list(folder.iterdir()) == []


def test_a_missing_compiler_says_how_to_get_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No compiler at all, and a CC that is not there, are MissingTool with the way out."""
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(MissingTool, match="pip install ziglang"):
        find_toolchain({"PATH": str(tmp_path)})
    with pytest.raises(MissingTool, match="CC names `nothing-here`"):
        find_toolchain({"PATH": os.environ["PATH"], "CC": "nothing-here -m32"})


def test_cc_comes_first(tmp_path: Path) -> None:
    """CC may hold flags, and beats what is on the path."""
    for name in ("gcc", "mycc"):
        (tmp_path / name).write_text("#!/bin/sh\n")
        (tmp_path / name).chmod(0o755)
    assert find_toolchain({"PATH": str(tmp_path), "CC": "mycc -m32"}) == Toolchain(("mycc", "-m32"))
    assert find_toolchain({"PATH": str(tmp_path)}) == Toolchain(("gcc",))


def test_builds_agree_on_the_blocks_they_make_up(sums: Program, sums_files: dict[str, bytes]) -> None:
    """Two builds hash the same cases alike, and a fault in one shows in the hashes of the blocks that reach it."""
    faulty = dict(sums_files, **{"sums.c": sums_files["sums.c"].replace(b"& 1023u", b"& 511u")})
    blocks = range(2, 12)
    with NativeModule(sums, sums_files) as module, NativeProcess(sums, sums_files) as process:
        hashes = module.hashes("sums", 3, blocks, 64)
        assert process.hashes("sums", 3, blocks, 64) == hashes
        assert module.hashes("sums", 4, blocks, 64) != hashes
    assert len(set(hashes)) == len(blocks)
    with NativeProcess(sums, faulty) as process:
        assert process.hashes("sums", 3, blocks, 64) != hashes


def test_a_block_can_be_looked_into(sums: Program, sums_files: dict[str, bytes]) -> None:
    """Its cases are raws of the C types, its states legal, its counts past the capacity now and then."""
    with NativeModule(sums, sums_files) as module:
        drawn = [module.block("sums", 1, block, 256) for block in range(8)]
        for inputs, state in drawn:
            assert module.run("sums", inputs, state).status.shape == (256,)
    offsets = np.concatenate([inputs["offset"] for inputs, _ in drawn])
    assert offsets.min() < -1000 and offsets.max() > 1000
    assert 0.9 < np.mean(np.abs(offsets) <= 1000) < 1
    assert all(state["total"].min() >= 0 and state["total"].max() <= 255 for _, state in drawn)
    assert drawn[0][0]["items.value"].shape == (256, 2)
    assert drawn[0][0]["items.count"].max() == 2
    assert drawn[7][0]["items.count"].max() > 3


def test_a_death_in_bulk_names_its_case(sums: Program, sums_files: dict[str, bytes]) -> None:
    """The case counts from the first block that was asked for."""
    whole = dict(sums_files)
    sums_files["sums.c"] = sums_files["sums.c"].replace(
        b"uint8_t i;", b"uint8_t i;\n    if (in->offset > 30000) { *(volatile int *)0 = 1; }"
    )
    with NativeProcess(sums, sums_files, warnings_are_errors=False) as process:
        death = process.hashes("sums", 1, range(50), 64)
        assert isinstance(death, Death)
    with NativeModule(sums, whole) as module:
        inputs, _ = module.block("sums", 1, death.case // 64, 64)
    assert inputs["offset"][death.case % 64] > 30000
