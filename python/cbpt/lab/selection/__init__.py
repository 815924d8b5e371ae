"""Hypotheses weighed against each other.

linear_screen      every effect at a glance, linearly
lack_of_fit        what a residual depends on
patterns           misfit without a name as a rival
ranking            an order that rounding does not decide
starts             where a full fit starts
setting            what all hypotheses of a competition share
model_comparison   every hypothesis fitted and weighed
decision           from odds to a verdict
fit_effects        chosen effects fitted
scan               regions where the model fails
"""
