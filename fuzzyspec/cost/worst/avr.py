"""AVR instructions and their cycles, after the AVR Instruction Set Manual, for a core with a 16-bit program counter
(ATmega328P). Registers are r0 to r31 and, as a pair, the stack pointer. Code addresses are in bytes."""

from __future__ import annotations

from collections.abc import Callable

from fuzzyspec.cost.worst.code import (
    Add,
    Apply,
    Branch,
    Call,
    Carry,
    Compare,
    Condition,
    Effect,
    Expr,
    Flow,
    Forget,
    Imm,
    Instruction,
    Judge,
    Jump,
    Leave,
    Load,
    NotModelled,
    Pair,
    Put,
    Reg,
    Set,
    SetPair,
    ShiftRight,
    Subtract,
)

SP = 32
X, Y, Z = 26, 28, 30

_SP_PORTS = {0x3D: SP, 0x3E: SP + 1}
_SREG = 0x3F
_SET: dict[int, Condition] = {0: "lo", 1: "eq", 2: "mi", 3: "some", 4: "lt", 5: "some", 6: "some", 7: "some"}
_CLEAR: dict[int, Condition] = {0: "hs", 1: "ne", 2: "pl", 3: "some", 4: "ge", 5: "some", 6: "some", 7: "some"}

_KEPT = (*range(2, 18), 28, 29)
"""What a function keeps for its caller; others are pushed to make room, for arrays too."""
_UNKNOWN = Apply("?", Imm(0), Imm(0), 8)
# Once the stack pointer is back up, the return address lies below it, its high byte first, counted in words.
_RETURN = Apply(
    "+",
    Apply("*", Load(Apply("-", Pair(SP), Imm(1), 16), 1), Imm(512)),
    Apply("*", Load(Pair(SP), 1), Imm(2)),
)

Parts = tuple[tuple[Effect, ...], Flow | None, int, int]
"""Effects, flow, cycles, and the cycles that a taken branch adds."""


def decode_avr(code: bytes, address: int, words_at: Callable[[int], int]) -> Instruction:
    """The instruction at the start of ``code``; ``words_at`` tells how many words the one at an address has.

    Raises NotModelled.
    """
    word = int.from_bytes(code[:2], "little")
    second = int.from_bytes(code[2:4], "little")
    size = 2 * words(word)
    effects, flow, cycles, taken = _decode(word, second, address, size, words_at)
    return Instruction(address, size, effects, flow, cycles, taken)


def words(word: int) -> int:
    """How many words an instruction has, by its first."""
    return 2 if word & 0xFE0E in (0x940C, 0x940E) or word & 0xFC0F == 0x9000 else 1


def _decode(word: int, second: int, address: int, size: int, words_at: Callable[[int], int]) -> Parts:
    d5, r5 = word >> 4 & 31, word & 15 | word >> 5 & 16
    d4, k8 = 16 + (word >> 4 & 15), word & 15 | word >> 4 & 0xF0
    after = address + size
    top = word >> 12
    match top:
        case 0 if word >> 8 <= 3:
            return _moves(word)
        case 0 | 1 | 2:
            if word >> 10 == 0b000100:  # CPSE
                skipped = words_at(after)
                return (), Branch("eq", after + 2 * skipped, (Reg(d5), Reg(r5)), 8), 1, skipped
            return _two_registers(word >> 10, d5, r5), None, 1, 0
        case 3:
            return (Compare(Reg(d4), Imm(k8), 8),), None, 1, 0
        case 4:
            return (Subtract(d4, Reg(d4), Imm(k8), 8, extends=True),), None, 1, 0
        case 5:
            return _subtract(d4, Imm(k8)), None, 1, 0
        case 6 | 7:
            return _logic(d4, Apply("|" if top == 6 else "&", Reg(d4), Imm(k8), 8)), None, 1, 0
        case 8 | 10:
            return _displaced(word, d5), None, 2, 0
        case 9:
            return _nine(word, second, address, size, words_at)
        case 11:
            return _port(word, d5), None, 1, 0
        case 12 | 13:
            offset = 2 * ((word & 0xFFF) - (0x1000 if word & 0x800 else 0))
            target = after + offset
            if top == 12:
                return (), Jump(target), 2, 0
            if offset == 0:  # room on the stack
                return (SetPair(SP, Apply("-", Pair(SP), Imm(2), 16)),), None, 3, 0
            return _called(after), Call(target), 3, 0
        case 14:
            return (Set(d4, Imm(k8)),), None, 1, 0
        case _:
            return _last(word, after, d5, words_at)


