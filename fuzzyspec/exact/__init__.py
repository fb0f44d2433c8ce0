"""What a checked model means, in real numbers, straight from the definitions.

Imports the model only; the integer program is held to this, and shares nothing with it.
"""

from fuzzyspec.exact.controller import evaluate_controller
from fuzzyspec.exact.dequantise import dequantise
from fuzzyspec.exact.rational import Point, controller_point, evaluate_controller_exactly
from fuzzyspec.exact.result import Exact

__all__ = [
    "Exact",
    "Point",
    "controller_point",
    "dequantise",
    "evaluate_controller",
    "evaluate_controller_exactly",
]
