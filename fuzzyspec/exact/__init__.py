"""What a checked model means, in real numbers, straight from the definitions.

Imports the model only; the integer program is held to this, and shares nothing with it.
"""

from fuzzyspec.exact.controller import evaluate_controller
from fuzzyspec.exact.dequantise import dequantise
from fuzzyspec.exact.rational import Point, controller_point, evaluate_controller_exactly
from fuzzyspec.exact.rational_system import SystemPoint, evaluate_system_exactly, system_point
from fuzzyspec.exact.result import Exact
from fuzzyspec.exact.system import evaluate_system

__all__ = [
    "Exact",
    "Point",
    "SystemPoint",
    "controller_point",
    "dequantise",
    "evaluate_controller",
    "evaluate_controller_exactly",
    "evaluate_system",
    "evaluate_system_exactly",
    "system_point",
]
