"""Parameters of a scene from measured curves."""
