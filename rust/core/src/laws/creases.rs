//! Crease stiffness, and contact between the two facets of a crease.
//!
//! Facets ABC and ABD share the crease AB. With L = |AB|, H the mean height of the facets in the reference mesh (or a
//! given length), J = h^3/12, and the crease angle theta (pi flat, 0 shut, negative where the facets interpenetrate),
//!
//!     kappa = beta E J L / H   [N m/rad]
//!     u     = kappa/2 (theta - theta0)^2 + (gamma - 1) kappa/2 (min(theta, 0)^2 + max(theta - 2 pi, 0)^2)   [J]
//!     U     = w_C w_D u,   w = (1 + c^2) A^2 / (A^2 + (c A0)^2)
//!
//! and every force is -dU/dx, so that the law conserves energy and does not resist rigid motion. A is the present and
//! A0 the reference area of a facet, at which w = 1: a crease of unstrained facets has exactly kappa. Without the
//! weights w the force on an apex, u'/height, is singular as a facet collapses, and a run gains energy there.
//! With |AB|/(4 A^2 + 4 (c A0)^2) the weighted force has no singularity.
//!
//! theta is a signed atan2 of the normals of the facets. The sign of the fold angle gives the side to which a crease
//! folds (valley +1, mountain -1). One that is folded against its side has more than pi, and is shut at 2 pi (`sides`).
//! Source: Okuizumi et al. (2012), eqs. (3) and (4), with these forces at w = 1; the weights, and the contact at 2 pi,
//! are added here.

mod sides;
mod stiffness;
mod tangent;

use std::f64::consts::TAU;

use serde::Deserialize;

use self::sides::Sides;
use self::stiffness::StiffnessKernel;
use super::{
    Context, HistoryDependent, Inspection, Instant, Kernels, Law, LawParameters, Linearisation, Properties, WorkClass,
};
use crate::arrays::blocks::tiles;
use crate::arrays::columns::{Columns, ColumnsMut};
use crate::arrays::jacobian::JacobianBlocks;
use crate::arrays::state::NodeVectors;
use crate::assembly::Assembly;
use crate::elements::hinge::{Facets, oriented};
use crate::error::Result;
use crate::layout::{CHUNK, Coded, ElementSet, Entry, merged};
use crate::model::checks::{finite, non_negative, positive};
use crate::model::mesh;
use crate::simd::dispatch::{BatchKernel, InstructionSet};
use crate::simd::lanes::{F64x8, LANES, SimdF64, Vec3, cross, dot, negate, scale, sum};

/// Parameters of the creases.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CreaseParameters {
    /// beta, the crease stiffness parameter.
    pub stiffness: f64,
    /// gamma, the contact penalty factor.
    pub contact_penalty: f64,
    /// theta0, the natural crease angle \[rad\].
    pub natural_angle: f64,
    /// H; `None`: the mean height of the two facets of each crease \[m\].
    pub length_scale: Option<f64>,
    /// c: the area of a facet, relative to its reference area, at which w is half its value for a large area.
    pub collapse: f64,
}

impl LawParameters for CreaseParameters {
    fn build(&self, context: &Context<'_>) -> Result<Box<dyn Law>> {
        Ok(Box::new(Creases::new(*self, context.assembly)?))
    }

    fn example() -> Self {
        Self { stiffness: 10.0, contact_penalty: 100.0, natural_angle: 1.0, length_scale: None, collapse: 0.05 }
    }
}

/// The law: all creases, in batches of eight. The nodes of an element are A, B, C, D.
struct Creases {
    elements: ElementSet<4>,
    parameters: Coded<Parameters>,
    sides: Sides,
    contact_penalty: f64,
    natural_angle: f64,
    /// Whether c is zero; the force is then singular as a facet collapses.
    is_singular: bool,
    instructions: InstructionSet,
}

/// Parameters of a batch.
#[derive(Debug, Clone, Copy)]
struct Parameters {
    /// +1 valley, -1 mountain.
    sign: F64x8,
    /// (1 + c^2)^2 kappa, with the constant factors of both weights [N m/rad].
    stiffness: F64x8,
    /// 4 (c A0)^2 of facet C and of facet D [m4].
    softening: [F64x8; 2],
}

