//! Structural damping of a film of triangles: the law of Kelvin and Voigt, a stress proportional to the strain rate.
//!
//!     S_v = eta C : dE/dt   [Pa],     eta = 2 zeta sqrt(m / k),   k = 2 E_Y h A0 / L^2   [s]
//!
//! with C the stiffness of the film, m the mean mass of the three nodes (or half their harmonic mean, see
//! `spring_damping::mass`), or that of nodes with the mass of a square of film of side l_d (rho h l_d^2, with which eta
//! is the same on every mesh), and L^2 the mean square side. It corresponds to dashpots along
//! springs with c = 2 zeta sqrt(k m) = eta k: on an equilateral lattice at nu = 1/3, where springs represent the film
//! exactly, the two have the same forces near rest. The coefficient is positive on obtuse triangles too, and a rigid
//! motion has no rate of strain. A wrinkled film keeps its damping, as a buckled spring keeps its dashpot.

mod tangent;

use super::DampingParameters;
use crate::arrays::columns::{Columns, ColumnsMut};
use crate::arrays::state::NodeVectors;
use crate::assembly::Assembly;
use crate::elements::triangle::{FlatTriangles, strain_rate};
use crate::error::Result;
use crate::simd::dispatch::{BatchKernel, InstructionSet};
use crate::simd::lanes::{F64x8, SimdF64};

/// Damping of all triangles, in batches of eight.
pub(super) struct TriangleDamping {
    flat: FlatTriangles,
    /// eta [s].
    time: Vec<F64x8>,
    instructions: InstructionSet,
}

impl TriangleDamping {
    pub(super) fn new(parameters: DampingParameters, assembly: &Assembly) -> Result<Self> {
        let flat = FlatTriangles::new(assembly)?;
        let square = assembly.square_of_film(parameters.length);
        let mut times = Vec::with_capacity(assembly.mesh.triangles.len());
        for (triangle, &nodes) in assembly.mesh.triangles.iter().enumerate() {
            let squares: f64 = assembly.mesh.side_lengths(triangle).iter().map(|side| side * side).sum::<f64>() / 3.0;
            let modulus = assembly.film.as_ref().map_or(1.0, |film| film.of(triangle).membrane_stiffness());
            let stiffness = 2.0 * modulus * assembly.mesh.area(triangle)? / squares;
            let nodes = assembly.numbering.to_internal(nodes);
            let of = |values: &[f64]| nodes.map(|node| values[node as usize]);
            let of_nodes = || parameters.mass.of(&of(&assembly.masses), &of(&assembly.inverse_masses));
            let mass = square.map_or_else(of_nodes, |square| parameters.mass.of_equal(square));
            times.push(2.0 * parameters.ratio * (mass / stiffness).sqrt());
        }
        Ok(Self { time: flat.elements.pack(0.0, |row| times[row]), flat, instructions: assembly.instructions })
    }

    pub(super) fn contiguous_share(&self) -> f64 {
        self.flat.elements.contiguous_share()
    }

    /// Bound above the nodes of the triangles of a tile and of the tiles before it.
    pub(super) fn reach(&self, tile: usize) -> usize {
        self.flat.elements.reach(tile)
    }

    /// Adds sign times the damping forces -C v of the triangles of a tile to `out`, and returns the power of -C v.
    pub(super) fn add_forces(
        &self,
        tile: usize,
        x: &NodeVectors,
        v: &NodeVectors,
        out: &mut NodeVectors,
        sign: f64,
    ) -> f64 {
        let (positions, velocities, out) = (Columns::of(x), Columns::of(v), ColumnsMut::of(out));
        self.instructions.run_batches(StrainRateKernel { damping: self, tile, positions, velocities, out, sign })
    }
}

/// See `TriangleDamping::add_forces`.
struct StrainRateKernel<'a> {
    damping: &'a TriangleDamping,
    tile: usize,
    positions: Columns<'a>,
    velocities: Columns<'a>,
    out: ColumnsMut<'a>,
    sign: f64,
}

impl BatchKernel for StrainRateKernel<'_> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let TriangleDamping { flat, time, .. } = self.damping;
        let pass = flat.elements.pass::<KIND>(self.tile, self.positions.rows());
        let positions = pass.reader(self.positions);
        let velocities = pass.reader(self.velocities);
        let mut sums = pass.adder(&mut self.out);
        let sign = V::all(self.sign);
        let mut power = V::zero();
        for place in 0..pass.len() {
            let batch = pass.place(place);
            let f = flat.gradient(batch, positions.read::<V>(place));
            let rate = strain_rate(f, flat.gradient(batch, velocities.read::<V>(place)));
            let (eta, s) = (V::load(&time[batch]), flat.stress(rate));
            let stress = [eta * s[0], eta * s[1], eta * s[2]];
            let twice_12 = stress[2] * rate[2] + stress[2] * rate[2];
            power -= V::load(&flat.stiffness[batch]) * (stress[0] * rate[0] + stress[1] * rate[1] + twice_12);
            let forces = flat.nodal_forces(batch, f, [sign * stress[0], sign * stress[1], sign * stress[2]]);
            sums.add(place, forces);
        }
        power
    }
}
