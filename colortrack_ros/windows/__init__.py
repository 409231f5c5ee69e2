"""Window matching."""
