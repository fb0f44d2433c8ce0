"""Specs that the verification is tried on: small ones, so that a test takes a second or two."""

DANGER = """\
module small
controller danger {
    input  near in [0, 6]     { partition TS TM TB }
    input  gap  in [0, 3.3] m { partition DS DM DB }
    output ddc  in [0, 1]     { partition S M B full }
    table ddc by gap, near {
             TS TM TB
        DS:  B  B  B
        DM:  B  M  M
        DB:  B  M  S
    }
}
"""

BYTES = """\
module tiny
controller fan {
    input  error in [-10, 10] K   raw int8 step 0.1   { partition N at -10, Z at 1, P at 10 }
    input  rate  in [-2, 2] K/s   raw uint8 250..10   {
        term falling = ramp_down(-1, 0)
        term steady  = triangle(-1, 0, 1)
        term rising  = ramp_up(0, 1)
    }
    output duty  in [0, 100] %    raw uint8 0..200    {
        term off  = triangle(-20, 0, 20)
        term half = trapezoid(20, 40, 60, 80)
        term full = points((60, 0), (90, 1), (100, 1))
        otherwise 33 %
    }
    rules {
        if error is P and rate is not falling then duty is full
        if error is Z and rate is steady then duty is half with 0.7
        if error is N or rate is falling then duty is off with 0.4
    }
    fires at 1/8
}
"""

HOLDING = """\
module keeper
controller hold {
    input  x in [-1, 1] { term low = ramp_down(-0.8, -0.3)  term high = ramp_up(0.2, 0.9) }
    output y in [0, 5] V { singletons A B  otherwise hold initial 2 V }
    infer { defuzzify = weighted_average }
    rules {
        if x is low then y is A
        if x is high then y is B
    }
}
system both {
    input x in [-1, 1]
    input parts[3] { size in [0, 2] m, kind in [0, 9] }
    let a = hold(x: x)
    output y = a.y
    output big = max(p.size for p in parts if p.kind >= 4.5, otherwise 0 m)
    output some = sum(p.size for p in parts if p.size > 0.5 m)
    output many = count(p for p in parts if p.kind in [1, 3])
}
"""
