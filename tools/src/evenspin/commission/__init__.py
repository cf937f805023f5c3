"""A motor of which nothing is known but its limits: measured step by step, then tuned.

limits     what its owner knows, and the parameters of a drive that knows no more
fits       from samples to numbers with intervals: windings, flux, mechanics
signals    excitation and recording through the link
steps      one procedure per thing that has to be known, in the order in which each needs the ones before
findings   what a step found, its quality, and what is known so far
work       all steps; on any error the bridge is off and the drive has its values from before
report     the files: model.toml, drive.toml, before.toml, report.md
"""
