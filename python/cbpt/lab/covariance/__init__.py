"""How readings scatter.

noise           the covariance of the readings, and how to look at them through it
within_run      scatter from the smoothness inside runs
repeatability   scatter from repeats
outliers        loose readings
"""
