"""What a slip is."""

from __future__ import annotations

Slip = tuple[str, str, str, str]
"""A name, what is expected (``FZ102 at 3:5, ..``), the text that is replaced, and its replacement."""
