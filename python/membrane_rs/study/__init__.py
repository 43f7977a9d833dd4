"""Studies: one question per file, each answered by many runs of one scene."""
