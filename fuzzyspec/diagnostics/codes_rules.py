"""FZ3xx: terms, cells and rules."""

from __future__ import annotations

from textwrap import dedent

from fuzzyspec.diagnostics.code import Code
from fuzzyspec.diagnostics.diagnostic import Severity


def _code(code: str, title: str, page: str, severity: Severity = "error") -> Code:
    return Code(code, title, severity, dedent(page).strip() + "\n")


CODES: tuple[Code, ...] = (
    _code(
        "FZ301",
        "cells that no rule claims",
        """
        Tables and behaviors rule over cells: every combination of one term for each input. Where no rule claims
        a cell, the outputs have no answer there. The report groups the cells and shows an input at which only
        such a cell is active.

            behavior GO priority 1 {
                if target is C then v is F          # nothing for target is L and target is R
            }

        Add rules for the cells, or give the output a value for "nothing fires": `otherwise 0` or `otherwise
        hold initial 0`.
        """,
    ),
    _code(
        "FZ302",
        "a cell is won, but an output is left unset",
        """
        A behavior wins a cell whole: what it leaves unset there is not filled in by a behavior of lower
        priority.

            behavior FO priority 2 { if front is B then v is VS }               # says nothing about w
            behavior MG priority 1 { if front in {S, M, B} then v is F, w is Z }  # cannot help it

        Let the rule set the output too, or give the output an `otherwise`.
        """,
    ),
    _code(
        "FZ303",
        "two rules of one behavior disagree",
        """
        Two rules of the behavior that wins a cell give one output different terms there.

            behavior AO priority 1 {
                if left in {M, B} then w is PM
                if right is B     then w is NM      # left is M and right is B: PM or NM?
            }

        Narrow one of the rules so that they do not meet, or move it to a behavior of higher priority. Rules
        that agree may meet, and so may rules whose meeting place is won by a higher priority.
        """,
    ),
    _code(
        "FZ304",
        "two behaviors of one priority meet",
        """
        Two behaviors of the same priority claim one cell, and no higher priority takes it from them, so nobody
        wins it.

        Give one of them the higher priority. Equal priorities are fine as long as the behaviors do not meet.
        """,
    ),
    _code(
        "FZ305",
        "two tables set an output in one cell",
        """
        Several tables may stand in a controller, for several outputs or for several parts of the cells. An
        output takes each cell from one table, even where two would agree. A table leaves out the inputs that it
        does not name: its entries hold for all of their terms.

        Take the entry out of one of the tables.
        """,
    ),
    _code(
        "FZ306",
        "a rule never wins",
        """
        Every cell that the rule claims goes to behaviors of higher priority, so it has no effect. The report
        says who takes them.

        Remove the rule, or change the priorities. A table beside behaviors ranks below them all; it is reported
        only where none of its entries wins.
        """,
        "warning",
    ),
    _code(
        "FZ307",
        "a rule says nothing new",
        """
        The rule repeats what another rule says: it is written twice, or every cell that it wins is set to the
        same by rules before it.

        Remove it.
        """,
        "warning",
    ),
    _code(
        "FZ308",
        "`or`, or `not` of a group, inside a behavior",
        """
        A rule inside a behavior claims one block of cells: a set of terms for each input. `or` between inputs
        is no such block, nor is `not` before a group.

            if left is B or right is B then v is VS         # two blocks
            if left is M or left is B then v is VS          # one block: say `left in {M, B}`

        Write one rule for each block; `x is not A` stands for all other terms of x. Free sentences belong into
        a `rules` block, where strengths are computed by and, or and not instead.
        """,
    ),
    _code(
        "FZ309",
        "a weight inside a behavior",
        """
        A behavior wins or loses a cell whole, so its rules have no weights.

        Drop the `with`, choose a milder term, or use a `rules` block.
        """,
    ),
    _code(
        "FZ310",
        "sentence rules beside behaviors",
        """
        Sentences in a `rules` block claim no cells, so priorities cannot decide between them and a behavior.

        Put the rules into a behavior, or put the sentences into a controller of their own.
        """,
    ),
    _code(
        "FZ311",
        "unknown input",
        """
        A condition or a table's `by` names something that is no input of the controller.

        Conditions ask inputs of their own controller only; what another controller computes is handed in as an
        input.
        """,
    ),
    _code(
        "FZ312",
        "unknown output",
        """
        A rule or a table sets something that is no output of the controller.
        """,
    ),
    _code(
        "FZ313",
        "unknown term",
        """
        The variable has no term of that name. Names are told apart by case.

        In a table, mind the order: the last input after `by` runs across, the others label the rows in their
        order, and the terms of an entry follow the order of the outputs.
        """,
    ),
    _code(
        "FZ314",
        "named twice",
        """
        A rule sets one output twice, a condition names one term twice, or the header of a table one variable.

            if front is B then v is VS, v is S
            if left in {M, M} then v is S
        """,
    ),
    _code(
        "FZ315",
        "a condition that no cell satisfies",
        """
        A cell has exactly one term of each input, so no cell has `left is M and left is B`. Several conditions
        on one input narrow each other down; here nothing is left.

        For either of two terms say `left in {M, B}`. (In a `rules` block the sentence is allowed: it speaks of
        inputs that are both to some degree.)
        """,
    ),
    _code(
        "FZ316",
        "wrong number of row labels",
        """
        A row is labelled by one term of each input after `by` but the last, which runs across.

            table v by left, front, target {
                         L  C  R
                (S, B):  F  Z  F            # left is S and front is B
            }

        With one or two inputs the label is one term, without parentheses.
        """,
    ),
    _code(
        "FZ317",
        "wrong number of entries in a row",
        """
        A row has one entry for each column of the header line. Entries for several outputs are joined by `/`,
        without spaces between entries counting for anything else: `VF/Z` is one entry.

        A table by one input has no header line: each term is followed by its entry, `N: S  Z: M  P: B`.
        """,
    ),
    _code(
        "FZ318",
        "wrong number of terms in an entry",
        """
        An entry names one term for each output of the table, in their order, joined by `/`.

            table v, w by e { N: S/Z  Z: M }            # the second entry says nothing about w
        """,
    ),
    _code(
        "FZ319",
        "a row or column twice",
        """
        Each combination of row labels has one row, and each term of the last input one column.
        """,
    ),
    _code(
        "FZ320",
        "a table lacks rows or columns",
        """
        The only table that sets an output leaves some of its cells out, or its header has not as many columns as
        all of its rows have entries, or runs over another input than the last one behind `by`.

        Complete the table, or give the output an `otherwise`, which holds where no rule fires.
        """,
    ),
    _code(
        "FZ321",
        "a weight outside of (0, 1]",
        """
        A weight multiplies the strength of a rule, so it lies above 0 and is at most 1, the default.

            if error is hot then duty is high with 0.8
        """,
    ),
    _code(
        "FZ322",
        "two rules with one condition disagree",
        """
        Two sentence rules have the same condition and give one output different terms. Both always fire with
        like strength, so the output lies between the terms. That is seldom meant.

        Keep one of them, or tell their conditions apart.
        """,
        "warning",
    ),
    _code(
        "FZ323",
        "an output that no rule sets",
        """
        No rule of the controller sets the output, so it would be a constant at best.

        Set it in the rules, or remove it.
        """,
    ),
    _code(
        "FZ324",
        "inputs at which nothing fires",
        """
        An output fires where the strongest rule that sets it reaches `fires at` (1/64 where the spec does not
        say). Below that there is nothing to average over. The report shows an input at which it happens: often
        a gap between terms, or a combination that no sentence speaks of.

        Cover the input by a rule or wider terms, or say what holds there: `otherwise 0` or `otherwise hold
        initial 0`.
        """,
    ),
    _code(
        "FZ325",
        "it is not proved that a rule always fires",
        """
        No input was found at which the output does not fire, but neither could it be proved that there is none.
        This happens with products over many inputs and strengths that come near to `fires at`.

        Give the output an `otherwise`; the generated code then tests for the case.
        """,
    ),
    _code(
        "FZ326",
        "a priority that is not a whole number",
        """
        Priorities of behaviors are whole numbers. Only their order counts: the highest wins a cell.
        """,
    ),
    _code(
        "FZ327",
        "two behaviors of one name",
        """
        A behavior is one block. Its name becomes a C macro in capitals, so case does not tell names apart.
        """,
    ),
    _code(
        "FZ328",
        "no rules",
        """
        A controller needs a `table`, `behavior` blocks or a `rules` block, and a behavior at least one rule.
        """,
    ),
    _code(
        "FZ329",
        "too many cells",
        """
        Tables and behaviors rule over the product of all terms of all inputs, and at most 65,536 cells fit.

        Split the controller in layers, the output of one being an input of the next: two controllers of 3
        inputs with 7 terms have 686 cells, one of 6 inputs 117,649. Or use sentence rules, which need no cells.
        """,
    ),
    _code(
        "FZ330",
        "more than a controller holds",
        """
        A controller has at most 32 inputs, 32 outputs, 64 behaviors, 4,096 rules in them and 1,000 sentence
        rules; a variable at most 255 terms, a `points` at most 255 points. Nothing else of a controller beyond
        these limits is looked into.

        A rule base of this size no longer fits a head, nor most microcontrollers. Split the controller in
        layers, or write a fine curve with fewer points: between them it is linear.
        """,
    ),
)
