"""`python -m evenspin.gap.blind make|score ...`"""

import sys

from evenspin.cli.main import fail
from evenspin.errors import EvenspinError
from evenspin.gap.blind.command import app

if __name__ == "__main__":  # worker processes import this, too
    try:
        app(prog_name="python -m evenspin.gap.blind")
    except EvenspinError as error:
        fail(str(error), error.exit_code)
    sys.exit(0)
