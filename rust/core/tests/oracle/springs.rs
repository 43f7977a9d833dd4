//! Springs with buckling, and their dashpots.

use std::collections::HashMap;
use std::f64::consts::PI;

use membrane_core::assembly::Assembly;
use membrane_core::laws::SpringParameters;

use super::{Motion, Oracle, add, dot, sub};

#[derive(Clone, Copy)]
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

/// The springs of a film of rectangles, pairs of triangles with a common longest side, without dashpots.
pub fn rectangles(parameters: &SpringParameters, assembly: &Assembly) -> Vec<Spring> {
    let (mesh, film) = (&assembly.mesh, assembly.model.film.unwrap());
    let length = |[i, j]: [u32; 2]| {
        let span = sub(mesh.reference[j as usize], mesh.reference[i as usize]);
        dot(span, span).sqrt()
    };
    let mut springs = self::film(parameters, assembly);
    springs.iter_mut().for_each(|spring| spring.stiffness = 0.0);
    let mut row_of = HashMap::new();
    for (row, &[i, j]) in mesh.edges.iter().enumerate() {
        row_of.extend([((i, j), row), ((j, i), row)]);
    }
    let mut apexes: HashMap<usize, Vec<u32>> = HashMap::new();
    for &[a, b, c] in &mesh.triangles {
        let sides = [[b, c, a], [c, a, b], [a, b, c]];
        let [i, j, apex] =
            sides.into_iter().max_by(|p, q| length([p[0], p[1]]).total_cmp(&length([q[0], q[1]]))).unwrap();
        apexes.entry(row_of[&(i, j)]).or_default().push(apex);
    }
    let stretch = film.youngs_modulus * film.thickness / (1.0 - film.poisson_ratio.powi(2));
    let shear = film.youngs_modulus * film.thickness / (2.0 + 2.0 * film.poisson_ratio);
    for (diagonal, ends) in apexes {
        let [[p, q], [r, s]] = [mesh.edges[diagonal], [ends[0], ends[1]]];
        let (one, other) = (length([r, p]), length([r, q]));
        for (sides, along, across) in [([(r, p), (s, q)], one, other), ([(r, q), (s, p)], other, one)] {
            for side in sides {
                springs[row_of[&side]].stiffness += 0.5 * (stretch * across / along - shear * along / across);
            }
        }
        let stiffness = 0.5 * shear * (one * one + other * other) / (one * other);
        springs[diagonal].stiffness = stiffness;
        let own = Spring { stiffness, nodes: [r, s], ..springs[diagonal] };
        springs.push(own);
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
