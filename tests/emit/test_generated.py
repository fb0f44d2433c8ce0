"""The committed C of the examples is what the compiler gives today, and every compiler takes it."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

import fuzzyspec
from fuzzyspec.emit import stale, write
from tests.conftest import required_tool, without

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = sorted(p.stem for p in (ROOT / "examples").glob("*.fz"))
WARNINGS = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wsign-conversion", "-Wshadow", "-Werror"]
BUILDS = {
    "gcc": ["gcc", "-std=c99", "-O2"],
    "clang": ["clang", "-std=c99", "-O2"],
    "g++": ["g++", "-x", "c++"],
    "avr-gcc": ["avr-gcc", "-mmcu=atmega328p", "-std=c99", "-Os"],
}


@pytest.mark.parametrize("name", EXAMPLES)
def test_generated_files_are_fresh(name: str) -> None:
    """``make generated`` would change nothing, and nothing else lies in the folder."""
    plan = fuzzyspec.load(ROOT / "examples" / f"{name}.fz").compile()
    folder = ROOT / "generated" / name
    assert stale(plan, folder) == [], "run `make generated`"
    assert sorted(p.name for p in folder.iterdir()) == list(plan.files)


@pytest.mark.parametrize("build", BUILDS)
@pytest.mark.parametrize("name", EXAMPLES)
def test_generated_files_compile_without_a_word(name: str, build: str, tmp_path: Path) -> None:
    """Each file compiles by itself under strict flags, as C99 and as C++, where int has 16 bits too."""
    required_tool(BUILDS[build][0])
    for source in sorted((ROOT / "generated" / name).glob("*.c")):
        line = [*BUILDS[build], *WARNINGS, "-c", str(source), "-o", str(tmp_path / "x.o")]
        done = subprocess.run(line, capture_output=True, text=True, check=False)
        assert done.returncode == 0 and done.stderr == "", done.stderr


@pytest.mark.parametrize("build", BUILDS)
@pytest.mark.parametrize("spec", sorted((ROOT / "tests" / "fixtures").glob("ok_*.fz")), ids=lambda p: p.stem)
def test_good_fixtures_compile_without_a_word(spec: Path, build: str, tmp_path: Path) -> None:
    """So does the C of every good spec of the test suite, names and raw types of all kinds."""
    required_tool(BUILDS[build][0])
    plan = fuzzyspec.load(spec).compile()
    write(plan, tmp_path)
    for source in sorted(tmp_path.glob("*.c")):
        line = [*BUILDS[build], *WARNINGS, "-c", source.name, "-o", "x.o"]
        done = subprocess.run(line, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0 and done.stderr == "", done.stderr


@pytest.mark.parametrize("level", ["-O0", "-O3"])
@pytest.mark.parametrize("name", EXAMPLES)
def test_the_selftest_passes(name: str, level: str, tmp_path: Path) -> None:
    """The committed self-test, linked with the committed source, finds no vector that differs."""
    compiler = next((c for c in ("gcc", "clang", "cc") if shutil.which(c)), None)
    if compiler is None:
        without("no C compiler is installed")
    folder = ROOT / "generated" / name
    (tmp_path / "main.c").write_text(f'#include "{name}.h"\nint main(void) {{ return {name}_selftest() != 0U; }}\n')
    sources = [str(p) for p in sorted(folder.glob("*.c"))]
    line = [compiler, "-std=c99", level, f"-I{folder}", str(tmp_path / "main.c"), *sources, "-o", str(tmp_path / "t")]
    subprocess.run(line, check=True)
    assert subprocess.run([str(tmp_path / "t")], check=False).returncode == 0


def test_files_of_two_runs_do_not_mix(tmp_path: Path) -> None:
    """A header of another spec, or of other options, stops the build with a line that says so."""
    folder = ROOT / "generated" / "nav"
    header = (folder / "nav.h").read_text()
    at = header.index("NAV_SPEC_DIGEST 0x") + len("NAV_SPEC_DIGEST 0x")
    (tmp_path / "nav.h").write_text(header[:at] + ("0" if header[at] != "0" else "1") + header[at + 1 :])
    (tmp_path / "nav.c").write_bytes((folder / "nav.c").read_bytes())
    compiler = shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        without("no C compiler is installed")
    line = [compiler, "-c", "nav.c", "-o", "x.o"]
    done = subprocess.run(line, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode != 0 and "do not belong together" in done.stderr