impl Entry for Parameters {
    type Key = [[u64; LANES]; 4];

    fn key(&self) -> Self::Key {
        [self.sign, self.stiffness, self.softening[0], self.softening[1]].map(|values| values.key())
    }
}

/// Factors of the normals of facets C and D in the forces of a batch.
#[derive(Clone, Copy)]
struct Factors<V> {
    /// Of the moment, for forces normal to the facets.
    normal: [V; 2],
    /// Of the weights w, for forces in the planes of the facets.
    in_plane: [V; 2],
    /// Shares of the normal forces that B bears.
    at_b: [V; 2],
}

impl<V: SimdF64> Factors<V> {
    /// From u [J] and du/dtheta [N m] of creases with these facets.
    #[inline(always)]
    fn new(facets: &Facets<V>, parameters: &Parameters, energy: V, moment: V) -> Self {
        let [soft_c, soft_d] = [V::load(&parameters.softening[0]), V::load(&parameters.softening[1])];
        let (square_c, square_d) = (dot(facets.normal_c, facets.normal_c), dot(facets.normal_d, facets.normal_d));
        // 1/(q + s) of each facet, with q the square of its normal, by one division: w = q/(q + s), up to the factor
        // 1 + c^2 in the stiffness.
        let (root_c, root_d) = (square_c + soft_c, square_d + soft_d);
        let both = V::all(1.0) / (root_c * root_d);
        let (share_c, share_d) = (root_d * both, root_c * both);
        let (weight_c, weight_d) = (square_c * share_c, square_d * share_d);
        // theta = pi - sign * fold angle, so that the force -M dtheta/dx is sign M d(fold angle)/dx. The gradient of
        // the fold angle at C, times w_C, is |AB| n_C / (q_C + s_C).
        let normal = V::load(&parameters.sign) * moment * facets.length;
        // -u dw/dx: dw/dq = s/(q + s)^2 and dq/dP = 2 n x (opposite side, directed around the facet).
        let in_plane = V::all(-2.0) * energy;
        Self {
            normal: [normal * weight_d * share_c, normal * weight_c * share_d],
            in_plane: [
                in_plane * weight_d * soft_c * share_c * share_c,
                in_plane * weight_c * soft_d * share_d * share_d,
            ],
            at_b: facets.shares_at_b(),
        }
    }

    /// The forces on A, B, C and D.
    #[inline(always)]
    fn forces(&self, facets: &Facets<V>) -> [Vec3<V>; 4] {
        let (normal_c, normal_d) = (scale(self.normal[0], facets.normal_c), scale(self.normal[1], facets.normal_d));
        let (in_plane_c, in_plane_d) =
            (scale(self.in_plane[0], facets.normal_c), scale(self.in_plane[1], facets.normal_d));
        let at_c = sum(normal_c, cross(in_plane_c, facets.e));
        let at_d = sum(normal_d, cross(facets.e, in_plane_d));
        let normal_b = sum(scale(self.at_b[0], normal_c), scale(self.at_b[1], normal_d));
        let at_b = sum(normal_b, sum(cross(facets.c, in_plane_c), cross(in_plane_d, facets.d)));
        [negate(sum(at_b, sum(at_c, at_d))), at_b, at_c, at_d]
    }
}

