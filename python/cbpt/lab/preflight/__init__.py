"""A look at a table before any model does.

preflight      the verb and its answer
checks         all checks, in their order
record         what they find
odd_readings   single readings that are wrong, and frozen signals
units          units and signs against the case, and runs against each other
coverage       sides and torques, and what could not be told; coverage_settings, preloads and angles
saturation     columns that stay at the end of their range
legs           ways of the torque from one turn to the next, and which repeat each other
repeats        what was repeated, and how far it differs; repeats_compared, how legs differ,
               repeats_copies, runs that are copies
display        steps of the displays
loops          steps and noise of the torque
rates          how fast the load went
closing        loops that do not close, and drift
zeros          angles of the runs at zero torque
sizes          turn, width and scatter of loops, for all of these
"""
