"""Every C name of a module, decided in one place and free of clashes.

Names that would meet a keyword, a type of ``<stdint.h>`` or each other get underscores at the end.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from fuzzyspec.fixed.division import Kernel, kernel_of, shared
from fuzzyspec.fixed.program import Function, ListPort, Program, Quotient
from fuzzyspec.fixed.prune import expressions, nodes, prune

_KEYWORDS = """
    auto break case char const continue default do double else enum extern float for goto if inline int long register
    restrict return short signed sizeof static struct switch typedef union unsigned void volatile while
    alignas alignof bool char16_t char32_t constexpr decltype false noreturn nullptr static_assert
    thread_local true typeof typeof_unqual
    and and_eq asm bitand bitor catch char8_t class co_await co_return co_yield compl concept consteval constinit
    const_cast delete dynamic_cast explicit export friend mutable namespace new noexcept not not_eq operator or or_eq
    private protected public reinterpret_cast requires static_cast template this throw try typeid typename using virtual
    wchar_t xor xor_eq linux unix i386
"""
_STDINT = [
    f"{sign}int{kind}{bits}_t" for sign in ("", "u") for kind in ("", "_least", "_fast") for bits in (8, 16, 32, 64)
]
RESERVED = frozenset(_KEYWORDS.split()) | frozenset(_STDINT) | {"intmax_t", "uintmax_t", "intptr_t", "uintptr_t"}


class Scope:
    """Names in use; ``claim`` hands out one that is still free.

    Where ``capitals`` may not stand, as they may for macros, names without a small letter are not free: ``SP`` and
    ``PORTB`` are registers to whoever includes ``<avr/io.h>``, and so in the vendors' headers for other machines.
    """

    def __init__(self, taken: Iterable[str] = (), *, capitals: bool = True) -> None:
        self._taken = set(taken)
        self._capitals = capitals

    def _hidden(self, name: str) -> bool:
        register = not self._capitals and re.fullmatch(r"[A-Z][A-Z0-9_]*[A-Z0-9]", name) is not None
        return register or name in self._taken or name in RESERVED

    def free(self, name: str) -> bool:
        """Whether ``claim`` would give the name as it is."""
        return name == identifier(name) and not self._hidden(name)

    def taken(self) -> frozenset[str]:
        """Every name handed out."""
        return frozenset(self._taken)

    def claim_stem(self, stem: str) -> str:
        """A stem whose ``_MIN`` and ``_MAX`` are free."""
        wanted = identifier(stem)
        while not (self.free(f"{wanted}_MIN") and self.free(f"{wanted}_MAX")):
            wanted += "_"
        self._taken |= {wanted, f"{wanted}_MIN", f"{wanted}_MAX"}
        return wanted

    def claim(self, name: str) -> str:
        """The name, or where it is taken the name with underscores."""
        wanted = identifier(name)
        while self._hidden(wanted):
            wanted += "_"
        self._taken.add(wanted)
        return wanted


@dataclass(frozen=True)
class FunctionNames:
    """``macro`` leads the function's macros; ``fields`` names input, output and state members by signal."""

    function: str
    input_t: str
    output_t: str
    state_t: str
    init: str
    macro: str
    inputs: Mapping[str, str]
    outputs: Mapping[str, str]
    state: Mapping[str, str]
    records: Mapping[str, str]
    record_fields: Mapping[str, Mapping[str, str]]
    counts: Mapping[str, str]
    tables: Mapping[str, str]
    bits: Mapping[str, str]
    limits: Mapping[str, str]
    """``NAV_OBSTACLES_MAX`` by list; of a scalar or field the macro that ``_MIN`` and ``_MAX`` are added to."""


@dataclass(frozen=True)
class Names:
    """``functions`` by the model's names, ``quotients`` by how a node divides, ``dividers`` by what is written.

    ``globals`` is everything that a local must not hide.
    """

    prefix: str
    macro: str
    status_t: str
    ok: str
    digest: str
    selftest: str
    mul_high: str
    quotients: Mapping[Kernel, str]
    dividers: Mapping[Kernel, str]
    reciprocals: str
    functions: Mapping[str, FunctionNames]
    globals: frozenset[str]
    macros: frozenset[str]

    @property
    def header(self) -> str:
        return f"{self.prefix}.h"

    @property
    def source(self) -> str:
        return f"{self.prefix}.c"

    @property
    def selftest_source(self) -> str:
        return f"{self.prefix}_selftest.c"


def identifier(name: str) -> str:
    """The name with everything that C does not allow replaced by an underscore."""
    text = re.sub(r"[^0-9A-Za-z_]", "_", name)
    return f"_{text}" if not text or text[0].isdigit() else text