impl Creases {
    fn new(parameters: CreaseParameters, assembly: &Assembly) -> Result<Self> {
        let CreaseParameters { stiffness, contact_penalty, natural_angle, length_scale, collapse } = parameters;
        non_negative("stiffness of the creases", stiffness)?;
        non_negative("contact penalty of the creases", contact_penalty)?;
        finite("natural angle of the creases [rad]", natural_angle)?;
        non_negative("collapse of the creases", collapse)?;
        length_scale.map_or(Ok(()), |length| positive("length scale of the creases [m]", length))?;
        let bending = assembly.model.film.map_or(0.0, |film| film.youngs_modulus * film.thickness.powi(3) / 12.0);
        // L and the areas of facet C and of facet D in the reference.
        let sizes: Vec<(f64, [f64; 2])> = assembly
            .hinges
            .iter()
            .map(|hinge| {
                let [a, b, c, d] = hinge.nodes.map(|node| assembly.mesh.reference[node as usize]);
                let e = mesh::sub(b, a);
                let areas = [c, d].map(|apex| {
                    let normal = mesh::cross(e, mesh::sub(apex, a));
                    0.5 * mesh::dot(normal, normal).sqrt()
                });
                (mesh::dot(e, e).sqrt(), areas)
            })
            .collect();
        let (nodes, is_exchanged): (Vec<[u32; 4]>, Vec<bool>) =
            assembly.hinges.iter().map(|hinge| oriented(hinge.nodes, &assembly.numbering)).unzip();
        let elements = ElementSet::new(&nodes, assembly.masses.len());
        let packed = |padding: f64, value: &dyn Fn(usize) -> f64| {
            let values = merged((0..sizes.len()).map(value).collect());
            elements.pack(padding, |row| values[row])
        };
        let softening = |facet: usize| {
            packed(1.0, &|row| 4.0 * (collapse * sizes[row].1[facet ^ usize::from(is_exchanged[row])]).powi(2))
        };
        let sign = elements.pack(1.0, |row| assembly.model.creases.fold_signs[row]);
        let stiffness = packed(0.0, &|row| {
            let (length, areas) = sizes[row];
            let height = length_scale.unwrap_or((areas[0] + areas[1]) / length);
            let at_reference = 1.0 + collapse * collapse;
            stiffness * bending * length / height * (at_reference * at_reference)
        });
        let softening = [softening(0), softening(1)];
        let of_batch = |batch: usize| Parameters {
            sign: sign[batch],
            stiffness: stiffness[batch],
            softening: [softening[0][batch], softening[1][batch]],
        };
        Ok(Self {
            parameters: Coded::new((0..elements.batch_count()).map(of_batch)),
            sides: Sides::own(&elements),
            elements,
            contact_penalty,
            natural_angle,
            is_singular: collapse == 0.0,
            instructions: assembly.instructions,
        })
    }

    /// Facets and angles [rad] of a batch.
    fn facets(&self, x: Columns<'_>, batch: usize) -> (Facets, F64x8) {
        let facets = Facets::new(self.elements.read_any(x, batch));
        let angle = facets.angle(self.parameters[batch].sign, self.sides.least_angles()[batch]);
        (facets, angle)
    }

    /// u [J] and du/dtheta [N m] of creases of this stiffness, with its factors of the weights.
    #[inline(always)]
    fn potential<V: SimdF64>(&self, kappa: V, angle: V) -> (V, V) {
        let opening = angle - V::all(self.natural_angle);
        let inside = angle.min(V::zero()) + (angle - V::all(TAU)).max(V::zero());
        let overlap = V::all(self.contact_penalty - 1.0) * inside;
        (V::all(0.5) * kappa * (opening * opening + overlap * inside), kappa * (opening + overlap))
    }
}

/// Adds -dU/dx to the forces, in chunks of batches. The path from the positions of a batch to its forces is a long
/// chain of dependent operations, and the instruction window of a processor holds little more than one batch. Two
/// stages over a chunk, first angles, roots and divisions, then vectors, have shorter chains that overlap.
struct MomentKernel<'a> {
    creases: &'a Creases,
    tile: usize,
    positions: Columns<'a>,
    forces: ColumnsMut<'a>,
}

impl BatchKernel for MomentKernel<'_> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.creases.elements.pass::<KIND>(self.tile, self.positions.rows());
        let positions = pass.reader(self.positions);
        let mut sums = pass.adder(&mut self.forces);
        let parameters = self.creases.parameters.of(&pass);
        let least_angles = pass.of(self.creases.sides.least_angles());
        let zeros = [V::zero(); 2];
        let mut factors = [Factors { normal: zeros, in_plane: zeros, at_b: zeros }; CHUNK];
        for chunk in pass.chunks_of_batches() {
            for (batch, factors) in chunk.clone().zip(&mut factors) {
                let parameters = &parameters[batch];
                let facets = Facets::new(positions.read::<V>(batch));
                let angle = facets.angle(V::load(&parameters.sign), V::load(&least_angles[batch]));
                let (energy, moment) = self.creases.potential(V::load(&parameters.stiffness), angle);
                *factors = Factors::new(&facets, parameters, energy, moment);
            }
            for (batch, factors) in chunk.zip(&factors) {
                let forces = factors.forces(&Facets::new(positions.read::<V>(batch)));
                sums.add(batch, forces);
            }
        }
        V::zero()
    }
}

