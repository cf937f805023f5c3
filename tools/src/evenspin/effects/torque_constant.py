"""Flux linkage over its nominal value; its tolerance has a sigma of 0.4 %."""

from evenspin.effects.hypothesis import Hypothesis, Params, Scale, factor


def hypothesis(scale: Scale) -> Hypothesis:
    return factor("torque_constant", 0.04, 0.012)


def numbers(params: Params, plant: Params) -> Params:
    return {"psi_wb": plant["psi_wb"] * params["factor"]}
