"""The lab: a model held against measurements.

A package imports only those above it in this list (`tests/repo/test_layers.py`):

wording      names, numbers and units as text
readings     tables of readings from files and memory
covariance   how readings scatter
model        what is predicted for each reading, and what is plausible
inference    one hypothesis fitted: values, uncertainties, evidence
selection    hypotheses weighed against each other
characteristics   the figures of catalogues, read off loops of readings and model
preflight    a table before any model does
experiment   campaigns to come: simulated, judged, chosen
diagnosis    the verbs that answer a user, and how the answer is told
change       what changed between campaigns
"""
