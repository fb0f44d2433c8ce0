"""Instructions run over sets of values, and what a condition says of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import assert_never

from fuzzyspec.cost.worst.code import (
    CONTRARY,
    Add,
    Apply,
    Branch,
    Carry,
    Compare,
    Condition,
    Effect,
    Expr,
    Forget,
    Imm,
    Instruction,
    Judge,
    Load,
    Narrow,
    Pair,
    Put,
    Reg,
    Set,
    SetPair,
    ShiftRight,
    Subtract,
)
from fuzzyspec.cost.worst.state import (
    NO_FLAGS,
    UNKNOWN_CARRY,
    Difference,
    Flags,
    Outcome,
    State,
    extended,
    joined,
    loss,
)
from fuzzyspec.cost.worst.values import (
    Value,
    between,
    constant,
    may_equal,
    operate,
    signed,
    unsigned,
    within,
    within_signed,
    without,
)


def evaluate(expr: Expr, state: State, bits: int) -> Value:
    """What an expression may be, as a word of ``bits`` bits."""
    match expr:
        case Reg(number):
            return state.registers[number]
        case Imm(word):
            return constant(word, bits)
        case Apply(operator, left, right, width):
            return operate(operator, evaluate(left, state, width), evaluate(right, state, width), width)
        case Pair(low):
            low_byte, high_byte = state.registers[low], state.registers[low + 1]
            return _combined(low_byte, high_byte, 8)
        case Load(address, size, is_signed, program):
            at = evaluate(address, state, 16 if state.bits == 8 else 32)
            return extended(state.load(at, size, program), size, is_signed, bits)
        case Narrow(value, width, is_signed):
            whole = operate("&", evaluate(value, state, bits), constant((1 << width) - 1, bits), bits)
            return extended(whole, width // 8, is_signed, bits) if is_signed else whole
        case Carry():
            return state.flags.carry
        case _:
            assert_never(expr)


def _combined(low: Value, high: Value, low_bits: int) -> Value:
    """Bytes put together, the low one in ``low_bits``."""
    (llo, lhi), (hlo, hhi) = unsigned(low, low_bits), unsigned(high, 8)
    lo, hi = llo | hlo << low_bits, lhi | hhi << low_bits
    step = 1
    if high.step == 0:
        step = low.step if low.hi == lhi else 1
    elif low.step == 0 and high.hi == hhi:
        step = high.step << low_bits
    return between(lo, hi, step, low_bits + 8)


def apply(effect: Effect, state: State) -> None:
    """Change the state as the effect does."""
    if not isinstance(effect, Set | SetPair | Put):
        state.assumed = None
    match effect:
        case Set(register, value):
            state.set(register, evaluate(value, state, state.bits))
        case SetPair(low, value):
            word = evaluate(value, state, 16)
            state.set(low, operate("&", word, constant(255, 16), 16))
            state.set(low + 1, operate(">>", word, constant(8, 16), 16))
        case Put(address, size, value, saved):
            at = evaluate(address, state, 16 if state.bits == 8 else 32)
            word = evaluate(value, state, state.bits)
            kept = operate("&", word, constant((1 << 8 * size) - 1, state.bits), state.bits)
            untouched = isinstance(value, Reg) and not state.written >> value.number & 1
            state.store(at, size, kept, saved == "always" or (saved == "unless written" and untouched))
        case Compare(left, right, bits, extends):
            state.flags = _difference(left, right, bits, extends, state)
        case Subtract(register, left, right, bits, extends):
            _subtract(effect, state)
        case Add():
            _add(effect, state)
        case ShiftRight():
            _shift_right(effect, state)
        case Judge(register, bits, carry):
            new = state.flags.carry if carry == "kept" else UNKNOWN_CARRY
            if carry is not None and carry != "kept":
                new = evaluate(carry, state, bits)
            paired = bits > state.bits
            judged = evaluate(Pair(register) if paired else Reg(register), state, bits)
            state.flags = Flags(None, Outcome(judged, bits, None if paired else register), new)
        case Forget():
            state.flags = NO_FLAGS
        case _:
            assert_never(effect)


def _held(expr: Expr) -> int | None:
    return expr.number if isinstance(expr, Reg) else None


def _difference(left: Expr, right: Expr, bits: int, extends: bool, state: State) -> Flags:
    a, b = evaluate(left, state, bits), evaluate(right, state, bits)
    if not extends:
        difference = Difference(a, b, bits, _held(left), _held(right))
        return Flags(difference, None, _carry_of(difference, state))
    below = state.flags.difference
    if below is None:
        borrow = state.flags.carry
        (alo, ahi), (blo, bhi) = unsigned(a, bits), unsigned(b, bits)
        certain, possible = ahi < blo + borrow.lo, alo < bhi + borrow.hi
        return Flags(None, None, constant(int(certain), 8) if certain == possible else UNKNOWN_CARRY)
    wide = below.bits + bits
    difference = Difference(
        _combined(below.left, a, below.bits), _combined(below.right, b, below.bits), wide, None, None
    )
    return Flags(difference, None, _carry_of(difference, state))


def _carry_of(difference: Difference, state: State) -> Value:
    """AVR sets its carry where a subtraction borrows, ARM where it does not."""
    borrows = holds("lo", difference)
    return UNKNOWN_CARRY if borrows is None else constant(int(borrows == (state.bits == 8)), 8)


def _subtract(effect: Subtract, state: State) -> None:
    bits = effect.bits
    flags = _difference(effect.left, effect.right, bits, effect.extends, state)
    value = operate("-", evaluate(effect.left, state, bits), evaluate(effect.right, state, bits), bits)
    if effect.extends:
        value = operate("-", value, state.flags.carry, bits)
    difference = flags.difference
    if difference is not None:
        left_in = None if difference.left_in == effect.register else difference.left_in
        right_in = None if difference.right_in == effect.register else difference.right_in
        difference = difference._replace(left_in=left_in, right_in=right_in)
    outcome = None if effect.extends else Outcome(value, bits, effect.register)
    state.set(effect.register, value)
    state.flags = Flags(difference, outcome, flags.carry)


def _add(effect: Add, state: State) -> None:
    bits = effect.bits
    a, b = evaluate(effect.left, state, bits), evaluate(effect.right, state, bits)
    carry = evaluate(effect.carry, state, bits)
    value = operate("+", operate("+", a, b, bits), carry, bits)
    (alo, ahi), (blo, bhi), (clo, chi) = unsigned(a, bits), unsigned(b, bits), unsigned(carry, bits)
    if isinstance(effect.left, Reg) and effect.left == effect.right:
        least, most = 2 * alo + clo, 2 * ahi + chi
    else:
        least, most = alo + blo + clo, ahi + bhi + chi
    carried = UNKNOWN_CARRY
    if least >> bits == most >> bits:
        carried = constant(least >> bits, 8)
    state.set(effect.register, value)
    state.flags = Flags(None, Outcome(value, bits, effect.register), carried)


def _shift_right(effect: ShiftRight, state: State) -> None:
    bits = effect.bits
    old = state.registers[effect.register]
    lost = operate("&", old, constant(1, bits), bits)
    value = operate(effect.operator, old, constant(1, bits), bits)
    if effect.rotates:
        value = operate("|", value, operate("<<", state.flags.carry, constant(bits - 1, bits), bits), bits)
    state.set(effect.register, value)
    state.flags = Flags(None, Outcome(value, bits, effect.register), lost)


# --- conditions ------------------------------------------------------------------------------


def holds(condition: Condition, difference: Difference) -> bool | None:
    """Whether a condition holds of ``left - right``; None where it may and may not."""
    a, b, bits = difference.left, difference.right, difference.bits
    if a.base is not None and b.base is not None and a.base[0] == b.base[0]:
        return _holds_apart(condition, a, b, bits)
    match condition:
        case "eq" | "ne":
            if not may_equal(a, b, bits):
                return condition == "ne"
            return condition == "eq" if a.step == b.step == 0 else None
        case "lo" | "hs" | "ls" | "hi":
            (alo, ahi), (blo, bhi) = unsigned(a, bits), unsigned(b, bits)
        case "lt" | "ge" | "le" | "gt":
            (alo, ahi), (blo, bhi) = signed(a, bits), signed(b, bits)
        case "mi" | "pl":
            lo, hi = signed(operate("-", a, b, bits), bits)
            return None if lo < 0 <= hi else (hi < 0) == (condition == "mi")
        case _:
            return None
    match condition:
        case "lo" | "lt" | "hs" | "ge":
            below = True if ahi < blo else False if alo >= bhi else None
            return below if below is None else below == (condition in ("lo", "lt"))
        case _:
            most = True if ahi <= blo else False if alo > bhi else None
            return most if most is None else most == (condition in ("ls", "le"))


def _holds_apart(condition: Condition, a: Value, b: Value, bits: int) -> bool | None:
    """``holds`` of two values whose difference is known."""
    apart = operate("-", a, b, bits).lo
    match condition:
        case "eq" | "ne":
            return (apart == 0) == (condition == "eq")
        case "lo" | "hs" | "ls" | "hi":
            (alo, ahi), (blo, bhi) = unsigned(a, bits), unsigned(b, bits)
        case "lt" | "ge" | "le" | "gt":
            (alo, ahi), (blo, bhi) = signed(a, bits), signed(b, bits)
        case _:
            return None
    found = [d for d in (apart, apart - (1 << bits)) if alo - bhi <= d <= ahi - blo]
    if len(found) != 1:
        return None
    below = found[0] < 0 or (found[0] == 0 and condition in ("ls", "le", "hi", "gt"))
    return below == (condition in ("lo", "ls", "lt", "le"))


def where(condition: Condition, branch: Branch | None, state: State) -> State | None:
    """The state, changed to what is left of it where the condition holds; None where it cannot.

    The condition is of the two values that the branch names, else of the flags.
    """
    if branch is not None and branch.compared is not None:
        left, right = branch.compared
        a, b = evaluate(left, state, branch.bits), evaluate(right, state, branch.bits)
        return _where_difference(condition, Difference(a, b, branch.bits, _held(left), _held(right)), state)
    difference, outcome, carry = state.flags
    if condition in ("lo", "hs") and carry.step == 0:
        set_where = "lo" if state.bits == 8 else "hs"
        return state if (carry.lo == 1) == (condition == set_where) else None
    found: State | None = state
    if difference is not None:
        found = _where_difference(condition, difference, state)
    if outcome is not None and found is not None and condition in ("eq", "ne", "mi", "pl"):
        zero = Difference(outcome.value, constant(0, outcome.bits), outcome.bits, outcome.held_in, None)
        found = _where_difference(condition, zero, found)
    return found


def _where_difference(condition: Condition, difference: Difference, state: State) -> State | None:
    known = holds(condition, difference)
    if known is not None:
        return state if known else None
    a, b, bits, left_in, right_in = difference
    for held, other, told in ((left_in, b, condition), (right_in, a, _MIRRORED.get(condition))):
        if held is None or told is None:
            continue
        kept = _part(told, state.registers[held], other, bits)
        if kept is None:
            return None
        state.restrict(held, kept)
    return state


_MIRRORED: dict[Condition, Condition] = {
    "eq": "eq",
    "ne": "ne",
    "lo": "hi",
    "hi": "lo",
    "ls": "hs",
    "hs": "ls",
    "lt": "gt",
    "gt": "lt",
    "le": "ge",
    "ge": "le",
}


def _part(condition: Condition, value: Value, other: Value, bits: int) -> Value | None:
    """The words of ``value`` of which the condition can hold against some word of ``other``."""
    top, half = (1 << bits) - 1, 1 << (bits - 1)
    lo, hi = signed(other, bits) if condition in ("lt", "ge", "le", "gt") else unsigned(other, bits)
    match condition:
        case "eq":
            return within(value, lo, hi, bits)
        case "ne":
            return without(value, other.lo, bits) if other.step == 0 else value
        case "lo":
            return within(value, 0, hi - 1, bits)
        case "ls":
            return within(value, 0, hi, bits)
        case "hi":
            return within(value, lo + 1, top, bits)
        case "hs":
            return within(value, lo, top, bits)
        case "lt":
            return within_signed(value, -half, hi - 1, bits)
        case "le":
            return within_signed(value, -half, hi, bits)
        case "gt":
            return within_signed(value, lo + 1, half - 1, bits)
        case "ge":
            return within_signed(value, lo, half - 1, bits)
        case "mi":
            return within_signed(value, -half, -1, bits) if other.step == other.lo == 0 else value
        case "pl":
            return within_signed(value, 0, half - 1, bits) if other.step == other.lo == 0 else value
        case _:
            return value


_MOST_STATES = 4
"""How many states are told apart behind guarded instructions: of more, the most alike are joined."""


def run(instructions: Sequence[Instruction], state: State) -> list[State]:
    """The states after a straight run of instructions: told apart by the conditions of guarded ones."""
    states, guarded = [state], 0
    for instruction in instructions:
        if instruction.guards:
            states = [part for one in states for part in _assuming(instruction.guards[0], one)]
            guarded = len(instruction.guards)
            continue
        states = [_run(instruction, one) for one in states]
        guarded -= 1
        if guarded == 0:
            for one in states:
                one.assumed = None
            while len(states) > _MOST_STATES:
                _, i, j = min((loss(states[i], states[j]), i, j) for j in range(len(states)) for i in range(j))
                states[i] = joined(states[i], states.pop(j))
    return states


def _assuming(condition: Condition, state: State) -> Iterator[State]:
    """What is left of a state where a condition holds, and where it does not."""
    for assumed in (condition, CONTRARY[condition]):
        part = where(assumed, None, state.copy())
        if part is not None:
            part.assumed = assumed
            yield part


def _run(instruction: Instruction, state: State) -> State:
    """The state after an instruction's effects; where its guard may fail, after either."""
    guard = instruction.guard
    if guard is None or guard == state.assumed:
        for effect in instruction.effects:
            apply(effect, state)
        return state
    if state.assumed == CONTRARY[guard]:
        return state
    done, left = where(guard, None, state.copy()), where(CONTRARY[guard], None, state)
    if done is not None:
        for effect in instruction.effects:
            apply(effect, done)
    if done is None or left is None:
        found = left if done is None else done
        if found is None:
            raise AssertionError("a condition neither holds nor fails")
        return found
    return joined(done, left)
