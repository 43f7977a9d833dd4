//! Drag of the residual air, eq. (5), on each of a triangle's nodes against its velocity V relative to the air:
//!
//!     D = rho_air V^2 S_n / 6   [N],    S_n = |S . V| / V the area projected along V,   so   F = -(rho_air/6) |S . V| V
//!
//! with S the triangle's vector area and rho_air = p / (R T), R = 287 J/(kg K). The air is at rest in the chamber, so that
//! V = v + Omega x r in the turning frame, or it turns with the hub, so that V = v.
//! Source: Okuizumi et al. (2012), section 3.4.

mod tangent;

use super::{Law, Spin};
use crate::columns::{Columns, ColumnsMut};
use crate::error::Result;
use crate::lanes::{Lanes, Point, cross, dot, scale, sub, sum};
use crate::layout::{BATCH, Elements};
use crate::model::{Assembly, non_negative, positive};
use crate::slopes::Slopes;
use crate::state::{Instant, Vectors};
use crate::width::{Sweep, Width};

/// Specific gas constant of air \[J/(kg K)\].
const GAS_CONSTANT: f64 = 287.0;

/// How the air moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AirMotion {
    /// At rest in the chamber.
    #[default]
    Still,
    /// Turning with the hub.
    Turning,
}

/// Parameters of the air.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AirDragParameters {
    /// Pressure \[Pa\].
    pub pressure: f64,
    /// Temperature \[K\].
    pub temperature: f64,
    /// How the air moves.
    pub air: AirMotion,
}

/// The law: all triangles, eight to a group.
pub(super) struct AirDrag {
    elements: Elements<3>,
    /// rho_air / 12 [kg/m3]: a sixth, and a half because normals are twice the vector areas.
    factor: Vec<Lanes>,
    /// The frame's turning relative to the air.
    spin: Spin,
    width: Width,
}

impl AirDrag {
    pub(super) fn new(parameters: AirDragParameters, spin: Spin, assembly: &Assembly) -> Result<Self> {
        non_negative("pressure of the air [Pa]", parameters.pressure)?;
        positive("temperature of the air [K]", parameters.temperature)?;
        // Taken from the lowest node: drag does not ask which side faces the wind.
        let lowest_first = |[a, b, c]: [u32; 3]| match a.min(b).min(c) {
            lowest if lowest == a => [a, b, c],
            lowest if lowest == b => [b, c, a],
            _ => [c, a, b],
        };
        let triangles = assembly.mesh.triangles.iter().map(|&nodes| lowest_first(assembly.layout.inward(nodes)));
        let elements = Elements::new(&triangles.collect::<Vec<_>>(), assembly.masses.len());
        let factor = parameters.pressure / (GAS_CONSTANT * parameters.temperature) / 12.0;
        Ok(Self {
            factor: elements.pack(0.0, |_| factor),
            elements,
            spin: if parameters.air == AirMotion::Still { spin } else { Spin::default() },
            width: assembly.width,
        })
    }
}

/// The velocity relative to the air of a node at `r` that moves with `v` in the frame.
#[inline(always)]
fn wind(r: Point, v: Point, rate: Lanes) -> Point {
    [v[0] - rate * r[1], v[1] + rate * r[0], v[2]]
}

/// The drag on a node of a triangle with this normal (twice its vector area).
#[inline(always)]
fn drag(factor: Lanes, normal: Point, wind: Point) -> Point {
    scale(-(factor * dot(normal, wind).abs()), wind)
}

/// Adds the drag to the forces, and gives its power in the frame.
struct Resist<'a> {
    drag: &'a AirDrag,
    positions: Columns<'a>,
    velocities: Columns<'a>,
    forces: ColumnsMut<'a>,
    rate: f64,
}

