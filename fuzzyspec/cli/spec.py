"""The spec that a command is given."""

from __future__ import annotations

from pathlib import Path

from fuzzyspec.diagnostics.refusal import Refusal


def spec_path(text: str) -> Path:
    """A command's ``FILE.fz``, as argparse's ``type``. Refusal where it is no file, or not named as a spec is."""
    path = Path(text)
    if path.is_dir():
        raise Refusal(f"{text} is a folder", "name a spec in it")
    if not path.exists():
        raise Refusal(f"{text}: no such file")
    if path.suffix != ".fz":
        raise Refusal(f"{text} is not a spec", "specs are named *.fz")
    return path
