"""Pictures of results. The only part of the package that loads plotting."""
