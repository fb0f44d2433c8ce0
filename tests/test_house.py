"""How the house is kept, where ruff, mypy and the import contract (all three in ``make test``) do not look."""

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from fuzzyspec.cli.main import COMMANDS
from tests.conftest import required_tool

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ("fuzzyspec", "firmware_sim")
SOURCES = sorted(f for package in PACKAGES for f in (ROOT / package).rglob("*.py"))
LONGEST = 450

MACHINE_PATH = re.compile(r"(?<![\w.:/-])/(?:home|root|work|farm|tmp|Users|private|opt)/\w")
REGISTRY_HOST = re.compile(
    r"pypi\.org|pythonhosted\.|registry\.npmjs|(?:index|registry)[-_]url|crates\.io|\bmirror\b.*https?:"
)
TIME_STAMP = re.compile(r"\b(?:19|20)\d\d-\d\d-\d\d[T ]\d\d:\d\d")


def tracked() -> list[Path]:
    """Every text file that git knows, or is about to know."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, check=False)
    if listed.returncode != 0:
        pytest.skip("not a git checkout")
    files = [ROOT / name for name in sorted(set(listed.stdout.decode().split("\0"))) if name]
    return [f for f in files if f.is_file() and b"\0" not in f.read_bytes()[:4096]]


def lines_matching(pattern: re.Pattern[str]) -> list[str]:
    """``file:line`` of every match in a tracked text file."""
    return [
        f"{file.relative_to(ROOT)}:{number}: {line.strip()[:100]}"
        for file in tracked()
        for number, line in enumerate(file.read_text(encoding="utf-8", errors="replace").splitlines(), 1)
        if pattern.search(line)
    ]


def imports(file: Path) -> Iterator[str]:
    """Full names of the modules that a file imports, wherever in it."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module is not None:
            yield node.module


@pytest.mark.parametrize("pattern", [MACHINE_PATH, REGISTRY_HOST, TIME_STAMP], ids=["path", "registry", "time"])
def test_nothing_names_a_machine_or_a_moment(pattern: re.Pattern[str]) -> None:
    """No tracked file holds a path of somebody's machine, a package registry's address or a time stamp."""
    assert lines_matching(pattern) == []


def test_patterns_find_what_they_are_for() -> None:
    """The patterns above match what they forbid (so that an empty list means something)."""
    assert MACHINE_PATH.search("see " + "/".join(("", "home", "me", "x.c")))
    assert REGISTRY_HOST.search("https://" + "pypi" + ".org/simple")
    assert TIME_STAMP.search("generated 2026-" + "01-02 03:04")


def test_modules_are_small() -> None:
    """A module that has outgrown a few screens wants to be two."""
    files = [*SOURCES, *sorted((ROOT / "tests").rglob("*.py")), *sorted((ROOT / "scripts").glob("*.py"))]
    lengths = {str(f.relative_to(ROOT)): len(f.read_text(encoding="utf-8").splitlines()) for f in files}
    assert {name: n for name, n in lengths.items() if n > LONGEST} == {}


def test_modules_are_named_for_what_they_hold() -> None:
    """No drawer for odds and ends."""
    drawers = {"utils", "util", "helpers", "helper", "common", "misc", "tools", "shared"}
    assert [str(f.relative_to(ROOT)) for f in SOURCES if f.stem in drawers or f.parent.name in drawers] == []


def test_values_of_the_pipeline_are_frozen() -> None:
    """Public dataclasses of tree, model, program and diagnostics are frozen: a step cannot spoil what it was given."""
    loose = [
        f"{file.relative_to(ROOT)}:{node.lineno} {node.name}"
        for step in ("diagnostics", "syntax", "model", "fixed")
        for file in sorted((ROOT / "fuzzyspec" / step).rglob("*.py"))
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_")
        for decorator in node.decorator_list
        if "dataclass" in ast.unparse(decorator) and "frozen=True" not in ast.unparse(decorator)
    ]
    assert loose == []


def test_robots_use_the_library_as_a_user_would() -> None:
    """firmware_sim imports nothing of fuzzyspec but what the library offers."""
    allowed = {"fuzzyspec", "fuzzyspec.api"}
    used = {
        (str(f.relative_to(ROOT)), name)
        for f in SOURCES
        if f.is_relative_to(ROOT / "firmware_sim")
        for name in imports(f)
        if name.split(".")[0] == "fuzzyspec"
    }
    assert {(file, name) for file, name in used if name not in allowed} == set()


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_is_a_module_that_registers(name: str) -> None:
    """``fuzzyc NAME`` lives in ``cli/NAME.py``, and that module registers it."""
    functions = {
        node.name: node
        for node in ast.parse((ROOT / "fuzzyspec" / "cli" / f"{name}.py").read_text(encoding="utf-8")).body
        if isinstance(node, ast.FunctionDef)
    }
    assert "register" in functions


def test_start_up_imports_nothing_heavy() -> None:
    """Building the command line loads none of the libraries that only some commands need."""
    heavy = ("numpy", "lark", "jinja2", "cffi", "matplotlib", "unicorn", "elftools")
    code = (
        "import sys; from fuzzyspec.cli.main import build_parser; build_parser();"
        f"print(*[name for name in {heavy} if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


@pytest.mark.parametrize(("wish", "outcome"), [("", pytest.skip.Exception), ("required", pytest.fail.Exception)])
def test_a_missing_tool_skips_or_fails(
    wish: str, outcome: type[BaseException], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A test whose tool is not installed is skipped, but not where all tools are to be there."""
    monkeypatch.setenv("FUZZYC_TOOLS", wish)
    with pytest.raises(outcome, match="no-such-tool is not installed"):
        required_tool("no-such-tool")
