"""Terms of a machine model that no table of effects lists: a library of what a torque or a voltage may depend on.

`rows` is a log as the library takes it, `library` the families of terms with what each adds to the three equations of
the machine, `lines` finds orders and frequencies, `term` is a found one with its numbers, `words` says it to an
engineer, `verdict` to a file, and `pictures` draws it.
"""

from evenspin.empirical.library import FAMILIES, Family, family_of
from evenspin.empirical.rows import Column, Rows
from evenspin.empirical.term import EmpiricalTerm

__all__ = ["FAMILIES", "Column", "EmpiricalTerm", "Family", "Rows", "family_of"]
