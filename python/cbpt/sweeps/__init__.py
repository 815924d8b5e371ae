"""Sweeps over any parameter: here or on an executor (run), their files and labelled results."""