def singular(list_name: str) -> str:
    """``obstacles`` -> ``obstacle``; without a final s, ``_item`` is added."""
    return list_name[:-1] if len(list_name) > 1 and list_name.endswith("s") else f"{list_name}_item"


def name_module(program: Program) -> Names:
    """Systems choose first, so that ``<prefix>_step`` is never a controller called ``step``."""
    prefix = identifier(program.name)
    macro = prefix.upper()
    symbols = Scope()
    macros = Scope()
    one_system = sum(f.kind == "system" for f in program.functions) == 1
    status_t = symbols.claim(f"{prefix}_status_t")
    ok = macros.claim(f"{macro}_OK")
    digest = macros.claim(f"{macro}_SPEC_DIGEST")
    selftest = symbols.claim(f"{prefix}_selftest")
    mul_high = symbols.claim(f"{prefix}_mul_high")
    kernels = shared(_kernels(program))
    dividers = {
        kernel: symbols.claim(f"{prefix}_quotient_{number}" if number > 1 else f"{prefix}_quotient")
        for number, kernel in enumerate(sorted(set(kernels.values())), start=1)
    }
    reciprocals = symbols.claim(f"{prefix}_reciprocals")
    for suffix in ("H", "TABLE", *(f"READ_{sign}{bits}" for sign in "US" for bits in (8, 16, 32))):
        macros.claim(f"{macro}_{suffix}")
    named: dict[str, FunctionNames] = {}
    for function in sorted(program.functions, key=lambda f: f.kind != "system"):
        stem = prefix if function.kind == "system" and one_system else f"{prefix}_{identifier(function.name)}"
        named[function.name] = _name_function(function, stem, symbols, macros)
    return Names(
        prefix,
        macro,
        status_t,
        ok,
        digest,
        selftest,
        mul_high,
        {kernel: dividers[kernels[kernel]] for kernel in kernels},
        dividers,
        reciprocals,
        {f.name: named[f.name] for f in program.functions},
        symbols.taken(),
        macros.taken(),
    )


def _kernels(program: Program) -> set[Kernel]:
    """What divides in a program, as it is printed."""
    printed = (e for f in program.functions for e in expressions(prune(f.body)))
    return {kernel_of(n) for e in printed for n in nodes(e) if isinstance(n, Quotient)}


def _name_function(function: Function, stem: str, symbols: Scope, macros: Scope) -> FunctionNames:
    macro = stem.upper()
    called = symbols.claim(f"{stem}_step" if function.kind == "system" else stem)
    input_t = symbols.claim(f"{stem}_input_t")
    output_t = symbols.claim(f"{stem}_output_t")
    state_t = symbols.claim(f"{stem}_state_t")
    init = symbols.claim(f"{stem}_init")
    lists = [p for p in function.inputs if isinstance(p, ListPort)]
    members = Scope(capitals=False)
    inputs = {p.name: members.claim(p.name) for p in function.inputs}
    counts = {p.name: members.claim(f"{inputs[p.name]}_count") for p in lists}
    return FunctionNames(
        function=called,
        input_t=input_t,
        output_t=output_t,
        state_t=state_t,
        init=init,
        macro=macro,
        inputs=inputs,
        outputs=_members(p.name for p in function.outputs),
        state=_members([*(p.name for p in function.state), *(name for name, _ in function.nested)]),
        records={p.name: symbols.claim(f"{stem}_{singular(identifier(p.name))}_t") for p in lists},
        record_fields={p.name: _members(f.name for f in p.fields) for p in lists},
        counts=counts,
        tables={t.name: symbols.claim(f"{called}_{t.name}") for t in function.tables},
        bits={b.name: macros.claim(f"{macro}_{b.name}") for b in function.status},
        limits=_limits(function, macro, macros),
    )


def _limits(function: Function, macro: str, macros: Scope) -> dict[str, str]:
    found: dict[str, str] = {}
    for port in (*function.inputs, *function.outputs):
        stem = f"{macro}_{identifier(port.name).upper()}"
        if isinstance(port, ListPort):
            found[port.name] = macros.claim(f"{stem}_MAX")
            for field in port.fields:
                found[f"{port.name}.{field.name}"] = macros.claim_stem(f"{stem}_{identifier(field.name).upper()}")
        elif port.name not in found and port.variable is not None:
            found[port.name] = macros.claim_stem(stem)
    return found


def _members(names: Iterable[str]) -> dict[str, str]:
    scope = Scope(capitals=False)
    return {name: scope.claim(name) for name in names}
