"""Measures of shapes, on plain arrays: strain of triangles, deployment of corners. No scene, no simulation."""