impl Resist<'_> {
    #[inline(always)]
    fn part<const LOOSE: bool>(&mut self) -> Lanes {
        let AirDrag { elements, factor, .. } = self.drag;
        let rate = Lanes::all(self.rate);
        let mut power = Lanes::ZERO;
        for batch in elements.batches::<LOOSE>() {
            let mut powers = [Lanes::ZERO; BATCH];
            for (group, power) in batch.zip(&mut powers) {
                let [ra, rb, rc] = elements.read::<LOOSE>(self.positions, group);
                let [va, vb, vc] = elements.read::<LOOSE>(self.velocities, group);
                let normal = cross(sub(rb, ra), sub(rc, ra));
                let a = drag(factor[group], normal, wind(ra, va, rate));
                let b = drag(factor[group], normal, wind(rb, vb, rate));
                let c = drag(factor[group], normal, wind(rc, vc, rate));
                *power = dot(a, va) + dot(b, vb) + dot(c, vc);
                elements.add::<LOOSE>(&mut self.forces, group, [a, b, c]);
            }
            powers.iter().for_each(|&of_group| power += of_group);
        }
        power
    }
}

impl Sweep for Resist<'_> {
    type Output = f64;

    #[inline(always)]
    fn sweep(mut self) -> f64 {
        (self.part::<false>() + self.part::<true>()).sum()
    }
}

impl Law for AirDrag {
    fn name(&self) -> &'static str {
        "air_drag"
    }

    fn is_conservative(&self) -> bool {
        false
    }

    fn add_forces(&self, at: Instant<'_>, forces: &mut Vectors) -> f64 {
        self.width.run(Resist {
            drag: self,
            positions: Columns::of(at.positions),
            velocities: Columns::of(at.velocities),
            forces: ColumnsMut::of(forces),
            rate: self.spin.rate_at(at.time),
        })
    }

    /// The derivative of |S . V| V by V.
    fn add_damping_product(&self, at: Instant<'_>, p: &Vectors, out: &mut Vectors) {
        let (x, v, p) = (Columns::of(at.positions), Columns::of(at.velocities), Columns::of(p));
        let mut out = ColumnsMut::of(out);
        let rate = Lanes::all(self.spin.rate_at(at.time));
        for group in 0..self.elements.group_count() {
            let [r, v, p] = [x, v, p].map(|columns| self.elements.read_any(columns, group));
            let normal = cross(sub(r[1], r[0]), sub(r[2], r[0]));
            let mut products = [[Lanes::ZERO; 3]; 3];
            for k in 0..3 {
                let wind = wind(r[k], v[k], rate);
                let flow = dot(normal, wind);
                let along = scale(dot(normal, p[k]).copysign(flow * dot(normal, p[k])), wind);
                products[k] = scale(self.factor[group], sum(scale(flow.abs(), p[k]), along));
            }
            self.elements.add_any(&mut out, group, products);
        }
    }

    fn visit_couplings(&self, visit: &mut dyn FnMut(&[u32])) {
        self.elements.each().for_each(|(.., nodes)| visit(&nodes));
    }

    fn add_slopes(&self, at: Instant<'_>, slopes: &mut dyn Slopes) {
        self.slopes(at, slopes);
    }

    fn share_in_runs(&self) -> Option<f64> {
        Some(self.elements.share_in_runs())
    }

    fn cure(&self) -> &'static str {
        "use a smaller dt or a lower pressure"
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Film, Model};

    #[test]
    fn drag_on_a_plate_across_the_wind_is_half_rho_v2_s() {
        let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let film = Film { youngs_modulus: 1.0, poisson_ratio: 0.3, density: 1.0, thickness: 1.0 };
        let model = Model {
            positions: points.clone(),
            velocities: vec![[0.0, 0.0, 2.0]; 3],
            reference: points,
            triangles: vec![[0, 1, 2]],
            film: Some(film),
            extra_masses: vec![0.0; 3],
            ..Model::default()
        };
        let assembly = Assembly::new(model, Width::widest()).unwrap();
        let parameters = AirDragParameters { pressure: 4.5, temperature: 293.0, air: AirMotion::Still };
        let drag = AirDrag::new(parameters, Spin::default(), &assembly).unwrap();
        let (x, v) = (
            assembly.layout.gather_vectors(&assembly.model.positions),
            assembly.layout.gather_vectors(&assembly.model.velocities),
        );
        let mut forces = Vectors::zeros(3);
        let power = drag.add_forces(Instant { time: 0.0, positions: &x, velocities: &v }, &mut forces);
        let expected = -0.5 * 5.35e-5 * 4.0 * 0.5;
        assert!((forces.column(2).sum() / expected - 1.0).abs() < 1e-3);
        assert!((power - 2.0 * forces.column(2).sum()).abs() < 1e-18);
    }
}
