"""The C that feeds a function from a stream of cases (``stream``), on a target without library or operating system.

The harness calls nothing but the function: what the stack holds below the call is the function's alone. How many cases
are left is in ``LEFT``, for whoever finds that a call did not return.
"""

from __future__ import annotations

from collections.abc import Iterator

from fuzzyspec.emit.names import FunctionNames, Names, name_module
from fuzzyspec.fixed.program import Program
from fuzzyspec.native.layout import Layout, layout_of

READERS = """
#define GET8() (in += 1, READ(in - 1))
#define GET16() (in += 2, (uint16_t)(READ(in - 2) | (uint16_t)((uint16_t)READ(in - 1) << 8)))
#define GET32() (in += 4, (uint32_t)READ(in - 4) | (uint32_t)READ(in - 3) << 8 \\
    | (uint32_t)READ(in - 2) << 16 | (uint32_t)READ(in - 1) << 24)
#define PUT16(x) do { PUT8(x); PUT8((uint16_t)(x) >> 8); } while (0)
#define PUT32(x) do { PUT16(x); PUT16((uint32_t)(x) >> 16); } while (0)
"""

_EMULATED = """
#define READ(p) (*(p))
#define PUT8(x) (*out++ = (uint8_t)(x))
"""

LEFT = "fuzzyc_left"
"""``volatile uint32_t``: cases that have not come to their end, the one that runs included."""


def batch_symbol(index: int) -> str:
    """The harness of the program's function with that index."""
    return f"fuzzyc_batch_{index}"


def pointer_symbol(index: int) -> str:
    """The probe's pointers of the program's function with that index."""
    return f"fuzzyc_pointers_{index}"


def print_probe(program: Program) -> str:
    """Arguments for every function, as data: ``const void *const fuzzyc_pointers_<i>[]`` holds how many arguments it
    takes, the arguments, and for every list of its input the place of the pointer and the records that it points to.
    """
    names = name_module(program)
    lines = [f'#include "{names.header}"']
    for index, function in enumerate(program.functions):
        layout = layout_of(program, function, names)
        c = names.functions[function.name]
        stem = f"fuzzyc_probe_{index}"
        lines += [f"static {c.input_t} {stem}_in;", f"static {c.output_t} {stem}_out;"]
        arguments = [f"&{stem}_in", f"&{stem}_out"]
        if layout.state:
            lines.append(f"static {c.state_t} {stem}_state;")
            arguments.insert(0, f"&{stem}_state")
        words = [f"(const void *){len(arguments)}", *arguments]
        for k, listed in enumerate(layout.lists):
            lines.append(f"static {c.records[listed.name]} {stem}_list_{k}[{listed.capacity}];")
            words += [f"&{stem}_in.{c.inputs[listed.name]}", f"{stem}_list_{k}"]
        symbol = f"const void *const {pointer_symbol(index)}[{len(words)}]"
        lines += [f"extern {symbol};", f"{symbol} = {{ {', '.join(words)} }};", ""]
    return "\n".join(lines)


def print_emulated_harness(program: Program) -> str:
    """``void fuzzyc_batch_<i>(uint32_t n, const uint8_t *in, uint8_t *out)`` for every function: n cases."""
    names = name_module(program)
    lines = [f'#include "{names.header}"', _EMULATED, READERS]
    lines += [f"extern volatile uint32_t {LEFT};", f"volatile uint32_t {LEFT};", ""]
    for index, function in enumerate(program.functions):
        layout = layout_of(program, function, names)
        signature = f"void {batch_symbol(index)}(uint32_t n, const uint8_t *in, uint8_t *out)"
        lines += [f"{signature};", signature, "{", *records(layout, names.functions[function.name])]
        lines += ["    (void)in;", "    for (; n != 0U; --n) {", f"        {LEFT} = n;"]
        lines += [f"        {line}" for line in case(layout, names)]
        lines += ["    }", "}", ""]
    return "\n".join(lines)


def records(layout: Layout, c: FunctionNames) -> Iterator[str]:
    """Room for the lists, outside of the stack."""
    for k, listed in enumerate(layout.lists):
        yield f"    static {c.records[listed.name]} records_{k}[{listed.capacity}];"


def case(layout: Layout, names: Names, *, timed: bool = False) -> Iterator[str]:
    """Fill from the stream, call (through ``timed``), write. What a function leaves unset shows as a pattern."""
    c = names.functions[layout.function]
    yield f"{c.input_t} input;"
    yield f"{c.output_t} output;"
    if layout.state:
        yield f"{c.state_t} state;"
    yield f"{names.status_t} status;"
    yield "volatile uint8_t *byte = (volatile uint8_t *)&output;"
    yield "uint16_t k;"
    yield "for (k = 0; k < sizeof output; ++k) { byte[k] = 0xA5U; }"
    for slot in layout.inputs:
        bits = slot.ctype.lstrip("uint")
        if slot.list is None:
            yield f"input.{slot.member} = ({slot.ctype}_t)GET{bits}();"
        else:
            element = f"records_{slot.list}[k].{slot.member}"
            capacity = layout.lists[slot.list].capacity
            yield f"for (k = 0; k < {capacity}; ++k) {{ {element} = ({slot.ctype}_t)GET{bits}(); }}"
    for k, listed in enumerate(layout.lists):
        yield f"input.{c.inputs[listed.name]} = records_{k};"
    for slot in layout.state:
        yield f"state.{slot.member} = ({slot.ctype}_t)GET{slot.ctype.lstrip('uint')}();"
    arguments = "&state, &input, &output" if layout.state else "&input, &output"
    yield f"status = timed({c.function}, {arguments});" if timed else f"status = {c.function}({arguments});"
    for slot in layout.outputs:
        yield f"PUT{slot.ctype.lstrip('uint')}(output.{slot.member});"
    yield "PUT32((uint32_t)status);"
    for slot in layout.state:
        yield f"PUT{slot.ctype.lstrip('uint')}(state.{slot.member});"
