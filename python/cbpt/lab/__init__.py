"""The lab: a model held against measurements."""
