"""What a wheel holds; ``make wheel`` installs one and compiles with it."""

import subprocess
import sys
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def test_wheel_holds_packages_grammar_templates_and_examples(tmp_path: Path) -> None:
    """Every tracked part that the compiler needs at run time is in the wheel, at the place resources.py looks."""
    command = [sys.executable, "-m", "hatchling", "build", "--target", "wheel", "--directory", str(tmp_path)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    (wheel,) = tmp_path.glob("fuzzyc-*.whl")
    names = set(zipfile.ZipFile(wheel).namelist())
    wanted = {f"{top}/py.typed" for top in ("fuzzyspec", "firmware_sim")}
    for package in ("fuzzyspec", "firmware_sim"):
        wanted |= {f.relative_to(ROOT).as_posix() for f in (ROOT / package).rglob("*.py")}
        wanted |= {f.relative_to(ROOT).as_posix() for f in (ROOT / package).rglob("*.c")}
    for folder in ("grammar", "templates", "examples"):
        wanted |= {f"fuzzyspec/_data/{f.relative_to(ROOT).as_posix()}" for f in (ROOT / folder).rglob("*.*")}
    assert wanted <= names
    assert not [n for n in names if n.startswith(("tests/", "docs/", "generated/", "scripts/"))]