/// The sum of U.
struct EnergyKernel<'a> {
    creases: &'a Creases,
    tile: usize,
    positions: Columns<'a>,
}

impl BatchKernel for EnergyKernel<'_> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.creases.elements.pass::<KIND>(self.tile, self.positions.rows());
        let positions = pass.reader(self.positions);
        let parameters = self.creases.parameters.of(&pass);
        let least_angles = pass.of(self.creases.sides.least_angles());
        let mut energy = V::zero();
        for batch in 0..pass.len() {
            let Parameters { sign, stiffness, softening: [soft_c, soft_d] } = &parameters[batch];
            let facets = Facets::new(positions.read::<V>(batch));
            let (square_c, square_d) = (dot(facets.normal_c, facets.normal_c), dot(facets.normal_d, facets.normal_d));
            let weight = square_c / (square_c + V::load(soft_c)) * square_d / (square_d + V::load(soft_d));
            let angle = facets.angle(V::load(sign), V::load(&least_angles[batch]));
            energy += weight * self.creases.potential(V::load(stiffness), angle).0;
        }
        energy
    }
}

impl Law for Creases {
    fn properties(&self) -> Properties {
        Properties {
            name: "creases",
            work_class: WorkClass::Conservative,
            depends_on_velocity: false,
            is_internal: true,
        }
    }

    fn kernels(&self) -> Kernels {
        Kernels::of_elements()
    }

    fn reach(&self, tile: usize) -> usize {
        self.elements.reach(tile)
    }

    fn add_to_tile(&mut self, tile: usize, at: Instant<'_>, forces: &mut NodeVectors) -> f64 {
        let (positions, forces) = (Columns::of(at.positions), ColumnsMut::of(forces));
        self.instructions.run_batches(MomentKernel { creases: self, tile, positions, forces })
    }

    fn energy(&self, at: Instant<'_>) -> f64 {
        let positions = Columns::of(at.positions);
        tiles(positions.rows())
            .map(|tile| self.instructions.run_batches(EnergyKernel { creases: self, tile, positions }))
            .sum()
    }

    fn linearisation(&self) -> Option<&dyn Linearisation> {
        Some(self)
    }

    fn inspection(&self) -> Option<&dyn Inspection> {
        Some(self)
    }

    fn history_dependent(&self) -> Option<&dyn HistoryDependent> {
        Some(self)
    }

    fn history_dependent_mut(&mut self) -> Option<&mut dyn HistoryDependent> {
        Some(self)
    }

    fn remedy(&self) -> &'static str {
        if self.is_singular {
            "without collapse the force grows without bound as a facet collapses: set collapse to 0.05, or use a \
             smaller dt"
        } else {
            "use a smaller dt, a smaller crease stiffness or contact penalty"
        }
    }
}

impl Linearisation for Creases {
    /// The stiffness in contact, kappa max(1, gamma) g g^T, with g the gradient of the angle; the part of each facet
    /// has its weight.
    fn add_stiffness_product(&self, at: Instant<'_>, p: &NodeVectors, out: &mut NodeVectors) {
        let (positions, p) = (Columns::of(at.positions), Columns::of(p));
        for tile in tiles(p.rows()) {
            let out = ColumnsMut::of(out);
            self.instructions.run_batches(StiffnessKernel { creases: self, tile, positions, p, out });
        }
    }

    fn visit_couplings(&self, visit: &mut dyn FnMut(&[u32])) {
        self.elements.each().for_each(|(.., nodes)| visit(&nodes));
    }

    fn add_jacobian(&self, at: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        self.jacobian(at, jacobian);
    }
}

impl Inspection for Creases {
    fn crease_angles(&self, at: Instant<'_>) -> Option<Vec<f64>> {
        let x = Columns::of(at.positions);
        let angles = (0..self.elements.batch_count()).map(|batch| self.facets(x, batch).1);
        Some(self.elements.unpack(angles))
    }

    fn lanes(&self) -> [usize; 2] {
        self.elements.lanes()
    }

    fn contiguous_share(&self) -> Option<f64> {
        Some(self.elements.contiguous_share())
    }
}
