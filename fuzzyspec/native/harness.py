"""The C that loops over a batch: part of the host build only, never of what is compiled for a target.

Each function gets ``fuzzycharness_batch_<i>(n, widths, in, out, at)`` over its layout's arrays. A case gets a fresh
input struct, an array that holds its own list's records and no more, and an output struct filled with a pattern, so
that what a function leaves unset shows. ``*at`` is the case that is running: whoever finds the process dead reads it
there.
"""

from __future__ import annotations

from collections.abc import Iterator

from fuzzyspec.emit.names import FunctionNames, name_module
from fuzzyspec.fixed.build import LIMITS
from fuzzyspec.fixed.program import Function, Program
from fuzzyspec.native.layout import Layout, layout_of, out_types, ports_of, states_of

SIGNATURE = (
    "int fuzzycharness_batch_{index}(size_t n, const size_t *widths, const void *const *in, void *const *out, "
    "volatile uint64_t *at)"
)
SELFTEST = "unsigned fuzzycharness_selftest(void)"


def print_harness(program: Program) -> str:
    """The harness of every function of a program."""
    names = name_module(program)
    layouts = [layout_of(program, f, names) for f in program.functions]
    lines = [
        "#include <stdlib.h>",
        "#include <string.h>",
        '#include "batches.h"',
        f'#include "../product/{names.header}"',
        "",
    ]
    lines += [f"uint16_t {names.selftest}(void);", ""]
    for index, layout in enumerate(layouts):
        lines += _batch(index, layout, names.functions[layout.function])
    for index, (layout, function) in enumerate(zip(layouts, program.functions, strict=True)):
        lines += _shape(index, layout, function, program)
    lines += [
        f"const size_t fuzzycharness_functions = {len(layouts)};",
        "",
        "fuzzycharness_batch *const fuzzycharness_batches[] = {",
    ]
    lines += [f"    fuzzycharness_batch_{i}," for i in range(len(layouts))]
    lines += ["};", "", "const fuzzycharness_shape fuzzycharness_shapes[] = {"]
    for index, layout in enumerate(layouts):
        ins, outs = len(layout.inputs) + len(layout.state), len(layout.outputs) + 1 + len(layout.state)
        lines += [f"    {{{ins}, {outs}, {len(layout.lists)}, slots_{index}, capacities_{index}}},"]
    lines += ["};", "", SELFTEST, "{", f"    return (unsigned){names.selftest}();", "}"]
    return "\n".join(lines) + "\n"


def _shape(index: int, layout: Layout, function: Function, program: Program) -> Iterator[str]:
    """Legal raws and C types of every array, for whoever makes cases up."""
    legal = {k: (p.lo, p.hi) for k, p in ports_of(function).items()}
    legal |= {f"state {k}": (p.lo, p.hi) for k, p in states_of(program, function).items()}
    capacities = [listed.capacity for listed in layout.lists]
    counts = {listed.count: k for k, listed in enumerate(layout.lists)}
    yield f"static const size_t capacities_{index}[] = {{{', '.join(str(c) for c in [*capacities, 0])}}};"
    yield f"static const fuzzycharness_slot slots_{index}[] = {{"
    for k, slot in enumerate(layout.inputs):
        low, high = LIMITS[slot.ctype]
        lo, hi = (0, capacities[counts[k]]) if k in counts else legal[slot.key]
        of = counts.get(k, -1 if slot.list is None else slot.list)
        yield f"    {{sizeof({slot.ctype}_t), {int(k in counts)}, 0, {of}, {lo}, {hi}, {low}, {high}}},"
    for slot in layout.state:
        lo, hi = legal[f"state {slot.key}"]
        yield f"    {{sizeof({slot.ctype}_t), 0, 1, -1, {lo}, {hi}, {lo}, {hi}}},"
    for ctype in out_types(layout):
        yield f"    {{sizeof({ctype}_t), 0, 0, -1, 0, 0, 0, 0}},"
    yield "};"
    yield ""


def _batch(index: int, layout: Layout, names: FunctionNames) -> Iterator[str]:
    ins = layout.inputs + layout.state
    yield f"static {SIGNATURE.format(index=index)}"
    yield "{"
    for k, slot in enumerate(ins):
        yield f"    const {slot.ctype}_t *const in_{k} = (const {slot.ctype}_t *)in[{k}];"
    for k, ctype in enumerate(out_types(layout)):
        yield f"    {ctype}_t *const out_{k} = ({ctype}_t *)out[{k}];"
    yield "    size_t i;"
    if not layout.lists:
        yield "    (void)widths;"
    if not ins:
        yield "    (void)in;"
    yield ""
    yield "    for (i = 0; i < n; ++i) {"
    yield from (f"        {line}" if line else "" for line in _case(layout, names))
    yield "    }"
    yield "    return 0;"
    yield "}"
    yield ""


def _case(layout: Layout, names: FunctionNames) -> Iterator[str]:
    """One case: fill, call, scatter."""
    yield f"{names.input_t} input;"
    yield f"{names.output_t} output;"
    if layout.state:
        yield f"{names.state_t} state;"
    for k, listed in enumerate(layout.lists):
        count = f"(size_t)in_{listed.count}[i]"
        yield f"const size_t held_{k} = {count} < widths[{k}] ? {count} : widths[{k}];"
        record, made = names.records[listed.name], f"calloc(held_{k}, sizeof *records_{k})"
        yield f"{record} *const records_{k} = held_{k} == 0 ? NULL : {made};"
        yield f"size_t j_{k};"
    yield ""
    yield "memset(&input, 0, sizeof input);"
    yield "memset(&output, 0xA5, sizeof output);"
    for k, slot in enumerate(layout.inputs):
        if slot.list is None:
            yield f"input.{slot.member} = in_{k}[i];"
    for k, listed in enumerate(layout.lists):
        yield f"if (held_{k} != 0 && records_{k} == NULL) {{"
        yield "    return 1;"
        yield "}"
        yield f"for (j_{k} = 0; j_{k} < held_{k}; ++j_{k}) {{"
        for f in listed.fields:
            yield f"    records_{k}[j_{k}].{layout.inputs[f].member} = in_{f}[i * widths[{k}] + j_{k}];"
        yield "}"
        yield f"input.{names.inputs[listed.name]} = records_{k};"
    if layout.state:
        yield "memset(&state, 0, sizeof state);"
    for k, slot in enumerate(layout.state, start=len(layout.inputs)):
        yield f"state.{slot.member} = in_{k}[i];"
    yield "*at = (uint64_t)i;"
    status = len(layout.outputs)
    arguments = "&state, &input, &output" if layout.state else "&input, &output"
    yield f"out_{status}[i] = (uint32_t){names.function}({arguments});"
    for k, slot in enumerate(layout.outputs):
        yield f"out_{k}[i] = output.{slot.member};"
    for k, slot in enumerate(layout.state, start=status + 1):
        yield f"out_{k}[i] = state.{slot.member};"
    for k in range(len(layout.lists)):
        yield f"free(records_{k});"