def _two_registers(code: int, d: int, r: int) -> tuple[Effect, ...]:
    left, right = Reg(d), Reg(r)
    match code:
        case 0b000001:
            return (Compare(left, right, 8, extends=True),)
        case 0b000010:
            return (Subtract(d, left, right, 8, extends=True),)
        case 0b000011:
            return (Add(d, left, right, Imm(0), 8),)
        case 0b000101:
            return (Compare(left, right, 8),)
        case 0b000110:
            return _subtract(d, right)
        case 0b000111:
            return (Add(d, left, right, Carry(), 8),)
        case 0b001000:
            if d == r:  # TST
                return (Judge(d, 8, "kept"),)
            return _logic(d, Apply("&", left, right, 8))
        case 0b001001:
            return _logic(d, Imm(0) if d == r else Apply("^", left, right, 8))
        case 0b001010:
            return _logic(d, Apply("|", left, right, 8))
        case _:  # MOV
            return (Set(d, right),)


def _subtract(d: int, right: Expr) -> tuple[Effect, ...]:
    if isinstance(right, Reg) and right.number == d:
        return (Subtract(d, Imm(0), Imm(0), 8),)
    return (Subtract(d, Reg(d), right, 8),)


def _logic(d: int, value: Expr) -> tuple[Effect, ...]:
    return Set(d, value), Judge(d, 8, "kept")


def _moves(word: int) -> Parts:
    if word == 0:
        return (), None, 1, 0
    if word >> 8 == 1:
        d = 2 * (word >> 4 & 15)
        r = 2 * (word & 15)
        return (Set(d, Reg(r)), Set(d + 1, Reg(r + 1))), None, 1, 0
    # Signed and fractional products: the operands' signs are not followed.
    return (Set(0, _UNKNOWN), Set(1, _UNKNOWN), Forget()), None, 2, 0


def _displaced(word: int, d: int) -> tuple[Effect, ...]:
    pointer = Y if word & 8 else Z
    offset = word & 7 | word >> 7 & 0x18 | word >> 8 & 0x20
    address = Apply("+", Pair(pointer), Imm(offset), 16) if offset else Pair(pointer)
    return (Put(address, 1, Reg(d)),) if word & 0x200 else (Set(d, Load(address, 1)),)


def _nine(word: int, second: int, address: int, size: int, words_at: Callable[[int], int]) -> Parts:
    d, after = word >> 4 & 31, address + size
    match word >> 8 & 15:
        case 0 | 1 | 2 | 3:
            return _load_store(word, second, d)
        case 4 | 5:
            return _one_register(word, second, d, after)
        case 6 | 7:
            pair, k = 24 + (word >> 3 & 6), word & 15 | word >> 2 & 0x30
            if word & 0x100:
                return (Compare(Pair(pair), Imm(k), 16), SetPair(pair, Apply("-", Pair(pair), Imm(k), 16))), None, 2, 0
            moved = Apply("+", Pair(pair), Imm(k), 16)
            return (SetPair(pair, moved), Judge(pair, 16)), None, 2, 0
        case 9 | 11:  # SBIC, SBIS
            skipped = words_at(after)
            return (), Branch("some", after + 2 * skipped), 1, skipped
        case 8 | 10:
            return (), None, 2, 0
        case _:  # MUL
            product = Apply("*", Reg(d), Reg(word & 15 | word >> 5 & 16), 16)
            return (SetPair(0, product), Judge(0, 16)), None, 2, 0


def _load_store(word: int, second: int, d: int) -> Parts:
    mode, stores = word & 15, bool(word & 0x200)
    if mode == 15:
        if stores:  # PUSH
            return (
                (
                    Put(Pair(SP), 1, Reg(d), "always" if d in _KEPT else None),
                    SetPair(SP, Apply("-", Pair(SP), Imm(1), 16)),
                ),
                None,
                2,
                0,
            )
        return (SetPair(SP, Apply("+", Pair(SP), Imm(1), 16)), Set(d, Load(Pair(SP), 1))), None, 2, 0
    if mode == 0:
        return ((Put(Imm(second), 1, Reg(d)),) if stores else (Set(d, Load(Imm(second), 1)),)), None, 2, 0
    if mode in (4, 5) and not stores:  # LPM
        loaded: tuple[Effect, ...] = (Set(d, Load(Pair(Z), 1, program=True)),)
        return (*loaded, *_moved(Z, 1)) if mode == 5 else loaded, None, 3, 0
    pointers = {1: (Z, 1), 2: (Z, -1), 9: (Y, 1), 10: (Y, -1), 12: (X, 0), 13: (X, 1), 14: (X, -1)}
    if mode not in pointers:
        raise NotModelled(f"{word:04x}")
    pointer, step = pointers[mode]
    access: Effect = Put(Pair(pointer), 1, Reg(d)) if stores else Set(d, Load(Pair(pointer), 1))
    before = _moved(pointer, -1) if step < 0 else ()
    behind = _moved(pointer, 1) if step > 0 else ()
    return (*before, access, *behind), None, 2, 0


