"""The report of `fuzzyc check`: the text an engineer reads, and the same as data."""

from __future__ import annotations

import json
from fractions import Fraction

import pytest

from fuzzyspec.check.report import module_report
from tests.check_rules.specs import EXAMPLES, from_file, from_text

VELOCITY = """\
controller velocity
  inputs     left, front, right in [0, 1]: S M B
             target in [-90, 90] deg: L C R
  rules      all 81 cells claimed
  inference  and min, implies min, aggregate max, centroid
  behaviors  priority  rules  started  executed  lost
  FO                3      6       54        54  -
  AO                2     11       48        16  32 to FO
  MG                1      5       27        11  12 to FO, 4 to AO
                                             81  of 81 cells
  output     v in [0, 0.7] m/s: Z VS S F VF
             reaches   [0, 0.7] m/s, the whole range
             coverage  never weaker than 1/2 (at left = 0.25, front = 0.25, right = 0.25, {target}): always fires
  output     w in [-0.3, 0.3] rad/s: NB NM NS Z PS PM PB
             reaches   [-0.3, 0.3] rad/s, the whole range
             coverage  as of v
  decisions  acting: which behavior owns the strongest cell; may differ within 0.334
"""


@pytest.fixture(name="nav", scope="module")
def fixture_nav():
    """nav.fz, checked, with its source."""
    model, _, source = from_file(EXAMPLES / "nav.fz")
    return model, source


def test_report_of_the_velocity_layer(nav):
    """The section of nav's second layer, word for word; a band is rounded up."""
    model, source = nav
    text = module_report(model, source, {"velocity": {"acting": Fraction(1, 3)}}).text()
    assert VELOCITY.format(target="target = -45 deg") in text + "\n"


def test_report_as_data(nav):
    """The data carries the same account and survives JSON."""
    model, source = nav
    data = json.loads(json.dumps(module_report(model, source).as_json()))
    velocity = next(c for c in data["controllers"] if c["name"] == "velocity")
    assert velocity["cells"] == {"total": 81, "claimed": 81, "unclaimed": 0}
    counted = [(b["name"], b["started"], b["lost"], b["executed"]) for b in velocity["behaviors"]]
    assert counted == [("FO", 54, {}, 54), ("AO", 48, {"FO": 32}, 16), ("MG", 27, {"FO": 12, "AO": 4}, 11)]
    assert [o["reachable"]["within"] for o in velocity["outputs"]] == [[0, 0.7], [-0.3, 0.3]]
    assert velocity["decisions"][0]["band"] is None


def test_only_decisions_on_computed_values_are_listed(nav):
    """The sector tests compare raw inputs with literals; 0/0 and the acting behavior are computed."""
    model, source = nav
    (system,) = module_report(model, source).systems
    assert [(d.kind, d.what) for d in system.decisions] == [
        ("0/0", "o.gap / (o.speed * T)"),
        ("acting", "which behavior owns the strongest cell (velocity)"),
    ]


def test_comparison_of_computed_values_is_listed():
    """A comparison of a difference is told in the spec's own words; one of a raw input with a constant is not."""
    text = (
        "controller c { input x in [0, 1] { partition S B } output y in [0, 1] { partition S B }\n"
        "table y by x { S: S B: B } }\n"
        "system s { input a in [0, 1] input b in [0, 1]\n"
        "output y = c(x: a if a - b > 0.25 else b).y  output z = 1 if a > 0.5 else 0 }"
    )
    model, found = from_text(text)
    assert model is not None, found
    (system,) = module_report(model).systems
    assert [d.kind for d in system.decisions] == ["comparison"]


def test_otherwise_is_told():
    """An output that may not fire says what holds then, and from which strength."""
    model, _, source = from_file(EXAMPLES / "temperature.fz")
    text = module_report(model, source).text()
    assert "otherwise holds its last value, at first 0 %, below a strength of 1/8" in text
    assert "fires.duty: whether a rule for duty reaches 1/8" in text


def test_cells_left_open_are_counted():
    """Two of three cells claimed, one unset, and a floor of 0 at the open cell's peak."""
    model, _ = from_text(
        "controller c { input x in [0, 1] { partition S M B } output y in [0, 1] { partition S M B otherwise 0 }\n"
        "behavior A priority 1 { if x is S then y is B if x is B then y is S } }"
    )
    text = module_report(model).text()
    assert "2 of 3 cells claimed" in text
    assert "unset     in 1 cell" in text
    assert "nothing fires (at x = 0.5)" in text
    assert "unused    M" in text
