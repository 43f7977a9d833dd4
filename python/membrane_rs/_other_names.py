"""What the literature and other programs call some names of this package, for messages about unknown names."""

from __future__ import annotations

_SPIN = {
    "in Hz": "hz hertz rate_hz spin_hz freq f n spin rotation rate spin_frequency rotation_frequency",
    "in Hz: omega / (2 pi)": "omega w angular_velocity angular_speed angular_rate angular_frequency spin_rate "
    "rad_per_s spin_speed spin_velocity rotation_rate rotation_speed rotational_speed speed velocity",
    "in Hz: rpm / 60": "rpm rev_per_min revolutions_per_minute turns_per_minute",
    "in Hz: degrees per second / 360": "deg_per_s degrees_per_second",
}
_SPIN_UP = {
    "in Hz/s: rad/s2 / (2 pi)": "angular_acceleration omega_dot domega alpha omegadot spin_acceleration spin_up "
    "rotational_acceleration",
}
_FIELDS = {
    "youngs_modulus": {"in Pa": "e modulus young youngs elastic_modulus modulus_of_elasticity young_modulus e_modulus"},
    "poisson_ratio": {"": "nu v poisson poissons poissons_ratio"},
    "density": {"in kg/m3": "rho mass_density volumetric_density"},
    "linear_density": {"in kg/m": "rho mu density mass_per_length"},
    "thickness": {"in m": "h t thick film_thickness"},
    "axial_stiffness": {"in N": "ea stiffness k"},
    "stiffness": {"": "beta k spring_constant crease_stiffness"},
    "buckling": {"": "alpha"},
    "contact_penalty": {"": "gamma"},
    "natural_angle": {"in rad": "theta0 theta_0 rest_angle equilibrium_angle neutral_angle"},
    "fold_angle": {"in rad": "theta angle dihedral dihedral_angle"},
    "fold_angles": {"in rad": "theta angles dihedral_angles fold_angle"},
    "ratio": {"": "zeta xi damping_ratio damping damping_factor"},
    "rate": {"in 1/s": "damping friction c mass_damping damping_rate"},
    "acceleration": {"in m/s2": "g gravity vector"},
    "pressure": {"in Pa": "p load"},
    "temperature": {"in K": "temp t"},
    "radius": {"in m": "r spool_radius hub_radius diameter"},
    "anchor_radius": {"in m": "radius hub_radius spool_radius r"},
    "tip_mass": {"in kg": "mass m tip"},
    "restitution": {"": "cor coefficient_of_restitution bounce elasticity"},
    "mass": {"in kg": "tip_mass m weight"},
    "length": {"in m": "l"},
    "segments": {"": "n elements count"},
    "integrator": {"": "method solver scheme"},
    "until": {"in s": "end_time t_end tend end duration stop_time t_max tmax total_time"},
    "dt": {"in s": "time_step timestep step h delta_t"},
    "tolerance": {"": "rtol tol atol"},
    "spectral_radius": {"": "rho_inf rho_infinity"},
    "reference": {"in m": "vertices nodes points rest_positions flat"},
    "triangles": {"": "faces cells elements connectivity"},
    "positions": {"in m": "x coordinates current deformed"},
    "velocities": {"in m/s": "v"},
    "creases": {"": "folds hinges"},
    "spin": {"": "rotation hub centrifugal omega"},
    "gravity": {"": "weight g"},
    "air_drag": {"": "air wind"},
    "solar_pressure": {"": "srp sunlight light solar radiation_pressure light_pressure solar_radiation_pressure"},
    "point_forces": {"": "forces nodal_forces node_forces loads point_loads thrust"},
    "force": {"in N, on each node": "load total_force"},
    "sun": {"": "sun_direction direction_to_sun sun_vector"},
    "self_contact": {"": "self_collision collision collisions layers layer_contact"},
    "springs": {"": "film membrane bars"},
    "region": {"": "zone patch area material_region panel device devices"},
    "crease_set": {"": "crease_group fold_set"},
    "areal_mass": {"in kg/m2": "surface_density area_density mass_per_area areal_density"},
    "natural_strain": {"": "thermal_strain prestrain eigenstrain prestress pretension"},
    "fold_fraction": {"": "fold_percent folding fold_ratio"},
    "shear_modulus": {"in Pa": "g12"},
    "youngs_modulus_across": {"in Pa": "e2 youngs_modulus_2 transverse_modulus"},
    "tether": {"": "cable rope cord string"},
    "fixed": {"": "clamp clamped support supports anchor pinned boundary"},
}

OTHER_NAMES: dict[str, list[tuple[str, str]]] = {}
"""By what others call it, in lower case: names here with their units, the likeliest first."""
for _name, _words_by_unit in [("frequency", _SPIN), ("acceleration", _SPIN_UP), *_FIELDS.items()]:
    for _unit, _words in _words_by_unit.items():
        for _word in _words.split():
            OTHER_NAMES.setdefault(_word, []).append((_name, _unit))
