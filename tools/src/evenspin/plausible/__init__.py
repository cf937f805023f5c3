"""Whether the columns of a log can be what their names say: dead channels, other units, swapped columns, wrong signs.

Only what contradicts physics beyond doubt is found here, because what is a little odd about a log may be the effect
that is checked. Nothing here knows a file format: columns are arrays in the units of their names.
"""

from evenspin.plausible.finding import Finding

__all__ = ["Finding"]
