//! Springs with buckling, and their dashpots.

use std::f64::consts::PI;

use membrane_core::assembly::Assembly;
use membrane_core::laws::SpringParameters;

use super::{Motion, Oracle, add, dot, sub};

pub struct Spring {
    pub nodes: [u32; 2],
    pub stiffness: f64,
    pub rest_length: f64,
    pub critical_length: f64,
    pub damping: f64,
    /// Whether the tension above that of buckling limits the resistance of the dashpot.
    pub is_limited: bool,
}

/// The springs of the film, without dashpots.
pub fn film(parameters: &SpringParameters, assembly: &Assembly) -> Vec<Spring> {
    let thickness = assembly.model.film.map_or(0.0, |film| film.thickness);
    let mut alphas = vec![parameters.buckling; assembly.mesh.edges.len()];
    for hinge in &assembly.hinges {
        alphas[hinge.edge as usize] = parameters.buckling_on_creases;
    }
    let mut springs = Vec::new();
    for ((&nodes, &stiffness), alpha) in assembly.mesh.edges.iter().zip(&assembly.edge_stiffness).zip(alphas) {
        let [a, b] = nodes.map(|node| assembly.mesh.reference[node as usize]);
        let rest_length = dot(sub(b, a), sub(b, a)).sqrt();
        let critical_length = rest_length - alpha * (PI * thickness).powi(2) / (12.0 * rest_length);
        springs.push(Spring { nodes, stiffness, rest_length, critical_length, damping: 0.0, is_limited: false });
    }
    springs
}

/// The segments of the cords, without dashpots.
pub fn cords(assembly: &Assembly) -> impl Iterator<Item = Spring> {
    assembly.model.cords.iter().map(|cord| Spring {
        nodes: cord.nodes,
        stiffness: cord.stiffness,
        rest_length: cord.rest_length,
        critical_length: cord.rest_length * (1.0 - cord.critical_strain),
        damping: 0.0,
        is_limited: false,
    })
}

/// The reduced mass of two nodes [kg]; that of the other node where one is held.
pub fn reduced_mass(nodes: [u32; 2], [i, j]: [f64; 2], held: &[u32]) -> f64 {
    match nodes.map(|node| held.contains(&node)) {
        [false, false] => i * j / (i + j),
        [false, true] => i,
        [true, false] => j,
        [true, true] => 0.0,
    }
}

impl Oracle {
    /// Springs, tethers and dashpots, and the power of the dashpots.
    pub(super) fn add_springs(&self, motion: &mut Motion) -> f64 {
        let Motion { positions, velocities, forces } = motion;
        let mut power = 0.0;
        for spring in &self.springs {
            let [i, j] = spring.nodes.map(|node| node as usize);
            let span = sub(positions[j], positions[i]);
            let length = dot(span, span).sqrt();
            let rate = dot(span, sub(velocities[j], velocities[i])) / length;
            let tension = spring.stiffness * (length.max(spring.critical_length) - spring.rest_length);
            let mut resistance = spring.damping * rate;
            if spring.is_limited {
                let most = spring.stiffness * (length - spring.critical_length).max(0.0);
                resistance = resistance.abs().min(most) * rate.signum();
            }
            power -= resistance * rate;
            let per_length = (tension + resistance) / length;
            add(&mut forces[i], per_length, span);
            add(&mut forces[j], -per_length, span);
        }
        power
    }
}
