"""One hypothesis fitted: values, uncertainties, evidence.

fit                the most probable values and the evidence
modes              other solutions of the same hypothesis
residuals          what a fit leaves of the readings
cross_validation   errors on readings held out
estimates          parameters with their uncertainty
budget             what an uncertainty is made of
prediction         the angle at a load of choice
results            all numbers as one table
"""
