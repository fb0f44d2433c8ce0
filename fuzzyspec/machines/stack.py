"""Stack by painting: memory below the stack pointer is filled with a pattern, and what no longer holds it was used.

A frame's lowest bytes that a run reserves and never writes keep their paint, so an emulator that can also looks at the
stack pointer (``emulate``).
"""

from __future__ import annotations

PAINT = 0xC5


def untouched(memory: bytes | bytearray) -> int:
    """How many bytes at the low end still hold the paint."""
    return len(memory) - len(memory.lstrip(bytes([PAINT])))
