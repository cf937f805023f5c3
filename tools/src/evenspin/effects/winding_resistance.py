"""Winding resistance over its nominal value; its tolerance has a sigma of 1.2 %."""

from evenspin.effects.hypothesis import Hypothesis, Params, Scale, factor


def hypothesis(scale: Scale) -> Hypothesis:
    return factor("winding_resistance", 0.1, 0.036)


def numbers(params: Params, plant: Params) -> Params:
    return {"resistance_ohm": plant["resistance_ohm"] * params["factor"]}
