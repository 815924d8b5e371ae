"""Hypotheses weighed against each other.

ranking            an order that rounding does not decide
linear_screen      every effect at a glance, linearly
starts             where a full fit starts
refits             single fits: their tasks, and what is asked of them
lack_of_fit        what a residual depends on, without naming a cause
history            whether friction goes on from run to run, and what was before; turning, where
                   the torque reversed; friction_fits, what both are told by
setting            what all hypotheses of a competition share
model_comparison   every hypothesis fitted and weighed
rules              thresholds of the decision
decision           from odds to a verdict
fit_effects        chosen effects fitted
scan               regions where the model fails
"""
