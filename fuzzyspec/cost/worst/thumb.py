"""Thumb instructions of Cortex-M cores, decoded by the package capstone. Registers are r0 to r15."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

from fuzzyspec.cost.thumb import decode_thumb
from fuzzyspec.cost.worst.code import (
    CONTRARY,
    UNKNOWN,
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
    Narrow,
    NotModelled,
    Put,
    Reg,
    Set,
    Subtract,
)
from fuzzyspec.cost.worst.values import Operator
from fuzzyspec.diagnostics.refusal import MissingTool
from fuzzyspec.machines.elf import WAY_OUT

SP, LR, PC = 13, 14, 15

_CONDITIONS: dict[str, Condition] = {
    "eq": "eq",
    "ne": "ne",
    "hs": "hs",
    "cs": "hs",
    "lo": "lo",
    "cc": "lo",
    "mi": "mi",
    "pl": "pl",
    "hi": "hi",
    "ls": "ls",
    "ge": "ge",
    "lt": "lt",
    "gt": "gt",
    "le": "le",
    "vs": "some",
    "vc": "other",
}
_REGISTERS = {f"r{i}": i for i in range(13)} | {"sb": 9, "sl": 10, "fp": 11, "ip": 12, "sp": SP, "lr": LR, "pc": PC}
_DATA: dict[str, Operator] = {"and": "&", "orr": "|", "eor": "^", "mul": "*", "udiv": "/"}
_SHIFTS: dict[str, Operator] = {"lsl": "<<", "lsr": ">>", "asr": "asr"}
_EXTENDS = {"uxtb": (8, False), "uxth": (16, False), "sxtb": (8, True), "sxth": (16, True)}
_LOADS = {"ldr": (4, False), "ldrb": (1, False), "ldrh": (2, False), "ldrsb": (1, True), "ldrsh": (2, True)}
_STORES = {"str": 4, "strb": 1, "strh": 2}
_NOTHING = ("nop", "dmb", "dsb", "isb", "hint")

Parts = tuple[tuple[Effect, ...], Flow | None]


def thumb_decoder(code_at: Callable[[int], bytes]) -> Callable[[int], Instruction]:
    """A decoder; ``code_at`` gives the bytes from an address. Raises MissingTool where capstone is not installed."""
    try:
        import capstone
    except ImportError as error:
        raise MissingTool("the package capstone is needed to derive a worst case", WAY_OUT) from error
    engine = capstone.Cs(capstone.CS_ARCH_ARM, capstone.CS_MODE_THUMB | capstone.CS_MODE_MCLASS)
    engine.detail = True

    def decode(address: int) -> Instruction:
        code = code_at(address)[:4]
        found = next(engine.disasm(code, address, 1), None)
        if found is None:
            raise NotModelled(f"the bytes {code.hex()}")
        return _instruction(found)

    return decode


def _instruction(insn: Any) -> Instruction:
    name = insn.mnemonic.removesuffix(".w").removesuffix(".n")
    block = decode_thumb(bytes(insn.bytes))
    if name.startswith("it") and name.strip("te") == "i":
        first = _CONDITIONS[insn.op_str]
        guards = tuple(first if letter == "t" else CONTRARY[first] for letter in name[1:])
        return Instruction(insn.address, insn.size, (), None, block.cycles, 0, None, guards)
    effects, flow = _parts(insn, name)
    return Instruction(insn.address, insn.size, effects, flow, block.cycles, 1)


def _parts(insn: Any, name: str) -> Parts:
    """Effects and flow of an instruction by its name without a width."""
    operands = insn.operands
    if name in ("push", "pop", "ldm", "ldmdb", "stm", "stmdb"):
        return _several(insn, name)
    if name in _LOADS or name in _STORES or name in ("ldrd", "strd"):
        return _memory(insn, name)
    if name in _NOTHING:
        return (), None
    if name == "b":
        return (), Jump(operands[0].imm)
    if name[:1] == "b" and name[1:] in _CONDITIONS:
        return (), Branch(_CONDITIONS[name[1:]], operands[0].imm)
    match name:
        case "cbz" | "cbnz":
            compared = (_register(insn, operands[0]), Imm(0))
            return (), Branch("eq" if name == "cbz" else "ne", operands[1].imm, compared)
        case "bl":
            return (Set(LR, Imm(insn.address + insn.size | 1)),), Call(operands[0].imm)
        case "bx":
            return (), Leave(_register(insn, operands[0]))
        case "cmp":
            return (Compare(_value(insn, operands[0]), _value(insn, operands[1])),), None
        case "tst" | "cmn" | "teq":
            return (Forget(),), None
        case _:
            return _computed(insn, name)


def _number(insn: Any, register: int) -> int:
    name = insn.reg_name(register)
    if name not in _REGISTERS:
        raise NotModelled(f"{insn.mnemonic} {insn.op_str}")
    return _REGISTERS[name]


def _register(insn: Any, operand: Any) -> Expr:
    """What a register holds when it is read: of the program counter, the address four bytes on."""
    number = _number(insn, operand.reg)
    return Imm(insn.address + 4) if number == PC else Reg(number)


def _value(insn: Any, operand: Any) -> Expr:
    """An operand: a register, shifted or not, or an immediate."""
    from capstone import arm_const as arm

    if operand.type == arm.ARM_OP_IMM:
        return Imm(operand.imm)
    value = _register(insn, operand)
    shifts: dict[int, Operator] = {arm.ARM_SFT_LSL: "<<", arm.ARM_SFT_LSR: ">>", arm.ARM_SFT_ASR: "asr"}
    if operand.shift.type == arm.ARM_SFT_INVALID:
        return value
    if operand.shift.type not in shifts:
        return UNKNOWN
    return Apply(shifts[operand.shift.type], value, Imm(operand.shift.value))


def _computed(insn: Any, name: str) -> Parts:
    """An instruction that computes a register from registers and immediates."""
    judged = bool(insn.update_flags)
    base = name[:-1] if judged and name.endswith("s") else name
    operands = insn.operands
    if (
        (base[:1] in ("b", "v") and base not in ("bic", "bfi", "bfc"))
        or base[:2] in ("st", "ld", "tb", "ms", "sv")
        or base == "udf"
    ):
        raise NotModelled(f"{insn.mnemonic} {insn.op_str}")
    if not operands or base in ("mla", "mls", "umull", "smull", "umlal", "smlal", "sbc", "bfi", "bfc", "movt"):
        return _unfollowed(insn, base)
    target = _number(insn, operands[0].reg)
    if target == PC:
        if base == "mov":
            return (), Leave(_value(insn, operands[1]))
        raise NotModelled(f"{insn.mnemonic} {insn.op_str}")
    values = [_value(insn, o) for o in operands]
    left, right = (values[1], values[2]) if len(values) > 2 else (values[0], values[-1])
    match base:
        case "add" | "addw" | "adc" if judged:
            return (Add(target, left, right, Carry() if base == "adc" else Imm(0)),), None
        case "sub" | "rsb" | "neg" if judged:
            if base == "neg":
                left, right = right, Imm(0)
            pair = (right, left) if base in ("rsb", "neg") else (left, right)
            return (Subtract(target, *pair),), None
        case _:
            pass
    found = _result(base, left, right, values)
    if found is None:
        return _unfollowed(insn, base)
    effects: tuple[Effect, ...] = (Set(target, found),)
    if not judged:
        return effects, None
    shifts = base in _SHIFTS or any(isinstance(v, Apply) for v in values)
    return (*effects, Judge(target, 32, None if shifts else "kept")), None


def _result(base: str, left: Expr, right: Expr, values: list[Expr]) -> Expr | None:
    if base in _DATA:
        return Apply(_DATA[base], left, right)
    if base in _SHIFTS:
        # A count in a register counts modulo 256; one beyond 31 is not followed.
        return Apply(_SHIFTS[base], left, right)
    if base in _EXTENDS and len(values) == 2:
        bits, signed = _EXTENDS[base]
        return Narrow(values[1], bits, signed)
    match base:
        case "add" | "addw" | "adr":
            return Apply("+", left, right)
        case "adc":
            return Apply("+", Apply("+", left, right), Carry())
        case "sub" | "subw":
            return Apply("-", left, right)
        case "rsb":
            return Apply("-", right, left)
        case "mov" | "movw":
            return values[1]
        case "rev":
            return Apply("reversed", values[1], Imm(0))
        case "mvn":
            return Apply("^", values[1], Imm(-1))
        case "bic":
            return Apply("&", left, Apply("^", right, Imm(-1)))
        case "ubfx":
            match values[2:]:
                case [Imm(low), Imm(width)]:
                    return Apply("&", Apply(">>", values[1], Imm(low)), Imm((1 << width) - 1))
                case _:
                    return None
        case _:
            return None


def _unfollowed(insn: Any, base: str) -> Parts:
    """Registers that may hold anything from here on, by what capstone says of the instruction."""
    operands = insn.operands
    values = [_value(insn, o) for o in operands]
    if base in ("mla", "mls") and not insn.update_flags:
        product = Apply("*", values[1], values[2])
        target = _number(insn, operands[0].reg)
        return (Set(target, Apply("+" if base == "mla" else "-", values[3], product)),), None
    if base == "movt":
        (target, upper) = _number(insn, operands[0].reg), operands[1].imm << 16
        return (Set(target, Apply("|", Apply("&", Reg(target), Imm(0xFFFF)), Imm(upper))),), None
    written = [insn.reg_name(r) for r in insn.regs_access()[1]]
    effects: list[Effect] = [Set(_REGISTERS[name], UNKNOWN) for name in written if name in _REGISTERS]
    if any(name in ("pc", "sp") for name in written):
        raise NotModelled(f"{insn.mnemonic} {insn.op_str}")
    return (*effects, Forget()), None


def _memory(insn: Any, name: str) -> Parts:
    """Loads and stores of one register, or of two."""
    from capstone import arm_const as arm

    operands = insn.operands
    registers = [_number(insn, o.reg) for o in operands if o.type == arm.ARM_OP_REG]
    place = next(o for o in operands if o.type == arm.ARM_OP_MEM)
    base = _number(insn, place.mem.base)
    origin: Expr = Imm((insn.address + 4) & ~3) if base == PC else Reg(base)
    step = next((o.imm for o in operands if o.type == arm.ARM_OP_IMM), None) if insn.post_index else None
    address: Expr = origin
    if place.mem.index:
        count = place.shift.value if place.shift.type == arm.ARM_SFT_LSL else 0
        index = Apply("<<", Reg(_number(insn, place.mem.index)), Imm(count))
        if place.subtracted or (place.shift.type != arm.ARM_SFT_INVALID and place.shift.type != arm.ARM_SFT_LSL):
            raise NotModelled(f"{insn.mnemonic} {insn.op_str}")
        address = Apply("+", origin, index)
    elif step is None and place.mem.disp:
        address = Apply("+", origin, Imm(place.mem.disp))
    if insn.writeback and place.mem.index:
        raise NotModelled(f"{insn.mnemonic} {insn.op_str}")
    size, signed = _LOADS.get(name, (_STORES.get(name, 4), False))
    moved: tuple[Effect, ...] = ()
    if insn.writeback:
        # The base moves first; the access is then told from there.
        by = place.mem.disp if step is None else step
        moved = (Set(base, Apply("+", Reg(base), Imm(by))),)
        address = Reg(base) if step is None else Apply("-", Reg(base), Imm(step))
    if name in _STORES or name == "strd":
        if insn.writeback and base in registers:
            raise NotModelled(f"{insn.mnemonic} {insn.op_str}")
        return (
            *moved,
            *(
                Put(_after(address, 4 * i), size, Reg(r), "unless written" if r == LR else None)
                for i, r in enumerate(registers)
            ),
        ), None
    if registers == [PC]:
        return moved, Leave(Load(address, 4))
    if PC in registers or (base in registers and insn.writeback):
        raise NotModelled(f"{insn.mnemonic} {insn.op_str}")
    loads = [Set(r, Load(_after(address, 4 * i), size, signed)) for i, r in enumerate(registers)]
    # The address is read before any register is loaded: one that holds it is loaded last.
    loads.sort(key=lambda load: load.register == base)
    return (*moved, *loads), None


def _after(address: Expr, offset: int) -> Expr:
    return Apply("+", address, Imm(offset)) if offset else address


def _saved(name: str, register: int) -> Literal["always"] | None:
    """r0 to r3 are pushed to make room, for arrays too."""
    return "always" if name in ("push", "stmdb") and (4 <= register <= 11 or register == LR) else None


def _several(insn: Any, name: str) -> Parts:
    """Loads and stores of a list of registers."""
    numbers = [_number(insn, o.reg) for o in insn.operands]
    if name in ("push", "pop"):
        base, listed, moves = SP, numbers, True
    else:
        base, *listed = numbers
        moves = bool(insn.writeback)
    listed.sort()
    size = 4 * len(listed)
    down = name in ("push", "stmdb", "ldmdb")
    first = Apply("-", Reg(base), Imm(size)) if down else Reg(base)
    if moves:
        # The base moves first; the words are then told from there.
        moved: tuple[Effect, ...] = (Set(base, Apply("-" if down else "+", Reg(base), Imm(size))),)
        start: Expr = Reg(base) if down else Apply("-", Reg(base), Imm(size))
    else:
        moved, start = (), first
    if name in ("push", "stm", "stmdb"):
        if moves and base in listed:
            raise NotModelled(f"{insn.mnemonic} {insn.op_str}")
        return (*moved, *(Put(_after(start, 4 * i), 4, Reg(r), _saved(name, r)) for i, r in enumerate(listed))), None
    loads: list[Effect] = [Set(r, Load(_after(start, 4 * i), 4)) for i, r in enumerate(listed) if r not in (PC, base)]
    if base in listed:
        if moves:
            raise NotModelled(f"{insn.mnemonic} {insn.op_str}")
        loads.append(Set(base, Load(_after(start, 4 * listed.index(base)), 4)))
    leave = Leave(Load(_after(start, size - 4), 4)) if PC in listed else None
    return (*moved, *loads), leave
