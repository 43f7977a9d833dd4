"""Checks of a scene before it runs."""
