"""What several tests share."""

PATIENCE_S = 120.0
"""How long a test waits for what must come. Only what hangs is meant to meet it, however busy the
machine is: no test measures time against a clock."""
