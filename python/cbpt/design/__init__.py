"""A drive that is still to be built: what its tolerances make of it, and the best within bounds."""
