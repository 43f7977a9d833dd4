//! Creases, with contact between their facets.

use std::f64::consts::{FRAC_PI_2, TAU};

use membrane_core::assembly::Assembly;
use membrane_core::laws::CreaseParameters;

use super::{Motion, Oracle, add, cross, dot, scale, sub};

/// Contact penalty, and natural angle [rad].
#[derive(Default)]
pub struct Parameters {
    pub contact_penalty: f64,
    pub natural_angle: f64,
}

impl Parameters {
    pub fn of(parameters: &CreaseParameters) -> Self {
        Self { contact_penalty: parameters.contact_penalty, natural_angle: parameters.natural_angle }
    }
}

pub struct Crease {
    /// The ends of the crease, and the apexes of its facets.
    pub nodes: [u32; 4],
    /// +1 valley, -1 mountain.
    pub sign: f64,
    /// (1 + c^2)^2 kappa, with the constant factors of the weights of both facets [N m/rad].
    pub stiffness: f64,
    /// 4 (c A0)^2 of each facet [m4].
    pub softening: [f64; 2],
}

pub fn all(parameters: &CreaseParameters, assembly: &Assembly) -> Vec<Crease> {
    let bending = assembly.model.film.map_or(0.0, |film| film.youngs_modulus * film.thickness.powi(3) / 12.0);
    let mut creases = Vec::new();
    for (hinge, &sign) in assembly.hinges.iter().zip(&assembly.model.creases.fold_signs) {
        let [a, b, c, d] = hinge.nodes.map(|node| assembly.mesh.reference[node as usize]);
        let length = dot(sub(b, a), sub(b, a)).sqrt();
        let areas = [c, d].map(|apex| {
            let normal = cross(sub(b, a), sub(apex, a));
            0.5 * dot(normal, normal).sqrt()
        });
        let height = parameters.length_scale.unwrap_or((areas[0] + areas[1]) / length);
        creases.push(Crease {
            nodes: hinge.nodes,
            sign,
            stiffness: parameters.stiffness * bending * length / height * (1.0 + parameters.collapse.powi(2)).powi(2),
            softening: areas.map(|area| (2.0 * parameters.collapse * area).powi(2)),
        });
    }
    creases
}

impl Oracle {
    /// -dU/dx of U = w_C w_D u(theta), w = (1 + c^2) q/(q + s), q the square of a facet's normal.
    pub(super) fn add_creases(&self, motion: &mut Motion) -> f64 {
        let Motion { positions, forces, .. } = motion;
        let Parameters { contact_penalty, natural_angle } = self.crease_parameters;
        for crease in &self.creases {
            let nodes = crease.nodes.map(|node| node as usize);
            let [a, b, c, d] = nodes.map(|node| positions[node]);
            let (e, c, d) = (sub(b, a), sub(c, a), sub(d, a));
            let normals = [cross(e, c), cross(d, e)];
            let length_square = dot(e, e);
            let length = length_square.sqrt();
            let sine = crease.sign * dot(cross(normals[1], normals[0]), e) / length;
            let mut angle = sine.atan2(-dot(normals[0], normals[1]));
            if angle < -FRAC_PI_2 {
                angle += TAU;
            }
            let opening = angle - natural_angle;
            let mut energy = 0.5 * crease.stiffness * opening * opening;
            let mut moment = crease.stiffness * opening;
            if angle < 0.0 {
                let contact = (contact_penalty - 1.0) * crease.stiffness * angle;
                energy += 0.5 * contact * angle;
                moment += contact;
            }
            let squares = normals.map(|normal| dot(normal, normal));
            let shares = [0, 1].map(|facet| 1.0 / (squares[facet] + crease.softening[facet]));
            let weights = [0, 1].map(|facet| squares[facet] * shares[facet]);
            for (facet, apex, opposite) in [(0, c, e), (1, d, e)] {
                // The moment acts on the apex; the ends of the crease bear the balancing forces.
                let normal = crease.sign * moment * length * weights[1 - facet] * shares[facet];
                let at_apex = scale(normal, normals[facet]);
                let along = dot(apex, e) / length_square;
                add(&mut forces[nodes[2 + facet]], 1.0, at_apex);
                add(&mut forces[nodes[0]], along - 1.0, at_apex);
                add(&mut forces[nodes[1]], -along, at_apex);
                // The weight depends on the area of the facet; its gradient by a corner is normal x opposite side.
                let side = if facet == 0 { 1.0 } else { -1.0 };
                let factor =
                    -2.0 * side * energy * weights[1 - facet] * crease.softening[facet] * shares[facet].powi(2);
                let in_plane = scale(factor, normals[facet]);
                add(&mut forces[nodes[2 + facet]], 1.0, cross(in_plane, opposite));
                add(&mut forces[nodes[1]], 1.0, cross(apex, in_plane));
                add(&mut forces[nodes[0]], 1.0, cross(in_plane, sub(apex, opposite)));
            }
        }
        0.0
    }
}
