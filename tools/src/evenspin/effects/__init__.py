"""What is known about each effect beyond the simulator's table: how to search it, and at which orders it shows.

The table (sim_host/effects/*.c) is the list of effects, with parameters, roles, signatures, neighbours and experiments.
A module here, named like the effect, adds what a search of that effect needs:

    def hypothesis(scale: Scale) -> Hypothesis    coordinates, starts, sizes
    def orders(scale: Scale) -> tuple[int, ...]   mechanical orders at which it shows, where it has any

An effect without a module is searched by the roles of its parameters.
"""

from evenspin.effects.hypothesis import Coordinate, Hypothesis, Scale, by_difference
from evenspin.effects.registry import hypotheses, known_orders

__all__ = ["Coordinate", "Hypothesis", "Scale", "by_difference", "hypotheses", "known_orders"]
