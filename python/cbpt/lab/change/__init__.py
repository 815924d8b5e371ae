"""What changed between campaigns on the same reducer.

change       a case, readings before and after (or by level) -> Change
record       the answer as a record; answer, the same with text and JSON; text, in words
parties      levels with the same effects in the same forms, each fitted by itself
shared       one model for all levels: which numbers are shared, and the evidence of each choice
stand_ins    other effects in place of what seems to have changed
rest         what the fitted effects leave, and which changes are too small beside it
reproducibility  what a new set-up changes by itself, stated or from repeated set-ups
parameters   the numbers that changed, and those that did not
posterior    which numbers changed, from the evidence of the choices
designs      whether levels were loaded alike
noise        whether the scatter changed
progress     tells how far the work is
"""
