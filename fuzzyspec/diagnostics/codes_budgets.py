"""Codes of budgets: FZ260 to FZ265 and FZ444 of what is written, FZ460 and FZ461 of what the model says to it."""

from __future__ import annotations

from fuzzyspec.diagnostics.code import Code, explained

CODES: tuple[Code, ...] = (
    explained(
        "FZ260",
        "unknown quantity in a budget",
        """
        A budget limits what a call costs:

            flash, ram, stack           bytes: `flash <= 1 KiB`
            instructions, cycles        a plain count: `cycles <= 900 on cortex-m0plus`

        docs/cost.md says what each of them counts.
        """,
    ),
    explained(
        "FZ261",
        "unknown target in a budget",
        """
        Behind `on` stands a machine for which costs are estimated and measured: `cortex-m0plus`, `cortex-m4`,
        `cortex-m7`, `rv32imc` or `avr`. Without `on` a limit holds on all of them.

            budget { flash <= 1 KiB on cortex-m0 }          # cortex-m0plus
        """,
    ),
    explained(
        "FZ262",
        "wrong unit in a budget",
        """
        flash, ram and stack are counted in bytes: `B`, `kB` (1,000 B) or `KiB` (1,024 B). instructions and cycles
        are plain counts: how long a cycle takes is the board's business.

            budget { flash <= 1024, cycles <= 20 us }       # 1024 B; at 48 MHz, 960
        """,
    ),
    explained(
        "FZ263",
        "limited twice",
        """
        A quantity has one limit on a target. A limit without `on` holds on every target, and one with `on` on its
        own besides:

            budget { flash <= 4 KiB, flash <= 1 KiB on cortex-m0plus }
        """,
    ),
    explained(
        "FZ264",
        "a quantity that cannot be told there",
        """
        Cycles are counted on cortex-m0plus, by the table in its manual, and on avr, where an emulator counts them.
        On the larger cores they depend on the flash and on what the core runs side by side, and on rv32imc on the
        core that it is: no honest figure could be held against the limit. Limit instructions there, or measure on
        the board. On avr cycles are counted and instructions are not.

            budget { cycles <= 400 on cortex-m4 }           # instructions <= 400 on cortex-m4
        """,
    ),
    explained(
        "FZ265",
        "a budget with another sign than `<=`",
        """
        A budget says how much at most, the limit itself included.

            budget { flash < 1 KiB }                        # flash <= 1 KiB
        """,
    ),
    explained(
        "FZ444",
        "a budget that no call keeps to",
        """
        Every function has flash, instructions and cycles above 0. ram and stack may be held to 0, not below.

            budget { cycles <= 0, ram <= 0 B }              # cycles <= 900
        """,
    ),
    explained(
        "FZ460",
        "over its budget, by the model",
        """
        `fuzzyc compile` estimates what a call costs from the integer program, by a model that was fitted to
        measurements. The limit is broken even if the model is as far off as it ever was on specs that it was not
        fitted to, so nothing is written.

        `--optimize size` or `--optimize speed` may help, as the diagnostic says; so do fewer rules, terms or inputs.
        Or the limit is not what the board needs.

        A model can be wrong: `--over-budget warn` writes the C all the same, and `fuzzyc cost` measures it, whatever
        the model says.
        """,
    ),
    explained(
        "FZ461",
        "perhaps over its budget, by the model",
        """
        The estimate is above the limit, but by no more than the model may be off. The C is written.
        `fuzzyc cost FILE --target ..` builds it, runs it and decides.
        """,
        "warning",
    ),
)
