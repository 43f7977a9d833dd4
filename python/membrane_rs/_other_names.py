"""What the literature calls some fields, for messages about unknown names."""

from __future__ import annotations

OTHER_NAMES = {
    "omega": ("frequency", "in Hz: omega / (2 pi)"),
    "rpm": ("frequency", "in Hz: rpm / 60"),
    "rate_hz": ("frequency", "in Hz"),
    "hz": ("frequency", "in Hz"),
    "alpha": ("buckling", ""),
    "beta": ("stiffness", ""),
    "gamma": ("contact_penalty", ""),
    "theta0": ("natural_angle", "in rad"),
    "zeta": ("ratio", ""),
    "e": ("youngs_modulus", "in Pa"),
    "modulus": ("youngs_modulus", "in Pa"),
    "nu": ("poisson_ratio", ""),
    "poisson": ("poisson_ratio", ""),
    "rho": ("density", "in kg/m3"),
    "h": ("thickness", "in m"),
    "g": ("acceleration", "in m/s2"),
    "ea": ("axial_stiffness", "in N"),
    "k": ("stiffness", ""),
    "method": ("integrator", ""),
    "end_time": ("until", "in s"),
    "t_end": ("until", "in s"),
    "time_step": ("dt", "in s"),
    "timestep": ("dt", "in s"),
}
"""What the paper and others call some fields, in lower case: the name here, and its unit."""
