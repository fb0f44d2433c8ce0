"""What the printer must know of C's integer types; ``int`` may have 16 bits."""

from __future__ import annotations

from fuzzyspec.fixed.build import LIMITS
from fuzzyspec.fixed.program import CType

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


def arithmetic(narrow: bool, *intervals: tuple[int, int]) -> CType:
    """The type that an operation with these intervals (operands and result) is done in: of 32 bits, or ``narrow``, of
    as few as hold them all."""
    is_signed = any(lo < 0 for lo, _ in intervals)
    for bits in (8, 16, 32) if narrow else (32,):
        ctype = of_width(is_signed, bits)
        if all(holds(ctype, lo, hi) for lo, hi in intervals):
            return ctype
    raise AssertionError(f"{intervals} do not fit one type: the program's constructors must refuse this")


def spelled(ctype: CType) -> str:
    """The type as C writes it."""
    return f"{ctype}_t"


def count_ctype(capacity: int) -> CType:
    """The type of a list's count."""
    return "uint8" if capacity <= 255 else "uint16"
