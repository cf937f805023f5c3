"""Inertia over its nominal value; its tolerance has a sigma of 1.2 %."""

from evenspin.effects.hypothesis import Hypothesis, Params, Scale, factor


def hypothesis(scale: Scale) -> Hypothesis:
    return factor("inertia", 0.1, 0.036)


def numbers(params: Params, plant: Params) -> Params:
    return {"inertia_kgm2": plant["inertia_kgm2"] * params["factor"]}
