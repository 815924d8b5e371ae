"""A look at a table before any model does.

preflight    the verb and its answer
checks       all checks, in their order
record       what they find
units        units and signs against the case, and runs against each other
coverage     sides, torques, preloads and input angles; what could not be told
saturation   columns that stay at the end of their range
repeats      what was repeated, and how far it differs
display      the step of the display
loops        steps and noise of the torque, closing, zeros of runs
rates        how fast the load went
"""
