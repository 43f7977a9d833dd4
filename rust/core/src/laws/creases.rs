//! Crease stiffness, and contact between the two facets of a crease.
//!
//! Facets ABC and ABD share the crease AB. With L = |AB|, H the mean height of the facets in the reference mesh (or a
//! given length), J = h^3/12, and the crease angle theta (pi flat, 0 shut, negative where the facets interpenetrate),
//!
//!     kappa = beta E J L / H   [N m/rad]
//!     u     = kappa/2 (theta - theta0)^2 + (gamma - 1) kappa/2 (min(theta, 0)^2 + max(theta - 2 pi, 0)^2)   [J]
//!     U     = w_C w_D u   with the weights of `elements::hinge`
//!
//! and every force is -dU/dx, so that the law conserves energy and does not resist rigid motion. A crease of unstrained
//! facets has w = 1, and exactly kappa.
//!
//! theta is a signed atan2 of the normals of the facets. The sign of the fold angle gives the side to which a crease
//! folds (valley +1, mountain -1). One that is folded against its side has more than pi, and is shut at 2 pi (`sides`).
//! Source: Okuizumi et al. (2012), eqs. (3) and (4), with these forces at w = 1; the weights, and the contact at 2 pi,
//! are added here.

mod sides;
mod tangent;

use std::f64::consts::{PI, TAU};

use serde::Deserialize;

use self::sides::Sides;
use super::{
    Context, HistoryDependent, Inspection, Instant, Kernels, Law, LawParameters, Linearisation, Properties, WorkClass,
};
use crate::arrays::columns::Columns;
use crate::arrays::jacobian::JacobianBlocks;
use crate::arrays::state::NodeVectors;
use crate::assembly::Assembly;
use crate::elements::hinge::Facets;
use crate::elements::hinge_set::{HingeParameters, HingePotential, HingeSet, HingeSize};
use crate::error::Result;
use crate::model::checks::{finite, non_negative, positive};
use crate::simd::dispatch::InstructionSet;
use crate::simd::lanes::{F64x8, SimdF64};

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
    /// With it theta0 of each crease is pi less this share of the angle by which the pattern folds it.
    pub fold_fraction: Option<f64>,
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
        let (natural_angle, fold_fraction) = (1.0, None);
        Self {
            stiffness: 10.0,
            contact_penalty: 100.0,
            natural_angle,
            fold_fraction,
            length_scale: None,
            collapse: 0.05,
        }
    }
}

/// The law: all creases.
struct Creases {
    hinges: HingeSet,
    sides: Sides,
    contact_penalty: f64,
    natural_angle: f64,
    /// gamma - 1 and theta0 of each crease, by batch; `None` where all have those of the law.
    own: Option<Vec<[F64x8; 2]>>,
    largest_penalty: f64,
    /// Whether c is zero; the force is then singular as a facet collapses.
    is_singular: bool,
    instructions: InstructionSet,
}

impl Creases {
    fn new(parameters: CreaseParameters, assembly: &Assembly) -> Result<Self> {
        let CreaseParameters { stiffness, contact_penalty, natural_angle, fold_fraction, length_scale, collapse } =
            parameters;
        non_negative("stiffness of the creases", stiffness)?;
        non_negative("contact penalty of the creases", contact_penalty)?;
        finite("natural angle of the creases [rad]", natural_angle)?;
        fold_fraction.map_or(Ok(()), |fraction| finite("fold fraction of the creases", fraction))?;
        non_negative("collapse of the creases", collapse)?;
        length_scale.map_or(Ok(()), |length| positive("length scale of the creases [m]", length))?;
        let creases = &assembly.model.creases;
        let bending = |row: usize| {
            let of_facet = |&facet: &u32| {
                let film = assembly.film.as_ref().map(|film| film.of(facet as usize).film);
                film.map_or(0.0, |film| film.youngs_modulus * film.thickness.powi(3) / 12.0)
            };
            let [c, d] = assembly.hinges[row].triangles.each_ref().map(of_facet);
            if c == d { c } else { 0.5 * (c + d) }
        };
        let kappa = |row: usize, HingeSize { length, areas }: HingeSize| {
            let height = length_scale.unwrap_or((areas[0] + areas[1]) / length);
            creases.own(row).stiffness.unwrap_or(stiffness) * bending(row) * length / height
        };
        let hinges = HingeSet::new(assembly, &assembly.hinges, collapse, |row| creases.fold_signs[row], kappa);
        let penalty = |row: usize| creases.own(row).contact_penalty.unwrap_or(contact_penalty);
        let natural = |row: usize| {
            let of_pattern = |fraction: f64| PI - fraction * creases.fold_angle(row);
            creases.own(row).natural_angle.unwrap_or(fold_fraction.map_or(natural_angle, of_pattern))
        };
        let own = (fold_fraction.is_some() || !creases.own.is_empty()).then(|| {
            let excesses = hinges.elements.pack(0.0, |row| penalty(row) - 1.0).into_iter();
            excesses.zip(hinges.elements.pack(natural_angle, natural)).map(|(excess, angle)| [excess, angle]).collect()
        });
        Ok(Self {
            sides: Sides::own(&hinges.elements),
            hinges,
            contact_penalty,
            natural_angle,
            own,
            largest_penalty: (0..assembly.hinges.len()).map(penalty).fold(1.0, f64::max),
            is_singular: collapse == 0.0,
            instructions: assembly.instructions,
        })
    }

