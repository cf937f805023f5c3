"""A motor of one's own: from a name plate or a data sheet to a model file and a drive file.

plate       what a name plate says, in the units that are printed there
flux        the flux linkage of the magnets from any of the constants that data sheets give
resolve     the numbers of [plant] with origin and range, and what contradicts
limits      the limits of a drive for this motor, its supply and its board
files       the text of model.toml, drive.toml and first.toml
"""
