"""FZ4xx: numbers, raws and range analysis."""

from __future__ import annotations

from fuzzyspec.diagnostics.code import Code, explained

CODES: tuple[Code, ...] = (
    explained(
        "FZ401",
        "an empty or reversed range",
        """
        A range has its low end first, and a higher one after it.

            input e in [4, 0] { .. }            # [0, 4]
        """,
    ),
    explained(
        "FZ402",
        "a raw type that cannot hold the range",
        """
        A raw must be able to stand for every value inside of the range.

            input e in [-4, 4] raw uint16 { .. }                # goes below 0: int16
            input e in [0, 100] raw uint8 step 0.1 { .. }       # needs raws up to 1000

        Use a wider type or a coarser step, or leave the step out: the finest power of two that fits is then
        chosen.
        """,
    ),
    explained(
        "FZ403",
        "a step that is not positive",
        """
        The step is how far neighbouring raws are apart.

            input e in [0, 4] raw uint16 step 0 { .. }

        A sensor that counts backwards is described by its counts: `raw uint16 4095..0`. """,
    ),
    explained(
        "FZ404",
        "counts that cannot be mapped",
        """
        `raw uint16 0..4095` maps whole counts onto the range; the first count is its low end, the last its high
        end. They must differ; they may run backwards.

            input e in [0, 4] raw uint16 7..7 { .. }
        """,
    ),
    explained(
        "FZ405",
        "a range without raws",
        """
        The legal raws are those whose value lies inside of the range. There must be two at least, or the
        variable could not change.

            input e in [0.2, 0.8] raw uint16 step 1 { .. }
            input t in [1000000, 1000001] s { .. }              # the finest step of a uint16 is 16 s here

        Choose a finer step, or map counts onto the range, which need not start at 0: `raw uint16 0..65535`.
        """,
    ),
    explained(
        "FZ406",
        "a list of no size",
        """
        A list has room for 1 to 255 elements, a whole number that is known when the spec is compiled.

            input obstacles[0] { .. }
        """,
    ),
    explained(
        "FZ410",
        "a term wholly outside of its range",
        """
        A term may stick out of the range of its variable, but some of it must lie inside; for an output's
        shape, some area.

            input e in [0, 4] { term far = triangle(5, 6, 7)  .. }
        """,
    ),
    explained(
        "FZ411",
        "a peak outside of the range",
        """
        The peaks of a partition and singletons lie inside of the range.

            input e in [0, 4] { partition near at 0, far at 5 }
        """,
    ),
    explained(
        "FZ412",
        "peaks that do not rise",
        """
        The terms of a partition stand in order, from low to high, each peak above the one before.

            input e in [0, 4] { partition near at 3, far at 1 }
        """,
    ),
    explained(
        "FZ413",
        "`full` where it has no meaning",
        """
        `full` mirrors the inner half of the end terms of an output's partition outwards, so that a centroid
        reaches the ends of the range. The end peaks must lie on the ends, and no other terms may stand beside
        the partition. Inputs have no use for it. It stands behind the names of the terms.

            output u in [0, 1] { partition LOW at 0, HIGH at 0.9 full }
        """,
    ),
    explained(
        "FZ414",
        "corners out of order",
        """
        The corners of a triangle or trapezoid are given from low to high. Neighbours may be equal, which makes
        a jump; all of them may not. The two ends of a ramp differ.

            term near = triangle(0, 3, 2)
        """,
    ),
    explained(
        "FZ415",
        "points out of order, or not memberships",
        """
        `points((x, y), ..)` goes from low to high x, with y from 0 to 1. Two points at one x make a jump, where
        the larger value holds.

            term near = points((0, 1), (2, 0.5), (1, 0))
        """,
    ),
    explained(
        "FZ416",
        "singletons and shapes mixed",
        """
        An output has either singletons, for the weighted average, or shapes, for the centroid. An input has
        shapes: a singleton would be met by a single value only.

            output u in [0, 1] { term LOW = singleton(0)  term HIGH = ramp_up(0, 1) }
        """,
    ),
    explained(
        "FZ417",
        "a partition of one",
        """
        A partition divides a range among two terms or more, all of them placed with `at` or none.

            input e in [0, 4] { partition NEAR }
        """,
    ),
    explained(
        "FZ418",
        "a gap between terms",
        """
        Somewhere in the range of an input no term has any degree. No cell of a table or behavior can fire
        there, whatever the other inputs are, and the outputs' `otherwise` applies.

            input e in [0, 4] { term near = ramp_down(0, 1)  term far = ramp_up(2, 4) }         # 1 to 2

        Let neighbouring terms overlap; a partition always does.
        """,
        "warning",
    ),
    explained(
        "FZ419",
        "two partitions",
        """
        A partition divides the whole range, so a variable has one.

        Put all terms into it, or write them as shapes: `term near = triangle(0, 1, 2)`.
        """,
    ),
    explained(
        "FZ420",
        "a combination that is not supported",
        """
        The centroid is computed in closed form, never sampled. So far that is done for implies = min and
        aggregate = max, over terms of any shape, with any `and` and `or`. The weighted average of singletons
        goes with any setting.

            infer { implies = product, aggregate = sum, defuzzify = centroid }
        """,
    ),
    explained(
        "FZ421",
        "terms that do not go with the method",
        """
        A centroid is taken of shapes, a weighted average of singletons. Where `infer` does not say which, the
        terms of the outputs decide; all outputs of a controller have to agree.

            output u in [0, 1] { partition LOW HIGH }
            infer { defuzzify = weighted_average }              # singletons LOW HIGH
        """,
    ),
    explained(
        "FZ422",
        "an `otherwise` outside of the range",
        """
        What an output is when nothing fires, or at first where it holds, lies in its range.

            output u in [0, 1] { partition LOW HIGH  otherwise 2 }
        """,
    ),
    explained(
        "FZ423",
        "a strength that cannot be",
        """
        `fires at` gives the strength from which on a controller fires: above 0 and at most 1. Without it, that
        is 1/64.
        """,
    ),
    explained(
        "FZ424",
        "an `otherwise` of an input",
        """
        `otherwise` says what an output is when nothing fires. An input is what it is. """,
    ),
    explained(
        "FZ430",
        "a divisor of both signs",
        """
        Near 0 a quotient leaps from one end of all numbers to the other, so the range of a divisor must stay on
        one side (0 itself may belong to it, see FZ431).

            input x in [-1, 1]
            let q = distance / x

        Divide by its size, keep it away from 0, or treat both signs apart: `a / max(x, 0.01) if x > 0 else ..`.
        """,
    ),
    explained(
        "FZ431",
        "a divisor that can be 0",
        """
        x/0 is beyond all numbers, which is fine where the quotient goes straight into a place with a range:
        there it is the end on x's side. Such places are an input of a controller, a `clamp` and an output with
        a declared range.

            let q = gap / speed                         # speed in [0, 2] m/s

            let d = danger(eta_t: gap / speed otherwise 6 s, ..).ddc
            let q = clamp(gap / speed otherwise 6 s, 0 s, 6 s)
            let q = gap / max(speed, 0.01 m/s)

        Whether a divisor can be 0 is judged by its interval over the declared ranges. """,
    ),
    explained(
        "FZ432",
        "0/0 is not settled",
        """
        Both sides of a quotient can be 0 at once, which means nothing until the spec says what.

            let d = danger(eta_t: gap / speed).ddc
            let d = danger(eta_t: gap / speed otherwise 6 s).ddc
        """,
    ),
    explained(
        "FZ433",
        "an `otherwise` that is never used",
        """
        The divisor (or the dividend) cannot be 0, so the quotient is never 0/0; or the fold is a sum or count,
        which is 0 for no elements.

        Drop it.
        """,
        "warning",
    ),
    explained(
        "FZ434",
        "a division by 0",
        """
        The divisor is always 0.
        """,
    ),
    explained(
        "FZ435",
        "an output that never changes",
        """
        The range of an output that declares none is the interval of its expression; a constant has no interval.

            output limit = 3 m

        Leave it out, or declare a range: `output limit in [0, 5] m = 3 m`. """,
    ),
    explained(
        "FZ436",
        "a condition that never changes",
        """
        The declared ranges decide a comparison, so the condition is always true or always false.

            input duty in [0, 100] %
            output y = 1 if duty > 50 else 0                    # 50 %

        A percent is 1/100: 50 without a unit is 5000 %. A sector may reach beyond a range at one end; it is told of
        where it lies outside altogether.
        """,
        "warning",
    ),
    explained(
        "FZ442",
        "too many status bits",
        """
        A function returns a status with a bit for every input and list field that can be out of range, every
        list that can be too long, every output that can saturate and every output that holds: 32 at most.

        Split the system, or leave out what need not be told.
        """,
    ),
    explained(
        "FZ443",
        "a number out of proportion",
        """
        Numbers lie between 10^-18 and 10^18 (or are 0); what is beyond is taken for a slip.

        Measure in a unit that suits the quantity: 3 ms instead of 0.003 s. """,
    ),
    explained(
        "FZ450",
        "arithmetic beyond 32 bits",
        """
        The generated C has no 64-bit type. Every intermediate value is followed through range analysis, and one of
        them cannot be held in 32 bits, even after rounding to a coarser step.

        Narrow the ranges of the inputs, give them coarser raws (`raw int16 step 0.1`), or put a `clamp` on what
        cannot be that large. """,
    ),
    explained(
        "FZ451",
        "too many terms overlap in an output",
        """
        The centroid of overlapping terms is taken in closed form, set by set: pairs that overlap, triples that
        overlap, and so on. One output may have 64 such sets.

        Let fewer terms of the output overlap at one place. In a partition only neighbours do. """,
    ),
    explained(
        "FZ452",
        "certified error beyond the tolerance",
        """
        `--tolerance` says what error of every output, in percent of its range, can be lived with. Not even the program
        of full precision is certified to stay within it, or no error could be certified at all.

        Allow more, or give the inputs and the output finer raws, or try `--bounds thorough`: the derivation may
        certify less than it did. A system's outputs carry the errors of all that leads to them. """,
    ),
)
