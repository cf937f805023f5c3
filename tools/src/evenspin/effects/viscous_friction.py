"""Viscous friction over its nominal value; its tolerance has a sigma of 4 %."""

from evenspin.effects.hypothesis import Hypothesis, Params, Scale, factor


def hypothesis(scale: Scale) -> Hypothesis:
    return factor("viscous_friction", 0.3, 0.12)


def numbers(params: Params, plant: Params) -> Params:
    return {"viscous_nms": plant["viscous_nms"] * params["factor"]}
