"""What studies share: runs, the pool that makes them, variations of a scene, differences between runs."""
