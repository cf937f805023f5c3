"""Identification of a machine from logs of experiments, or from experiments on the simulated drive."""
