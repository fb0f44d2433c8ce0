"""The spec that a command is given, and how exact it is to be."""

from __future__ import annotations

import argparse
import re
from fractions import Fraction
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


def percent(text: str) -> Fraction:
    """A command's ``PERCENT``, as argparse's ``type``: ``0.5`` or ``0.5%``."""
    if re.fullmatch(r"\d{1,9}(\.\d{1,9})?%?", text, re.ASCII) is None or not (value := Fraction(text.rstrip("%"))):
        raise argparse.ArgumentTypeError(
            f"`{text}` is no percentage above 0: write 0.5 for half a percent of the range"
        )
    return value
