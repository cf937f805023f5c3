"""Pictures and pages: axes with units, and the data and the command beside them."""
