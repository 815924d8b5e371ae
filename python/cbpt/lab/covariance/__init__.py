"""How readings scatter.

linear_gaussian  covariance of the readings, and a linear model seen through it
fit_noise        the noise that makes readings most likely
within_run       scatter from the smoothness inside runs
repeatability    scatter from repeats
outliers         readings that scatter more than the rest
one_thread       linear algebra on one thread
"""
