//! Drag of the residual air, eq. (5), on each of a triangle's nodes against its velocity V relative to the air:
//!
//!     D = rho_air V^2 S_n / 6   [N],    S_n = |S . V| / V the area projected along V,   so   F = -(rho_air/6) |S . V| V
//!
//! with S the triangle's vector area and rho_air = p / (R T), R = 287 J/(kg K). The air is at rest in the chamber, so that
//! V = v + Omega x r in the turning frame, or it turns with the hub, so that V = v.
//! Source: Okuizumi et al. (2012), section 3.4.

mod tangent;

use std::sync::{Mutex, PoisonError};

use super::{Law, Spin};
use crate::columns::{Columns, ColumnsMut, total};
use crate::error::Result;
use crate::lanes::{Lanes, Point, Vector, cross, dot, scale, sub, sum};
use crate::layout::Elements;
use crate::model::{Assembly, non_negative, positive};
use crate::slopes::Slopes;
use crate::state::{Instant, Vectors, columns, columns_mut};
use crate::width::{Kernel, Width};

/// Specific gas constant of air \[J/(kg K)\].
const GAS_CONSTANT: f64 = 287.0;

/// Nodes that are gone over axis by axis while they are in the cache.
const STRETCH: usize = 1024;

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
    /// 1 where there is a triangle, 0 in lanes that are filled up.
    presence: Vec<Lanes>,
    /// rho_air / 12 [kg/m3]: a sixth, and a half because normals are twice the vector areas.
    factor: f64,
    /// Room for the sum of |S . V| over the triangles of each node, S twice the vector area [m3/s].
    flows: Mutex<Vec<f64>>,
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
        let nodes = assembly.masses.len();
        let factor = parameters.pressure / (GAS_CONSTANT * parameters.temperature) / 12.0;
        Ok(Self {
            presence: elements.pack(0.0, |_| 1.0),
            elements,
            factor,
            flows: Mutex::new(vec![0.0; nodes]),
            spin: if parameters.air == AirMotion::Still { spin } else { Spin::default() },
            width: assembly.width,
        })
    }
}

/// The velocity relative to the air of nodes at `r` that move with `v` in the frame.
#[inline(always)]
fn wind<V: Vector>(r: Point<V>, v: Point<V>, rate: V) -> Point<V> {
    [v[0] - rate * r[1], v[1] + rate * r[0], v[2]]
}

/// Adds the drag to the forces, and gives its power in the frame: first the flow |S . V| through the triangles round each
/// node, then F = -(rho_air/6) (sum of flows) V, and F . v.
struct Resist<'a> {
    drag: &'a AirDrag,
    flows: &'a mut [f64],
    positions: &'a Vectors,
    velocities: &'a Vectors,
    forces: &'a mut Vectors,
    rate: f64,
}

impl Resist<'_> {
    #[inline(always)]
    fn add_flows<V: Vector, const LOOSE: bool>(&mut self) {
        let pass = self.drag.elements.pass::<LOOSE>(self.positions.nrows());
        let presence = pass.of(&self.drag.presence);
        let (positions, velocities) = (Columns::of(self.positions), Columns::of(self.velocities));
        let mut flows = ColumnsMut::single(self.flows);
        let rate = V::all(self.rate);
        for group in 0..pass.len() {
            let r = pass.read::<V>(positions, group);
            let v = pass.read::<V>(velocities, group);
            let normal = cross(sub(r[1], r[0]), sub(r[2], r[0]));
            let mut flow = [V::zero(); 3];
            for k in 0..3 {
                flow[k] = dot(normal, wind(r[k], v[k], rate)).abs() * V::load(&presence[group]);
            }
            pass.add_numbers(&mut flows, group, flow);
        }
    }

    #[inline(always)]
    fn add_drag(&mut self) -> f64 {
        let ([x, y, _], [u, v, w]) = (columns(self.positions), columns(self.velocities));
        let [fx, fy, fz] = columns_mut(self.forces);
        let power = &mut *self.flows;
        for start in (0..power.len()).step_by(STRETCH) {
            let here = start..power.len().min(start + STRETCH);
            let n = here.len();
            // Equal lengths, said once, so that the loops need no check.
            let (x, y) = (&x[here.clone()][..n], &y[here.clone()][..n]);
            let (u, v, w) = (&u[here.clone()][..n], &v[here.clone()][..n], &w[here.clone()][..n]);
            let (fx, fy) = (&mut fx[here.clone()][..n], &mut fy[here.clone()][..n]);
            let (fz, flows) = (&mut fz[here.clone()][..n], &mut power[here][..n]);
            // One axis at a time: with more arrays in one loop the compiler gives up vectors.
            for i in 0..n {
                flows[i] *= -self.drag.factor;
                fx[i] += flows[i] * (u[i] - self.rate * y[i]);
            }
            for i in 0..n {
                fy[i] += flows[i] * (v[i] + self.rate * x[i]);
            }
            for i in 0..n {
                fz[i] += flows[i] * w[i];
            }
            for i in 0..n {
                let (wind_x, wind_y) = (u[i] - self.rate * y[i], v[i] + self.rate * x[i]);
                flows[i] *= wind_x * u[i] + wind_y * v[i] + w[i] * w[i];
            }
        }
        total(power)
    }
}

impl Kernel for Resist<'_> {
    type Output = f64;

    #[inline(always)]
    fn sweep<V: Vector>(mut self) -> f64 {
        self.flows.fill(0.0);
        self.add_flows::<V, false>();
        self.add_flows::<V, true>();
        self.add_drag()
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
        // What a panic left behind is filled anew.
        let mut flows = self.flows.lock().unwrap_or_else(PoisonError::into_inner);
        self.width.run_kernel(Resist {
            drag: self,
            flows: &mut flows,
            positions: at.positions,
            velocities: at.velocities,
            forces,
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
                products[k] =
                    scale(Lanes::all(self.factor) * self.presence[group], sum(scale(flow.abs(), p[k]), along));
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

    fn lanes(&self) -> Option<[usize; 2]> {
        Some(self.elements.lanes())
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
