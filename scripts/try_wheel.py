"""Build the wheel, install it into an empty environment and compile from a folder that is not the checkout.

What the installed compiler writes must be, byte for byte, what stands in ``generated/``.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def run(*command: str | Path, cwd: Path, **environ: str) -> None:
    """One step; a failure ends the trial with its output on the screen."""
    subprocess.run([str(word) for word in command], cwd=cwd, env={**os.environ, **environ}, check=True)


def main() -> int:
    """0 if every step went well and the output is the committed one."""
    pip = ("-m", "pip", "--quiet", "--disable-pip-version-check")
    with tempfile.TemporaryDirectory(prefix="fuzzyc wheel ") as name:
        folder = Path(name)
        run(sys.executable, *pip, "wheel", "--no-deps", "--wheel-dir", folder, ROOT, cwd=folder)
        (wheel,) = folder.glob("fuzzyc-*.whl")
        run(sys.executable, "-m", "venv", folder / "empty", cwd=folder)
        python = folder / "empty" / "bin" / "python"
        run(python, *pip, "install", "-c", ROOT / "constraints.txt", wheel, cwd=folder)
        fuzzyc = folder / "empty" / "bin" / "fuzzyc"
        shutil.copy(ROOT / "examples" / "nav.fz", folder)
        run(fuzzyc, "--version", cwd=folder)
        run(fuzzyc, "compile", "nav.fz", "-o", "nav", cwd=folder, LC_ALL="C", PYTHONHASHSEED="7")
        run(fuzzyc, "verify", "nav.fz", "--cases", "2000", cwd=folder)
        expected = sorted((ROOT / "generated" / "nav").iterdir())
        written = sorted((folder / "nav").iterdir())
        if [f.name for f in expected] != [f.name for f in written]:
            print(f"the wheel writes {[f.name for f in written]}, generated/nav holds {[f.name for f in expected]}")
            return 1
        different = [e.name for e, w in zip(expected, written, strict=True) if e.read_bytes() != w.read_bytes()]
        if different:
            print(f"the wheel's output differs from generated/nav in {', '.join(different)}")
            return 1
    print(f"{wheel.name}: installed alone, it writes {len(expected)} files equal to generated/nav")
    return 0


if __name__ == "__main__":
    sys.exit(main())
