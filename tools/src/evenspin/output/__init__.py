"""What the commands write: there completely or not at all, and never in place of something else.

origin     where an output comes from: the command and what it read
manifest   what stands beside an output: command, version, commit, date, inputs, hashes
claim      one writer at a time
staging    the hidden folder in which an output grows, and what killed writers left of theirs
folder     a folder as output
file       a file as output
"""

from evenspin.output.file import OutputFile
from evenspin.output.folder import OutputFolder
from evenspin.output.origin import Origin

__all__ = ["Origin", "OutputFile", "OutputFolder"]
