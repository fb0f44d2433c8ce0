"""The C that feeds a function from cases in an AVR's flash and tells what came of them on the serial port, in hex."""

from __future__ import annotations

from fuzzyspec.emit.names import name_module
from fuzzyspec.fixed.program import Program
from fuzzyspec.machines.harness import READERS, case, records
from fuzzyspec.machines.stack import PAINT
from fuzzyspec.native.layout import layout_of

_AVR = """
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/pgmspace.h>
#include <avr/sleep.h>
#define READ(p) pgm_read_byte(p)
#define PUT8(x) put((uint8_t)(x))
#define INLINE static inline __attribute__((always_inline))

extern const uint8_t fuzzyc_cases[] PROGMEM;
extern const uint16_t fuzzyc_n PROGMEM;

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


_N = "pgm_read_word(&fuzzyc_n)"
_SERIAL = ["    UCSR0A = (1 << U2X0);", "    UCSR0B = (1 << TXEN0);"]
_END = ["    cli();", "    sleep_enable();", "    sleep_cpu();", "    return 0;", "}", ""]


def print_cases(room: int) -> str:
    """Where the cases lie: ``fuzzyc_n`` of them, in ``room`` bytes that are filled in after the link."""
    text = "#include <avr/pgmspace.h>\n#include <stdint.h>\n"
    return f"{text}const uint16_t fuzzyc_n PROGMEM = 1;\nconst uint8_t fuzzyc_cases[{room}] PROGMEM = {{1}};\n"


def print_avr_batch(program: Program, function: str) -> str:
    """A program for one function: each case's result, a line each, and ``S``."""
    names = name_module(program)
    layout = layout_of(program, program.function(function), names)
    lines = [f'#include "{names.header}"', _AVR, READERS, "int main(void)", "{"]
    lines += ["    const uint8_t *in = fuzzyc_cases;", "    uint16_t n;", *records(layout, names.functions[function])]
    lines += [*_SERIAL, f"    for (n = {_N}; n != 0; --n) {{"]
    lines += [f"        {line}" for line in case(layout, names)]
    lines += ["        send('\\n');", "    }", "    send('S');", "    send('\\n');", *_END]
    return "\n".join(lines)


def print_avr_selftest(program: Program) -> str:
    """A program for the self-test: what it returns, and ``S``."""
    name = name_module(program).selftest
    lines = ["#include <stdint.h>", _AVR, READERS, f"uint16_t {name}(void);", "", "int main(void)", "{"]
    lines += [*_SERIAL, f"    const uint16_t failed = {name}();", "    PUT16(failed);"]
    lines += ["    send('\\n');", "    send('S');", "    send('\\n');", *_END]
    return "\n".join(lines)


_TIMERS = """
extern uint8_t __heap_start;
static uint16_t before, after, level;
static uint8_t coarse, overflown;

INLINE void times(void)
{
    send(' ');
    PUT16(before);
    PUT16(after);
    PUT8(coarse);
    PUT8(overflown);
    send('\\n');
}
"""

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
    lines = [f'#include "{names.header}"', _AVR, READERS, _TIMERS, *([_WRAPS] if long_calls else [])]
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
    lines += ["int main(void)", "{"]
    lines += ["    const uint8_t *in = fuzzyc_cases;", "    uint8_t *low = &__heap_start;", "    uint16_t n;"]
    lines += [*records(layout, c)]
    lines += [f"    while ((uint16_t)low < SP) {{ *low++ = {PAINT:#x}; }}"]
    lines += _SERIAL
    lines += ["    TCCR1B = (1 << CS10);", "    TCCR2B = (1 << CS22) | (1 << CS21) | (1 << CS20);"]
    lines += [f"    timed(nothing, {'0, ' if layout.state else ''}0, 0);", "    times();"]
    lines += [f"    for (n = {_N}; n != 0; --n) {{"]
    lines += [f"        {line}" for line in case(layout, names, timed=True)]
    lines += ["        times();", "    }", "    low = &__heap_start;"]
    lines += [f"    while (*low == {PAINT:#x}) {{ ++low; }}"]
    lines += ["    send('S');", "    PUT16(level - (uint16_t)low + 1);", "    send('\\n');", *_END]
    return "\n".join(lines)
