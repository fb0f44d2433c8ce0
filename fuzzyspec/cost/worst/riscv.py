"""RV32IMC instructions, after the RISC-V Instruction Set Manual, volume I. Registers are x0 to x31."""

from __future__ import annotations

from fuzzyspec.cost.worst.code import (
    UNKNOWN,
    Apply,
    Branch,
    Call,
    Condition,
    Effect,
    Expr,
    Flow,
    Imm,
    Instruction,
    Jump,
    Leave,
    Load,
    NotModelled,
    Put,
    Reg,
    Set,
)
from fuzzyspec.cost.worst.values import Operator

_BRANCHES: dict[int, Condition] = {0: "eq", 1: "ne", 4: "lt", 5: "ge", 6: "lo", 7: "hs"}
_REGISTERS: dict[tuple[int, int], Operator] = {
    (0, 0): "+",
    (32, 0): "-",
    (0, 1): "<<",
    (0, 4): "^",
    (0, 5): ">>",
    (32, 5): "asr",
    (0, 6): "|",
    (0, 7): "&",
    (1, 0): "*",
    (1, 5): "/",
    (1, 7): "%",
}
_IMMEDIATES: dict[int, Operator] = {0: "+", 4: "^", 6: "|", 7: "&"}
RA = 1
_KEPT = (RA, 8, 9, *range(18, 28))
"""What a function keeps for its caller."""


def decode_riscv(code: bytes, address: int, before: bytes = b"") -> Instruction:
    """The instruction at the start of ``code``; the four bytes ``before`` it may be the first half of a far jump.

    Raises NotModelled.
    """
    half = int.from_bytes(code[:2], "little")
    if half & 3 != 3:
        effects, flow = _compressed(half, address)
        return Instruction(address, 2, effects, flow)
    word = int.from_bytes(code[:4], "little")
    effects, flow = _far(word, int.from_bytes(before, "little"), address) or _full(word, address)
    return Instruction(address, 4, effects, flow)


def _far(word: int, first: int, address: int) -> tuple[tuple[Effect, ...], Flow] | None:
    """``auipc`` and ``jalr`` by the same register: a jump or a call to an address that is told."""
    if word & 0x707F != 0x67 or first & 127 != 0x17 or _bits(first, 11, 7) != _bits(word, 19, 15):
        return None
    target = (address - 4 + (first & 0xFFFFF000) + _sign(word >> 20, 12)) & 0xFFFFFFFE
    return _jump(_bits(word, 11, 7), target, address + 4)


def _bits(word: int, high: int, low: int) -> int:
    return word >> low & ((1 << (high - low + 1)) - 1)


def _sign(value: int, bits: int) -> int:
    return value - (1 << bits) if value >> (bits - 1) else value


def _to(register: int, value: Expr) -> tuple[Effect, ...]:
    """x0 stays 0."""
    return (Set(register, value),) if register else ()


def _sum(register: int, offset: int) -> Expr:
    return Apply("+", Reg(register), Imm(offset)) if offset else Reg(register)


def _jump(rd: int, target: int, after: int) -> tuple[tuple[Effect, ...], Flow]:
    return _to(rd, Imm(after)), (Call(target) if rd else Jump(target))


def _store(base: int, offset: int, source: int, size: int) -> tuple[Effect, ...]:
    return (Put(_sum(base, offset), size, Reg(source), "unless written" if source in _KEPT and size == 4 else None),)


def _full(word: int, address: int) -> tuple[tuple[Effect, ...], Flow | None]:
    opcode, rd, f3, rs1, rs2 = (
        word & 127,
        _bits(word, 11, 7),
        _bits(word, 14, 12),
        _bits(word, 19, 15),
        _bits(word, 24, 20),
    )
    upper = word & 0xFFFFF000
    low = _sign(word >> 20, 12)
    match opcode:
        case 0x37:
            return _to(rd, Imm(upper)), None
        case 0x17:
            return _to(rd, Imm(address + upper)), None
        case 0x6F:
            offset = _bits(word, 31, 31) << 20 | _bits(word, 19, 12) << 12 | _bits(word, 20, 20) << 11
            return _jump(rd, address + _sign(offset | _bits(word, 30, 21) << 1, 21), address + 4)
        case 0x67:
            if rd:
                raise NotModelled("a call through a register")
            return (), Leave(_sum(rs1, low))
        case 0x63:
            offset = _bits(word, 31, 31) << 12 | _bits(word, 7, 7) << 11 | _bits(word, 30, 25) << 5
            target = address + _sign(offset | _bits(word, 11, 8) << 1, 13)
            if f3 not in _BRANCHES:
                raise NotModelled(f"{word:08x}")
            return (), Branch(_BRANCHES[f3], target, (Reg(rs1), Reg(rs2)))
        case 0x03:
            sizes = {0: (1, True), 1: (2, True), 2: (4, False), 4: (1, False), 5: (2, False)}
            if f3 not in sizes:
                raise NotModelled(f"{word:08x}")
            size, signed = sizes[f3]
            return _to(rd, Load(_sum(rs1, low), size, signed)), None
        case 0x23:
            if f3 > 2:
                raise NotModelled(f"{word:08x}")
            return _store(rs1, _sign(_bits(word, 31, 25) << 5 | rd, 12), rs2, 1 << f3), None
        case 0x13 if f3 in (1, 5):
            shift: Operator = "<<" if f3 == 1 else "asr" if word >> 30 & 1 else ">>"
            return _to(rd, Apply(shift, Reg(rs1), Imm(rs2))), None
        case 0x13:
            found = _IMMEDIATES.get(f3)
            return _to(rd, UNKNOWN_BIT if found is None else Apply(found, Reg(rs1), Imm(low))), None
        case 0x33:
            funct = (word >> 25, f3)
            if funct in ((0, 2), (0, 3)):
                return _to(rd, UNKNOWN_BIT), None
            operator = _REGISTERS.get(funct)
            return _to(rd, UNKNOWN if operator is None else Apply(operator, Reg(rs1), Reg(rs2))), None
        case _:
            raise NotModelled(f"{word:08x}")


