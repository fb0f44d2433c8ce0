"""What the printer must know of C's integer types; ``int`` may have 16 bits."""

from __future__ import annotations

from fuzzyspec.fixed.program import CType

LIMITS: dict[CType, tuple[int, int]] = {
    "uint8": (0, 2**8 - 1),
    "int8": (-(2**7), 2**7 - 1),
    "uint16": (0, 2**16 - 1),
    "int16": (-(2**15), 2**15 - 1),
    "uint32": (0, 2**32 - 1),
    "int32": (-(2**31), 2**31 - 1),
}

_OF_WIDTH: dict[tuple[bool, int], CType] = {
    (False, 8): "uint8",
    (True, 8): "int8",
    (False, 16): "uint16",
    (True, 16): "int16",
    (False, 32): "uint32",
    (True, 32): "int32",
}


def signed(ctype: CType) -> bool:
    """Whether the type has negative values."""
    return ctype.startswith("int")


def width(ctype: CType) -> int:
    """Bits of the type."""
    return int(ctype.lstrip("uint"))


def of_width(is_signed: bool, bits: int) -> CType:
    """The type of that signedness and of 8, 16 or 32 bits."""
    return _OF_WIDTH[is_signed, bits]


def holds(ctype: CType, lo: int, hi: int) -> bool:
    """Whether every integer of ``[lo, hi]`` is a value of the type."""
    low, high = LIMITS[ctype]
    return low <= lo and hi <= high


def word(*intervals: tuple[int, int]) -> CType:
    """The 32-bit type that arithmetic over these intervals is done in."""
    ctype: CType = "int32" if any(lo < 0 for lo, _ in intervals) else "uint32"
    for lo, hi in intervals:
        if not holds(ctype, lo, hi):
            raise AssertionError(f"[{lo}, {hi}] does not fit {ctype}: the program's constructors must refuse this")
    return ctype


def spelled(ctype: CType) -> str:
    """The type as C writes it."""
    return f"{ctype}_t"


def count_ctype(capacity: int) -> CType:
    """The type of a list's count."""
    return "uint8" if capacity <= 255 else "uint16"
