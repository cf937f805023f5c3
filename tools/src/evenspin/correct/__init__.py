"""From a named cause to a drive that no longer has it.

quantities   what an effect spoils, as one number of a set of records
rules        the table: which parameters of the drive counteract which effect, and why none does
changes      how a parameter is changed, and how several corrections go together
found        the machine that `evenspin gap` has found, with the sizes of its effects and their intervals
predict      that machine simulated with and without the correction, the firmware in the loop
proposal     what is proposed and what is not, with the reason
file         correction.toml, and the experiments and the nominal machine that belong to it
anylog       the same for logs of any drive
commands     what was commanded in a record, as few points
fitting      whether a correction fits the drive as it is
trial        before, predicted, after: on a drive, and back again where it did not help
outcome      what a trial leaves
circle       all of it on a virtual drive
report       tables and a chapter
"""
