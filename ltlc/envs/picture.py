"""Pictures of grid worlds."""
