"""One hypothesis fitted: values, uncertainties, evidence.

hypothesis         variants of effects at work together, and the unknowns that come with them
gauss_newton       the search for the most probable values
evidence           the fit at these values and its marginal likelihood
fit                hypotheses fitted to one data set
modes              other modes of the same hypothesis
residuals          what a fit leaves of the readings
cross_validation   errors on readings held out
estimates          parameters with their uncertainty
budget             what an uncertainty is made of
prediction         the angle at a load of choice
results            all numbers as one table
"""
