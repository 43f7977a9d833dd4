"""MuJoCo, Newton and membrane_rs on the same elastic membrane: error against processor time, and times of a step.

MuJoCo and Newton are an optional extra, the dependency group "peers". `make peers` installs them and makes
docs/peers.md and docs/peers.png.
"""