    /// Facets and angles [rad] of a batch.
    fn facets(&self, x: Columns<'_>, batch: usize) -> (Facets, F64x8) {
        let facets = Facets::new(self.hinges.elements.read_any(x, batch));
        let angle = facets.angle(self.hinges.parameters[batch].sign, self.sides.least_angles()[batch]);
        (facets, angle)
    }

    /// gamma - 1 and theta0 of the batch at this place.
    #[inline(always)]
    fn own_or_common<V: SimdF64>(&self, place: usize) -> [V; 2] {
        match &self.own {
            None => [V::all(self.contact_penalty - 1.0), V::all(self.natural_angle)],
            Some(own) => [V::load(&own[place][0]), V::load(&own[place][1])],
        }
    }

    /// u [J] and du/dtheta [N m] of the batch at this place, of this stiffness, with its factors of the weights.
    #[inline(always)]
    fn potential<V: SimdF64>(&self, place: usize, kappa: V, angle: V) -> (V, V) {
        let [excess, natural_angle] = self.own_or_common::<V>(place);
        let opening = angle - natural_angle;
        let inside = angle.min(V::zero()) + (angle - V::all(TAU)).max(V::zero());
        let overlap = excess * inside;
        (V::all(0.5) * kappa * (opening * opening + overlap * inside), kappa * (opening + overlap))
    }
}

impl HingePotential for Creases {
    #[inline(always)]
    fn of_batch<V: SimdF64>(&self, place: usize, parameters: &HingeParameters, facets: &Facets<V>) -> (V, V) {
        let sign = V::load(&parameters.sign);
        let angle = facets.angle(sign, V::load(&self.sides.least_angles()[place]));
        let (energy, moment) = self.potential(place, V::load(&parameters.stiffness), angle);
        // theta = pi - sign phi.
        (energy, sign * moment)
    }

    /// In contact.
    fn largest_factor(&self) -> f64 {
        self.largest_penalty
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
        self.hinges.elements.reach(tile)
    }

    fn add_to_tile(&mut self, tile: usize, at: Instant<'_>, forces: &mut NodeVectors) -> f64 {
        self.hinges.add_to_tile(self, self.instructions, tile, at.positions, forces)
    }

    fn energy(&self, at: Instant<'_>) -> f64 {
        self.hinges.energy(self, self.instructions, at.positions)
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
        self.hinges.add_stiffness_product(self, self.instructions, at.positions, p, out);
    }

    fn visit_couplings(&self, visit: &mut dyn FnMut(&[u32])) {
        self.hinges.elements.each().for_each(|(.., nodes)| visit(&nodes));
    }

    fn add_jacobian(&self, at: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        self.jacobian(at, jacobian);
    }
}

impl Inspection for Creases {
    fn crease_angles(&self, at: Instant<'_>) -> Option<Vec<f64>> {
        let x = Columns::of(at.positions);
        let angles = (0..self.hinges.elements.batch_count()).map(|batch| self.facets(x, batch).1);
        Some(self.hinges.elements.unpack(angles))
    }

    fn lanes(&self) -> [usize; 2] {
        self.hinges.elements.lanes()
    }

    fn contiguous_share(&self) -> Option<f64> {
        Some(self.hinges.elements.contiguous_share())
    }
}
