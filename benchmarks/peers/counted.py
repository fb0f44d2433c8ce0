"""Instructions of this machine, counted by callgrind."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path


def instructions(command: Sequence[str], function: str, folder: Path) -> int | None:
    """All that a program executes inside a function, over all its calls; None without valgrind."""
    if shutil.which("valgrind") is None:
        return None
    tool = ["valgrind", "--tool=callgrind", "--collect-atstart=no", f"--toggle-collect={function}"]
    words = [*tool, "--callgrind-out-file=callgrind.out", *command]
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
    found = re.search(r"Collected\s*:\s*(\d+)", done.stderr)
    return None if found is None else int(found[1])
