"""What a robot senses, in the paper's conventions."""

from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st

from firmware_sim.motion import Pose
from firmware_sim.sensing import Body, Sighting, azimuth, sense, sight

COORDINATES = st.integers(-64, 64).map(lambda n: n / 8)
HEADINGS = st.floats(-math.pi, math.pi)
BODIES = st.builds(Body, st.builds(Pose, COORDINATES, COORDINATES, HEADINGS), st.sampled_from([0.2]), st.floats(0, 0.7))


def test_left_is_negative() -> None:
    """Seen by a northbound robot, west is -90, east 90, north 0 and south 180 degrees off."""
    north = Pose(0, 0, math.pi / 2)
    assert azimuth(north, Pose(-1, 0, 0)) == -90
    assert azimuth(north, Pose(1, 0, 0)) == 90
    assert azimuth(north, Pose(0, 1, 0)) == 0
    assert abs(azimuth(north, Pose(0, -1, 0))) == 180


def test_head_on() -> None:
    """Two robots that meet head-on see each other ahead, at the sum of their speeds."""
    east = Body(Pose(0, 2, 0), 0.2, 0.1)
    west = Body(Pose(4, 2, math.pi), 0.3, 0.05)
    seen = sight(east, west)
    assert (seen.distance, seen.bearing, seen.radius) == (4.0, 0.0, 0.3)
    assert abs(seen.speed - 0.15) <= 2**-52


@given(BODIES, BODIES)
def test_distance_and_speed_are_mutual(a: Body, b: Body) -> None:
    """Each of two robots sees the other as far and as fast as it is seen itself."""
    ab, ba = sight(a, b), sight(b, a)
    assert (ab.distance, ab.speed) == (ba.distance, ba.speed)


@given(BODIES, BODIES)
def test_turning_shifts_the_bearing(a: Body, b: Body) -> None:
    """Turning left by a right angle moves everything a right angle to the right."""
    turned = Body(Pose(a.pose.x, a.pose.y, a.pose.heading + math.pi / 2), a.radius, a.speed)
    shift = sight(turned, b).bearing - sight(a, b).bearing
    assert abs((shift - 90 + 180) % 360 - 180) <= 1e3 * 2**-52 * 180


def test_out_of_range_is_unseen() -> None:
    """A body beyond the sensor's range is left out; one at its very end is seen."""
    own = Body(Pose(0, 0, 0), 0.2, 0.0)
    others = [Body(Pose(3, 0, 0), 0.2, 0.0), Body(Pose(0, 5, 0), 0.2, 0.0), Body(Pose(5.5, 0, 0), 0.2, 0.0)]
    readings = sense(own, Pose(0, -1, 0), others, sensor_range=5.0)
    assert readings.target_bearing == 90
    assert readings.obstacles == (Sighting(3.0, 0.0, 0.0, 0.2), Sighting(5.0, -90.0, 0.0, 0.2))
