"""Where simulation and measured data disagree, and why."""
