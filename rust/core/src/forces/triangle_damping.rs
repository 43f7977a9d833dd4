//! Structural damping of a film of triangles: Kelvin and Voigt's, a stress that goes with the rate of strain.
//!
//!     S_v = eta C : dE/dt   [Pa],     eta = 2 zeta sqrt(m / k),   k = 2 E_Y h A0 / L^2   [s]
//!
//! with C the film's stiffness, m the mean mass of the three nodes, or that of a square of film of side l0 (rho h l0^2, which
//! makes eta the same on every mesh), L^2 the mean square side. It is what the dashpots along
//! springs are for springs, c = 2 zeta sqrt(k m) = eta k: on an equilateral lattice at nu = 1/3, where springs are the
//! film, the two have the same forces near rest. There is no dashpot that could turn negative on an obtuse triangle, and
//! a rigid motion has no rate of strain. A wrinkled film keeps its damping, as a buckled spring keeps its dashpot.

mod tangent;

use super::DampingParameters;
use super::flat_triangles::{Flat, strain_rate};
use crate::columns::{Columns, ColumnsMut};
use crate::error::Result;
use crate::lanes::{Lanes, Vector};
use crate::layout::BATCH;
use crate::model::Assembly;
use crate::state::Vectors;
use crate::width::{Sweep, Width};

/// Damping of all triangles, eight to a group.
pub(super) struct TriangleDamping {
    flat: Flat,
    /// eta [s].
    time: Vec<Lanes>,
    width: Width,
}

impl TriangleDamping {
    pub(super) fn new(parameters: DampingParameters, assembly: &Assembly) -> Result<Self> {
        let flat = Flat::new(assembly)?;
        let square = assembly.square_of_film(parameters.length);
        let modulus = assembly.model.film.map_or(1.0, |film| film.youngs_modulus * film.thickness);
        let mut times = Vec::with_capacity(assembly.mesh.triangles.len());
        for (triangle, &nodes) in assembly.mesh.triangles.iter().enumerate() {
            let squares: f64 = assembly.mesh.side_lengths(triangle).iter().map(|side| side * side).sum::<f64>() / 3.0;
            let stiffness = 2.0 * modulus * assembly.mesh.area(triangle)? / squares;
            let masses = assembly.layout.inward(nodes).map(|node| assembly.masses[node as usize]);
            let mass = square.unwrap_or(masses.iter().sum::<f64>() / 3.0);
            times.push(2.0 * parameters.ratio * (mass / stiffness).sqrt());
        }
        Ok(Self { time: flat.elements.pack(0.0, |row| times[row]), flat, width: assembly.width })
    }

    pub(super) fn share_in_runs(&self) -> f64 {
        self.flat.elements.share_in_runs()
    }

    /// Adds -sign C v to `out`, and gives the power of -C v on v.
    pub(super) fn resist(&self, x: &Vectors, v: &Vectors, out: &mut Vectors, sign: f64) -> f64 {
        self.width.run(Resist {
            damping: self,
            positions: Columns::of(x),
            velocities: Columns::of(v),
            out: ColumnsMut::of(out),
            sign,
        })
    }
}

struct Resist<'a> {
    damping: &'a TriangleDamping,
    positions: Columns<'a>,
    velocities: Columns<'a>,
    out: ColumnsMut<'a>,
    sign: f64,
}

impl Resist<'_> {
    #[inline(always)]
    fn part<const LOOSE: bool>(&mut self) -> Lanes {
        let TriangleDamping { flat, time, .. } = self.damping;
        let mut power = Lanes::ZERO;
        let pass = flat.elements.pass::<LOOSE>(self.positions.rows());
        for batch in pass.batches() {
            let mut powers = [Lanes::ZERO; BATCH];
            for (place, power) in batch.zip(&mut powers) {
                let group = pass.place(place);
                let f = flat.gradient(group, pass.read(self.positions, place));
                let velocities = pass.read(self.velocities, place);
                let rate = strain_rate(f, flat.gradient(group, velocities));
                let eta = time[group];
                let s = flat.stress(rate);
                let stress = [eta * s[0], eta * s[1], eta * s[2]];
                let twice_12 = stress[2] * rate[2] + stress[2] * rate[2];
                *power = -(flat.stiffness[group] * (stress[0] * rate[0] + stress[1] * rate[1] + twice_12));
                let sign = Lanes::all(self.sign);
                let pull = flat.pull(group, f, [sign * stress[0], sign * stress[1], sign * stress[2]]);
                pass.add(&mut self.out, place, pull);
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
