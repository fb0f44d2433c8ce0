"""Names of one function: unique, readable, never a keyword of C."""

from __future__ import annotations

from dataclasses import dataclass, field

RESERVED = frozenset(
    [
        "auto",
        "break",
        "case",
        "char",
        "const",
        "continue",
        "default",
        "do",
        "double",
        "else",
        "enum",
        "extern",
        "float",
        "for",
        "goto",
        "if",
        "inline",
        "int",
        "long",
        "register",
        "restrict",
        "return",
        "short",
        "signed",
        "sizeof",
        "static",
        "struct",
        "switch",
        "typedef",
        "union",
        "unsigned",
        "void",
        "volatile",
        "while",
        "in",
        "out",
        "state",
        "status",
        "bool",
        "true",
        "false",
        "class",
        "new",
        "delete",
        "this",
        "template",
        "namespace",
        "operator",
        "private",
        "public",
        "protected",
        "try",
        "catch",
        "throw",
        "using",
        "virtual",
        "friend",
        "and",
        "or",
        "not",
        "xor",
        "asm",
        "export",
        "main",
        "int8_t",
        "int16_t",
        "int32_t",
        "uint8_t",
        "uint16_t",
        "uint32_t",
    ]
)


@dataclass
class Scope:
    """Hands out names; a taken one gets a number."""

    taken: set[str] = field(default_factory=lambda: set(RESERVED))
    numbers: dict[str, int] = field(default_factory=dict)
    """The number at which to go on asking, by the name wanted: no lower one is free."""

    def name(self, wanted: str) -> str:
        name = wanted
        number = self.numbers.get(wanted, 2)
        while name in self.taken:
            name = f"{wanted}_{number}"
            number += 1
        self.numbers[wanted] = number
        self.taken.add(name)
        return name
