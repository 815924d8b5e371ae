"""One hypothesis fitted: values, uncertainties, evidence.

hypothesis         variants of effects at work together, and the unknowns that come with them
least_squares      the least sum of squares of a nonlinear model, to the last digit
gauss_newton       the search for the most probable values, as far as a comparison needs it
evidence           the fit at these values and its marginal likelihood
fit                hypotheses fitted to one data set
crew               fits side by side on the cores
modes              other modes of the same hypothesis
closing            the fit that is reported, taken to the last digit
residuals          what a fit leaves of the readings
cross_validation   errors on readings held out
estimates          parameters with their uncertainty
budget             what an uncertainty is made of
prediction         the angle at a load of choice
results            all numbers as one table
"""