UNKNOWN_BIT = Apply("&", UNKNOWN, Imm(1))
"""0 or 1: of slt and its kin."""


def _compressed(half: int, address: int) -> tuple[tuple[Effect, ...], Flow | None]:
    quadrant, f3 = half & 3, half >> 13
    rd, rs2 = _bits(half, 11, 7), _bits(half, 6, 2)
    small, middle = 8 + _bits(half, 4, 2), 8 + _bits(half, 9, 7)
    six = _sign(_bits(half, 12, 12) << 5 | rs2, 6)
    word_offset = _bits(half, 12, 10) << 3 | _bits(half, 6, 6) << 2 | _bits(half, 5, 5) << 6
    match quadrant, f3:
        case 0, 0 if half:
            offset = (
                _bits(half, 12, 11) << 4 | _bits(half, 10, 7) << 6 | _bits(half, 6, 6) << 2 | _bits(half, 5, 5) << 3
            )
            return _to(small, _sum(2, offset)), None
        case 0, 2:
            return _to(small, Load(_sum(middle, word_offset), 4)), None
        case 0, 6:
            return _store(middle, word_offset, small, 4), None
        case 1, 0:
            return _to(rd, _sum(rd, six)), None
        case 1, 1 | 5:
            offset = (
                _bits(half, 12, 12) << 11
                | _bits(half, 11, 11) << 4
                | _bits(half, 10, 9) << 8
                | _bits(half, 8, 8) << 10
                | _bits(half, 7, 7) << 6
                | _bits(half, 6, 6) << 7
                | _bits(half, 5, 3) << 1
                | _bits(half, 2, 2) << 5
            )
            return _jump(RA if f3 == 1 else 0, address + _sign(offset, 12), address + 2)
        case 1, 2:
            return _to(rd, Imm(six)), None
        case 1, 3 if rd == 2:
            offset = (
                _bits(half, 12, 12) << 9
                | _bits(half, 6, 6) << 4
                | _bits(half, 5, 5) << 6
                | _bits(half, 4, 3) << 7
                | _bits(half, 2, 2) << 5
            )
            return _to(2, _sum(2, _sign(offset, 10))), None
        case 1, 3:
            return _to(rd, Imm(six << 12)), None
        case 1, 4:
            return _to(middle, _arithmetic(half, middle, small, six)), None
        case 1, 6 | 7:
            offset = (
                _bits(half, 12, 12) << 8
                | _bits(half, 11, 10) << 3
                | _bits(half, 6, 5) << 6
                | _bits(half, 4, 3) << 1
                | _bits(half, 2, 2) << 5
            )
            return (), Branch("eq" if f3 == 6 else "ne", address + _sign(offset, 9), (Reg(middle), Imm(0)))
        case 2, 0:
            return _to(rd, Apply("<<", Reg(rd), Imm(rs2))), None
        case 2, 2:
            offset = _bits(half, 12, 12) << 5 | _bits(half, 6, 4) << 2 | _bits(half, 3, 2) << 6
            return _to(rd, Load(_sum(2, offset), 4)), None
        case 2, 4:
            return _moved(half, rd, rs2)
        case 2, 6:
            return _store(2, _bits(half, 12, 9) << 2 | _bits(half, 8, 7) << 6, rs2, 4), None
        case _:
            raise NotModelled(f"{half:04x}")


def _arithmetic(half: int, rd: int, rs2: int, six: int) -> Expr:
    match _bits(half, 11, 10):
        case 0:
            return Apply(">>", Reg(rd), Imm(six & 31))
        case 1:
            return Apply("asr", Reg(rd), Imm(six & 31))
        case 2:
            return Apply("&", Reg(rd), Imm(six))
        case _:
            operators: tuple[Operator, ...] = ("-", "^", "|", "&")
            return Apply(operators[_bits(half, 6, 5)], Reg(rd), Reg(rs2))


def _moved(half: int, rd: int, rs2: int) -> tuple[tuple[Effect, ...], Flow | None]:
    adds = half >> 12 & 1
    if rs2:
        return _to(rd, Apply("+", Reg(rd), Reg(rs2)) if adds else Reg(rs2)), None
    if adds or not rd:
        raise NotModelled("a call through a register")
    return (), Leave(Reg(rd))
