"""The C that feeds a function from a stream of cases (``stream``), on a target without library or operating system.

The harness calls nothing but the function: what the stack holds below the call is the function's alone.
"""

from __future__ import annotations

from collections.abc import Iterator

from fuzzyspec.emit.names import FunctionNames, Names, name_module
from fuzzyspec.fixed.program import Program
from fuzzyspec.machines.stack import PAINT
from fuzzyspec.native.layout import Layout, layout_of

_READERS = """
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

_AVR = """
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/pgmspace.h>
#include <avr/sleep.h>
#define READ(p) pgm_read_byte(p)
#define PUT8(x) put((uint8_t)(x))
#define INLINE static inline __attribute__((always_inline))

extern const uint8_t fuzzyc_cases[] PROGMEM;
extern const uint16_t fuzzyc_n;
extern uint8_t __heap_start;
static uint16_t before, after, level;
static uint8_t coarse, overflown;

INLINE void send(uint8_t c)
{
    while ((UCSR0A & (1 << UDRE0)) == 0) {
    }
    UDR0 = c;
}

INLINE void digit(uint8_t d)
{
    send((uint8_t)(d < 10 ? '0' + d : 'a' - 10 + d));
}

INLINE void put(uint8_t x)
{
    digit(x >> 4);
    digit(x & 15);
}
"""


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
    lines = [f'#include "{names.header}"', _EMULATED, _READERS]
    for index, function in enumerate(program.functions):
        layout = layout_of(program, function, names)
        signature = f"void {batch_symbol(index)}(uint32_t n, const uint8_t *in, uint8_t *out)"
        lines += [f"{signature};", signature, "{", *_records(layout, names.functions[function.name])]
        lines += ["    (void)in;", "    for (; n != 0U; --n) {"]
        lines += [f"        {line}" for line in _case(layout, names, direct=True)]
        lines += ["    }", "}", ""]
    return "\n".join(lines)


_WRAPS = """
static volatile uint8_t wraps;

ISR(TIMER2_OVF_vect)
{
    ++wraps;
}
"""


def print_avr_harness(program: Program, function: str, *, long_calls: bool = False) -> str:
    """A program for one function: each case's result in hex on the serial port, with the timers around the call.

    A line a case: the result's bytes, a blank, then low byte first timer 1 before and after (16 bits, one count a
    cycle) and timer 2 after (8 bits, one count in 1024 cycles, from 0) with how often it overflowed. The first line is
    the same for a function that returns at once, the last is ``S`` with the stack in bytes, return address included.

    Overflows are told by a flag, which is enough for half a million cycles. With ``long_calls`` an interrupt counts
    them: some 30 cycles in 262,144 are then its own, and up to 7 bytes of the stack.
    """
    names = name_module(program)
    layout = layout_of(program, program.function(function), names)
    c = names.functions[function]
    state = f"{c.state_t} *state, " if layout.state else ""
    passed = "state, in, out" if layout.state else "in, out"
    parameters = f"{state}const {c.input_t} *in, {c.output_t} *out"
    lines = [f'#include "{names.header}"', _AVR, *([_WRAPS] if long_calls else []), _READERS]
    lines += [f"typedef {names.status_t} called({parameters});", ""]
    # Through a pointer, so that an empty function is called by the very same instructions: their cost cancels out.
    lines += [f"static __attribute__((noinline)) {names.status_t} timed(called *function, {parameters})", "{"]
    lines += [f"    {names.status_t} status;", "    TCNT2 = 0;", "    TIFR2 = (1 << TOV2);", "    level = SP;"]
    lines += ["    wraps = 0;", "    TIMSK2 = (1 << TOIE2);", "    sei();"] if long_calls else []
    lines += ["    before = TCNT1;", f"    status = function({passed});", "    after = TCNT1;"]
    # A flag that is still up after the interrupts are off was nobody's: the timer had just overflowed.
    lines += ["    cli();"] if long_calls else []
    lines += ["    coarse = TCNT2;", "    overflown = TIFR2 & (1 << TOV2);"]
    lines += ["    overflown = (uint8_t)(overflown + wraps);"] if long_calls else []
    lines += ["    return status;", "}", ""]
    lines += [f"static __attribute__((naked, noinline)) {names.status_t} nothing({parameters})", "{"]
    lines += ['    __asm__ volatile ("ret");', "}", ""]
    lines += ["INLINE void times(void)", "{", "    send(' ');"]
    lines += ["    PUT16(before);", "    PUT16(after);", "    PUT8(coarse);", "    PUT8(overflown);"]
    lines += ["    send('\\n');", "}", "", "int main(void)", "{"]
    lines += ["    const uint8_t *in = fuzzyc_cases;", "    uint8_t *low = &__heap_start;", "    uint16_t n;"]
    lines += [*_records(layout, c)]
    lines += [f"    while ((uint16_t)low < SP) {{ *low++ = {PAINT:#x}; }}"]
    lines += ["    UCSR0A = (1 << U2X0);", "    UCSR0B = (1 << TXEN0);"]
    lines += ["    TCCR1B = (1 << CS10);", "    TCCR2B = (1 << CS22) | (1 << CS21) | (1 << CS20);"]
    lines += [f"    timed(nothing, {'0, ' if layout.state else ''}0, 0);", "    times();"]
    lines += ["    for (n = fuzzyc_n; n != 0; --n) {"]
    lines += [f"        {line}" for line in _case(layout, names, direct=False)]
    lines += ["        times();", "    }", "    low = &__heap_start;"]
    lines += [f"    while (*low == {PAINT:#x}) {{ ++low; }}"]
    lines += ["    send('S');", "    PUT16(level - (uint16_t)low + 1);", "    send('\\n');"]
    lines += ["    cli();", "    sleep_enable();", "    sleep_cpu();", "    return 0;", "}", ""]
    return "\n".join(lines)


def _records(layout: Layout, c: FunctionNames) -> Iterator[str]:
    """Room for the lists, outside of the stack."""
    for k, listed in enumerate(layout.lists):
        yield f"    static {c.records[listed.name]} records_{k}[{listed.capacity}];"


def _case(layout: Layout, names: Names, *, direct: bool) -> Iterator[str]:
    """Fill from the stream, call, write to the stream. What a function leaves unset shows as a pattern."""
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
    yield f"status = {c.function}({arguments});" if direct else f"status = timed({c.function}, {arguments});"
    for slot in layout.outputs:
        yield f"PUT{slot.ctype.lstrip('uint')}(output.{slot.member});"
    yield "PUT32((uint32_t)status);"
    for slot in layout.state:
        yield f"PUT{slot.ctype.lstrip('uint')}(state.{slot.member});"
