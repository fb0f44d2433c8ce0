"""FZ2xx: names, units and what a declaration may say."""

from __future__ import annotations

from fuzzyspec.diagnostics.code import Code, explained

CODES: tuple[Code, ...] = (
    explained(
        "FZ201",
        "unknown name",
        """
        A name in an expression is neither a param, an input, a list, a `let` of the system nor a param of the
        file.

            input distance in [0, 8] m
            output d = danger(gap: distnace).ddc        # distance

        Correct the spelling, or define the name above its use. Terms and outputs of controllers are no names
        here: ask for an output of a call, as in `drive.v`. """,
    ),
    explained(
        "FZ202",
        "unknown controller or function",
        """
        What is called is neither a controller of the file nor one of the functions min, max, abs, clamp, to_rad
        and to_deg.

            let drive = velocty(target: target_bearing)         # velocity

        Correct the spelling, or declare the controller. Controllers may be declared anywhere in the file.
        """,
    ),
    explained(
        "FZ203",
        "unknown field or output",
        """
        After the dot stands something that is not there: a controller's result has its outputs (and `acting`,
        where it has behaviors), an element of a list has its fields and what `let` added to it, and a plain
        number has nothing.

            let drive = velocity(..)
            output v = drive.speed              # drive.v
        """,
    ),
    explained(
        "FZ204",
        "unknown unit",
        """
        Built in are m, mm, cm, km, kg, s, ms, us, min, A, K, degC, rad, deg, rpm, %, Hz, N, Pa, W and V, and
        products of their powers such as m/s, m/s^2 or kg*m/s^2.

            input speed in [0, 3] knots

        Declare any other at the top of the file, by what it is worth:

            unit knots = 0.514444 m/s
        """,
    ),
    explained(
        "FZ206",
        "unknown shape",
        """
        A term is a triangle(a, b, c), a trapezoid(a, b, c, d), a ramp_up(a, b), a ramp_down(a, b), points((x,
        y), ..) or, in outputs, a singleton(a).

            term near = gaussian(0, 1)

        Smooth shapes are not built in yet. `points` comes as close to one as wanted, and is computed exactly.
        """,
    ),
    explained(
        "FZ207",
        "unknown setting or method",
        """
        `infer` has the settings and = min or product, or = max or probsum, implies = min or product, aggregate
        = max or sum, defuzzify = centroid or weighted_average.

            infer { and = lukasiewicz }

        What is left out has its default: min, max, min, max and centroid; or, where the outputs have
        singletons, weighted_average with aggregate = sum.
        """,
    ),
    explained(
        "FZ208",
        "unknown raw type",
        """
        Raws, the integers that carry a variable in C, are uint8, int8, uint16 or int16.

            input e in [0, 1] raw uint32 { .. }

        Without `raw`, a variable has uint16 where its range does not go below 0, else int16, in the finest
        power of two. """,
    ),
    explained(
        "FZ209",
        "unknown argument",
        """
        A call names an input that the controller does not have.

            controller danger { input eta_t in [0, 6] { .. }  .. }
            let d = danger(eta: 3).ddc          # eta_t

        Use the names that the controller declares its inputs under.
        """,
    ),
    explained(
        "FZ210",
        "declared twice",
        """
        One name stands for two things in the same place: two controllers or systems of a file, two inputs or
        outputs of a controller, two terms of a variable, two params, inputs or lets of a system, a setting
        given twice.

            param limit = 2 m
            param limit = 3 m

        Rename one of them, or drop it. Different controllers may use the same names. """,
    ),
    explained(
        "FZ211",
        "a name that cannot be used",
        """
        Inputs, outputs and fields become members of structs in the generated C, which C++ must be able to read
        too. Their names cannot be keywords of either, nor begin with an underscore. Some names have a meaning
        already: `count` of a list, `acting` of a controller with behaviors, and the functions of the language.
        A module cannot be called as a header of C is: its own header, `stdint.h` say, would be read instead.

            input default in [0, 1] { .. }

        Choose another name.
        """,
    ),
    explained(
        "FZ212",
        "names that differ only in case",
        """
        The macros of the generated header are in upper case, so `a` and `A` would both give NAV_A_MAX.

            input a in [0, 1] { .. }
            input A in [0, 1] { .. }

        Rename one of them. The inputs and outputs of one controller or system share their macros' names; so do
        the controllers and systems of a file. """,
    ),
    explained(
        "FZ213",
        "a name that is too long",
        """
        A name becomes part of longer ones in C, of which a compiler need only tell the first 63 characters
        apart. A name of at most 40 characters leaves room for what is put around it.
        """,
    ),
    explained(
        "FZ214",
        "missing argument",
        """
        A call gives every input of the controller.

            controller c { input a, b in [0, 1] { .. } .. }
            let d = c(a: x).u                   # and b?
        """,
    ),
    explained(
        "FZ215",
        "argument given twice",
        """
        A call gives each input once.

            let d = danger(gap: distance, gap: 3 m).ddc
        """,
    ),
    explained(
        "FZ216",
        "by name or by position",
        """
        Controllers take their arguments by name, in any order: `danger(eta_t: 3, eta_d: 1)`. Functions take
        theirs by position: `max(a, b)`.

            let d = danger(3, 1).ddc
        """,
    ),
    explained(
        "FZ217",
        "wrong number of arguments",
        """
        A function or a shape gets more or fewer arguments than it takes.

            term near = triangle(0, 1)          # triangle(a, b, c)
            let x = clamp(y, 3 m)               # clamp(x, lo, hi)
        """,
    ),
    explained(
        "FZ220",
        "units do not agree",
        """
        Sums, comparisons, `min`, `max`, `clamp` and both branches of a choice need one unit throughout
        (prefixes do not matter: 1 m + 20 cm is fine), and what goes into a place with a unit needs that unit.

            let rest = distance - speed         # m and m/s
            let near = o.bearing < 30           # deg and a plain number: write 30 deg

        A bare 0 fits any unit. A bare number that stands alone as an argument, in a term or as an output's
        value is in the unit of that place. Degrees are a unit of their own and do not mix with plain numbers:
        `to_rad(..)` and `to_deg(..)` go from one to the other, with 245850922/78256779 for pi. """,
    ),
    explained(
        "FZ221",
        "a unit with an offset in a product",
        """
        degC counts from another zero than K. It can be the unit of a variable or of a number, but not part of a
        product such as degC/s.

            input rate in [-2, 2] degC/s { .. }         # K/s

        A difference of temperatures is in K, so a rate is in K/s.
        """,
    ),
    explained(
        "FZ222",
        "a unit that is worth nothing",
        """
        A unit is declared by what one of it is worth, which must be above 0.

            unit tick = 0 rad                   # unit tick = 0.012 rad
        """,
    ),
    explained(
        "FZ223",
        "not an angle in degrees",
        """
        `to_rad` takes a value whose unit holds deg once (deg, deg/s, ..), `to_deg` one that holds no deg.

            let a = to_rad(distance)
        """,
    ),
    explained(
        "FZ231",
        "a controller without inputs or outputs",
        """
        A controller looks at one input or more and sets one output or more.

            controller c {
                input  e in [-1, 1] { partition N Z P }
                output u in [-1, 1] { partition N Z P }
                table u by e { N: P  Z: Z  P: N }
            }
        """,
    ),
    explained(
        "FZ232",
        "a system without outputs",
        """
        What a step computes leaves it through its outputs.

            system nav {
                input x in [0, 1]
                output y = 2 * x
            }
        """,
    ),
    explained(
        "FZ233",
        "a variable without terms",
        """
        Rules speak of the terms of a controller's inputs and outputs.

            input e in [-1, 1] { }              # input e in [-1, 1] { partition N Z P }
        """,
    ),
    explained(
        "FZ234",
        "nothing to compile",
        """
        A file holds a controller or a system at least. A controller without a system compiles to its own
        function.
        """,
    ),
    explained(
        "FZ240",
        "definitions that go in a circle",
        """
        A param or `let` needs itself, perhaps by way of others.

            let a = b + 1
            let b = a / 2

        A step computes forward. What an earlier step computed is only known where an output of a controller
        holds: `otherwise hold initial 0`. """,
    ),
    explained(
        "FZ241",
        "used before it is defined",
        """
        A system is read from top to bottom, and computed in that order.

            let drive = velocity(left: danger_left, ..)
            let danger_left = max(..)           # move it up
        """,
    ),
    explained(
        "FZ242",
        "defined, but never used",
        """
        Nothing needs this `let`; perhaps another name was meant where it should be used.
        """,
        "warning",
    ),
    explained(
        "FZ243",
        "a list or an element is not a number",
        """
        A list has many elements, and an element has fields. A number is a field of one element, reached in a
        loop or a fold.

            let d = obstacles.distance          # of which obstacle?

            for each o in obstacles { let o.gap = o.distance - 0.2 m }
            let nearest = min(o.gap for o in obstacles, otherwise 8 m)

        `obstacles.count` is the number of elements.
        """,
    ),
    explained(
        "FZ244",
        "a `let` that does not fit its place",
        """
        In a loop, `let` adds a field to the element; outside, it names a number or what a controller returned.

            for each o in obstacles { let gap = o.distance }    # let o.gap = ..
            let o.gap = 3 m                                     # only in a loop over the list
        """,
    ),
    explained(
        "FZ245",
        "`acting` cannot stand here",
        """
        A controller with behaviors reports which one acted, as a code. A system hands it on, and nothing else:

            output acting = drive.acting

        A controller without behaviors has no `acting`.
        """,
    ),
    explained(
        "FZ246",
        "a controller's result is not a number",
        """
        A call returns all outputs of a controller. Name one to compute with it.

            let drive = velocity(..)
            output v = drive                    # drive.v
            output w = velocity(..)             # velocity(..).w
        """,
    ),
    explained(
        "FZ247",
        "a condition and a number are not the same",
        """
        Comparisons, `in [lo, hi]`, and, or and not make conditions. They stand after `if`; numbers stand
        everywhere else.

            let near = o.distance < 2 m                     # let near = 1 if o.distance < 2 m else 0
            let x = a if b else 0                           # a if b > 0 else 0
        """,
    ),
    explained(
        "FZ248",
        "a constant is needed",
        """
        Ranges, terms, weights, capacities, params and the ends of a `clamp` are known when the spec is
        compiled: numbers, params and what is computed from them.

            param limit = distance / 2          # a let
        """,
    ),
    explained(
        "FZ249",
        "a controller that remembers, called for each element",
        """
        An output that holds needs a memory from step to step. The elements of a list come and go, so there is
        none for each of them.

        Give the output `otherwise VALUE` without `hold`, or call the controller once, outside of the loop.
        """,
    ),
    explained(
        "FZ250",
        "a call or a fold inside of a fold or loop",
        """
        One pass over a list computes one fold, and a fold only computes numbers.

            let worst = max(danger(gap: o.distance).ddc for o in obstacles, otherwise 0)

        Call the controller in a loop, then fold over what it returned:

            for each o in obstacles { let o.ddc = danger(gap: o.distance).ddc }
            let worst = max(o.ddc for o in obstacles, otherwise 0)

        A fold that a loop needs stands in a `let` before the loop. """,
    ),
    explained(
        "FZ251",
        "a maximum or minimum of nothing",
        """
        A list can be empty, and its elements may all fail the test. The sum and the count are 0 then; a maximum
        or minimum must be told.

            let nearest = min(o.distance for o in obstacles)                        # of no obstacle?
            let nearest = min(o.distance for o in obstacles, otherwise 8 m)
        """,
    ),
    explained(
        "FZ252",
        "unknown fold",
        """
        Over a list go max, min, sum and count: `sum(o.speed for o in obstacles)`, `count(o for o in obstacles
        if o.distance < 1 m)`. The mean is a sum divided by a count. """,
    ),
    explained(
        "FZ253",
        "`otherwise` that settles nothing",
        """
        In an expression, `otherwise` says what a quotient is at 0/0. It follows the quotient directly, in
        parentheses where more follows.

            let a = x + y otherwise 3           # no quotient
            let b = clamp(x / y otherwise 3, 0, 5) + 1
        """,
    ),
)
