"""The coverage floor: never above what any input has, and reached where it says."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from fuzzyspec.check.bounding import bounded_floor
from fuzzyspec.check.coverage import controller_floors
from fuzzyspec.check.lattice import lattice_floor
from fuzzyspec.check.strength import Spot, setters_of
from tests.check_rules.random_controllers import PLACES, controllers, strength
from tests.check_rules.specs import EXAMPLES, ROOT, from_file, from_text, the_controller


def sound_controller(text):
    """The controller, or a rejected example where the random terms make an error of their own."""
    model, found = from_text(text)
    assume(model is not None or {d.code for d in found} <= {"FZ306", "FZ307"})
    assert model is not None
    return model.controllers[0]


def corners(controller):
    """Every value of an input at which a degree can bend, inside of the range."""
    return [
        sorted({x for t in v.terms for x, _ in t.shape.points if 0 <= x <= 10} | {Fraction(0), Fraction(10)})
        for v in controller.inputs
    ]


@settings(max_examples=70)
@given(controllers(), st.data())
def test_no_input_lies_below_the_floor(text, data):
    """At random places, at corners and just beside them, the strongest strength is at least what was proved."""
    controller = sound_controller(text)
    (floor,) = controller_floors(controller)
    assert 0 <= floor.proved <= floor.seen <= 1
    bends = corners(controller)
    for _ in range(20):
        at = []
        for xs in bends:
            x = data.draw(st.one_of(PLACES, st.sampled_from(xs)))
            x += data.draw(st.sampled_from([0, 0, Fraction(1, 10**6), -Fraction(1, 10**6)]))
            at.append(min(max(x, Fraction(0)), Fraction(10)))
        assert strength(controller, at) >= floor.proved
    assert controller.always_fires == (floor.proved >= controller.fires_at,)


@settings(max_examples=70)
@given(controllers())
def test_the_floor_is_seen_where_it_says(text):
    """The strength at the spot is what is reported; beside a jump, it is the limit from the side that is named."""
    controller = sound_controller(text)
    (floor,) = controller_floors(controller)
    if not any(floor.spot.sides):
        assert strength(controller, floor.spot.at) == floor.seen
        return
    beside = [
        strength(
            controller, [x + side * Fraction(1, 10**k) for x, side in zip(floor.spot.at, floor.spot.sides, strict=True)]
        )
        for k in (6, 9)
    ]
    # All is piecewise polynomial, so a thousandth of the way leaves about a thousandth of the difference.
    assert abs(beside[1] - floor.seen) <= abs(beside[0] - floor.seen) / 500


@settings(max_examples=30)
@given(controllers(norms=("min",), conorms=("max",)))
def test_floors_of_min_and_max_are_exact(text):
    """With min and max alone the floor is the infimum itself, and branch and bound encloses it."""
    controller = sound_controller(text)
    (floor,) = controller_floors(controller)
    assert floor.exact
    setters = setters_of(0, controller.inputs, controller.infer, controller.cells, controller.sentences)
    exactly = lattice_floor(setters)
    assert exactly is not None
    assert exactly[0] == floor.proved
    middle = Spot(tuple(Fraction(5) for _ in controller.inputs), tuple(0 for _ in controller.inputs))
    bounded = bounded_floor(setters, Fraction(0), (middle,))
    assert bounded.proved <= exactly[0] <= bounded.seen


@pytest.mark.parametrize(
    ("norm", "inputs", "floor"), [("min", 1, "1/2"), ("min", 4, "1/2"), ("product", 1, "1/2"), ("product", 4, "1/16")]
)
def test_complete_strong_partitions_have_the_known_floors(norm, inputs, floor):
    """Half for min over any number of inputs, 2^-n for the product over n."""
    names = ", ".join(f"x{i}" for i in range(inputs))
    controller = the_controller(
        f"controller c {{ input {names} in [0, 10] {{ partition A at 0, B at 1, C at 10 }}\n"
        f"output y in [0, 1] {{ partition S B }}\n infer {{ and = {norm} }}\n"
        "table y by x0 { A: S B: B C: S } }"
    )
    (found,) = controller_floors(controller)
    assert found.exact
    assert found.proved == Fraction(floor)
    assert controller.always_fires == (True,)


def test_gap_between_terms_is_found_and_shown_in_its_middle():
    """A sentence controller whose terms leave (4, 6) without any degree is told to say what holds at 5."""
    _, found = from_text(
        "controller c { input x in [0, 10] { term LOW = ramp_down(0, 4) term HIGH = ramp_up(6, 10) }\n"
        "output y in [0, 1] { partition S B }\n rules { if x is LOW then y is S if x is HIGH then y is B } }"
    )
    (gap,) = [d for d in found if d.code == "FZ324"]
    assert gap.point == {"x": "5"}


def test_weights_lower_the_floor_before_firing_is_asked():
    """A rule of weight 1/4 over all inputs fires at 1/4 and not at 1/2."""
    text = (
        "controller c {{ input x in [0, 10] {{ partition A B }} output y in [0, 1] {{ partition S B otherwise 0 }}\n"
        "fires at {} rules {{ if x is A or x is not A then y is S with 1/2 }} }}"
    )
    assert the_controller(text.format("1/4")).always_fires == (True,)
    assert the_controller(text.format("1/2")).always_fires == (False,)


def test_a_jump_is_looked_at_from_both_sides():
    """Two steps that meet at 5 leave nothing open; one that begins just above leaves a gap."""
    text = (
        "controller c {{ input x in [0, 10] {{ term L = points((0, 1), (5, 1), (5, 0)) term R = points({}) }}\n"
        "output y in [0, 1] {{ partition S B otherwise 0 }} table y by x {{ L: S R: B }} }}"
    )
    assert the_controller(text.format("(5, 0), (5, 1)")).always_fires == (True,)
    assert the_controller(text.format("(5.001, 0), (5.001, 1)")).always_fires == (False,)


@pytest.mark.parametrize(
    "path", sorted([*EXAMPLES.glob("*.fz"), *(ROOT / "benchmarks").glob("*.fz")]), ids=lambda p: p.stem
)
def test_project_specs_fire_or_say_otherwise(path):
    """Every output of the project's own specs is proved to fire, or has an `otherwise`."""
    model, _, _ = from_file(path)
    for controller in model.controllers:
        for output, always in zip(controller.outputs, controller.always_fires, strict=True):
            assert always != (output.fallback is not None)