def _moved(pointer: int, by: int) -> tuple[Effect, ...]:
    return (SetPair(pointer, Apply("+", Pair(pointer), Imm(by), 16)),)


def _one_register(word: int, second: int, d: int, after: int) -> Parts:
    own = Reg(d)
    if word & 0xFE0E in (0x940C, 0x940E):
        target = 2 * second  # 22 bits of words; the device has fewer
        if word & 2:
            return _called(after), Call(target), 4, 0
        return (), Jump(target), 3, 0
    match word & 15:
        case 0:  # COM
            return (Set(d, Apply("-", Imm(255), own, 8)), Judge(d, 8, Imm(1))), None, 1, 0
        case 1:  # NEG
            return (Subtract(d, Imm(0), own, 8),), None, 1, 0
        case 2:  # SWAP
            swapped = Apply("|", Apply("<<", own, Imm(4), 8), Apply(">>", own, Imm(4), 8), 8)
            return (Set(d, swapped),), None, 1, 0
        case 3 | 10:  # INC, DEC
            by = 1 if word & 15 == 3 else -1
            return (Set(d, Apply("+", own, Imm(by), 8)), Judge(d, 8, "kept")), None, 1, 0
        case 5:
            return (ShiftRight(d, "asr", False, 8),), None, 1, 0
        case 6 | 7:
            return (ShiftRight(d, ">>", word & 15 == 7, 8),), None, 1, 0
        case 8 if word == 0x9508:  # RET
            return _moved(SP, 2), Leave(_RETURN), 4, 0
        case 8 if word >> 8 == 0x94:  # BSET, BCLR
            return ((Forget(),) if word >> 4 & 7 < 6 else ()), None, 1, 0
        case 8 if word == 0x95C8:  # LPM to r0
            return (Set(0, Load(Pair(Z), 1, program=True)),), None, 3, 0
        case _:
            raise NotModelled({0x9409: "ijmp", 0x9509: "icall"}.get(word, f"{word:04x}"))


def _called(after: int) -> tuple[Effect, ...]:
    low, high = Imm(after // 2 & 255), Imm(after // 2 >> 8)
    return (
        Put(Pair(SP), 1, low, saved="always"),
        Put(Apply("-", Pair(SP), Imm(1), 16), 1, high, saved="always"),
        SetPair(SP, Apply("-", Pair(SP), Imm(2), 16)),
    )


def _port(word: int, d: int) -> tuple[Effect, ...]:
    port = word & 15 | word >> 5 & 0x30
    if word & 0x800:
        if port in _SP_PORTS:
            return (Set(_SP_PORTS[port], Reg(d)),)
        return (Forget(),) if port == _SREG else ()
    return (Set(d, Reg(_SP_PORTS[port]) if port in _SP_PORTS else _UNKNOWN),)


def _last(word: int, after: int, d: int, words_at: Callable[[int], int]) -> Parts:
    bit = word & 7
    match word >> 9 & 7:
        case 0 | 1 | 2 | 3:  # BRBS, BRBC
            offset = 2 * ((word >> 3 & 127) - (128 if word & 0x200 else 0))
            conditions = _CLEAR if word & 0x400 else _SET
            return (), Branch(conditions[bit], after + offset, None, 8), 1, 1
        case 4:  # BLD
            return (Set(d, _UNKNOWN),), None, 1, 0
        case 5:  # BST
            return (), None, 1, 0
        case which:  # SBRC, SBRS
            skipped = words_at(after)
            tested = Apply("&", Apply(">>", Reg(d), Imm(bit), 8), Imm(1), 8)
            return (), Branch("eq" if which == 6 else "ne", after + 2 * skipped, (tested, Imm(0)), 8), 1, skipped
