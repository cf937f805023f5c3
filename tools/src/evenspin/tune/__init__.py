"""From the numbers of a machine to the parameters of its drive: bandwidths, margins, and a check in simulation.

goals      what is wanted: stiff, smooth or quiet
corners    the machines that the tolerances of a model leave
loops      current and speed loop as the drive samples them, and their margins
gains      bandwidths to parameters of current, speed, observers and position
ripple     repetitive control: lead and learning gain from the loop
trial      what is simulated: start, load step, reversal, full speed
methods    does a method help on this drive, and if not, what would make it
tuning     all of it in order
result     tables, JSON and the drive file
"""
