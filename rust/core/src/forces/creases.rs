//! Crease stiffness, and contact of the two wings of a crease.
//!
//! Wings ABC and ABD share the crease AB. With L = |AB| and H the mean wing height of the reference mesh (or a length
//! that the user sets), J = h^3/12, and the crease angle theta (pi flat, 0 shut, negative where the wings interpenetrate),
//!
//!     kappa = beta E J L / H   [N m/rad]
//!     u     = kappa/2 (theta - theta0)^2 + (gamma - 1) kappa/2 min(theta, 0)^2   [J]
//!     U     = w_C w_D u,   w = A^2 / (A^2 + (c A0)^2)
//!
//! and every force is -dU/dx, so that no energy is made and no rigid motion is resisted. A is a wing's current and A0
//! its reference area: without the weights w the force on an apex, u'/height, is singular as a wing collapses, and a
//! run gains energy there. Written with |AB|/(4 A^2 + 4 (c A0)^2) the weighted force has no singularity at all.
//!
//! theta comes from atan2 of the wings' normals, sign included. Its cut lies at -pi/2 (or 3 pi/2), as far from shut
//! as from flat. Which way a crease folds (valley +1, mountain -1) is the fold pattern's, never the geometry's.
//! Source: Okuizumi et al. (2012), eqs. (3) and (4), whose forces these are where w = 1; the weights are ours.

mod tangent;

use std::f64::consts::{FRAC_PI_2, TAU};

use super::{Law, Readings};
use crate::columns::{Columns, ColumnsMut};
use crate::error::Result;
use crate::lanes::{Lanes, Point, cross, dot, negate, scale, sub, sum};
use crate::layout::Elements;
use crate::mesh;
use crate::model::{Assembly, finite, non_negative};
use crate::slopes::Slopes;
use crate::state::{Instant, Vectors};
use crate::width::{Sweep, Width};

/// Parameters of the creases.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CreaseParameters {
    /// beta, the crease stiffness parameter.
    pub stiffness: f64,
    /// gamma, the contact penalty factor.
    pub contact_penalty: f64,
    /// theta0, the natural crease angle \[rad\].
    pub natural_angle: f64,
    /// H; `None`: the mean height of the two wings of each crease \[m\].
    pub length_scale: Option<f64>,
    /// c: the share of its reference area at which a wing counts as half collapsed.
    pub collapse: f64,
}

/// The law: all creases, eight to a group. The nodes of an element are A, B, C, D.
pub(super) struct Creases {
    elements: Elements<4>,
    /// +1 valley, -1 mountain.
    sign: Vec<Lanes>,
    /// kappa [N m/rad].
    stiffness: Vec<Lanes>,
    /// 4 (c A0)^2 of wing C and of wing D [m4].
    softening: [Vec<Lanes>; 2],
    contact_penalty: Lanes,
    natural_angle: Lanes,
    /// Whether c is zero, so that the force is singular as a wing collapses.
    is_singular: bool,
    width: Width,
}

/// The creases of a group with their wings where they are now.
struct Wings {
    /// B - A, C - A, D - A [m].
    e: Point,
    c: Point,
    d: Point,
    /// Twice the vector areas of the wings [m2], and the squares of their lengths [m4].
    normal_c: Point,
    normal_d: Point,
    square_c: Lanes,
    square_d: Lanes,
    /// |AB| [m] and its square.
    length: Lanes,
    length_square: Lanes,
    /// Crease angle [rad].
    angle: Lanes,
}

impl Wings {
    #[inline(always)]
    fn new([a, b, c, d]: [Point; 4], sign: Lanes) -> Self {
        let (e, c, d) = (sub(b, a), sub(c, a), sub(d, a));
        let (normal_c, normal_d) = (cross(e, c), cross(d, e));
        let length_square = dot(e, e).max(Lanes::all(f64::MIN_POSITIVE));
        let length = length_square.sqrt();
        let sine = sign * dot(cross(normal_d, normal_c), e) / length;
        let angle = Lanes::atan2(sine, -dot(normal_c, normal_d));
        let angle = angle.below(Lanes::all(-FRAC_PI_2), angle + Lanes::all(TAU), angle);
        let (square_c, square_d) = (dot(normal_c, normal_c), dot(normal_d, normal_d));
        Self { e, c, d, normal_c, normal_d, square_c, square_d, length, length_square, angle }
    }

    /// Vectors at A, B that balance `c` at C and `d` at D, without force or torque left.
    #[inline(always)]
    fn balance(&self, c: Point, d: Point) -> (Point, Point) {
        let (tc, td) = (dot(self.c, self.e) / self.length_square, dot(self.d, self.e) / self.length_square);
        let one = Lanes::all(1.0);
        (negate(sum(scale(one - tc, c), scale(one - td, d))), negate(sum(scale(tc, c), scale(td, d))))
    }
}

impl Creases {
    pub(super) fn new(parameters: CreaseParameters, assembly: &Assembly) -> Result<Self> {
        let CreaseParameters { stiffness, contact_penalty, natural_angle, length_scale, collapse } = parameters;
        non_negative("stiffness of the creases", stiffness)?;
        non_negative("contact penalty of the creases", contact_penalty)?;
        finite("natural angle of the creases [rad]", natural_angle)?;
        non_negative("collapse of the creases", collapse)?;
        let bending = assembly.model.film.map_or(0.0, |film| film.youngs_modulus * film.thickness.powi(3) / 12.0);
        // L and the areas of wing C and of wing D in the reference.
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
        // Taken from its lower node: turned by half a turn, a crease is the same crease.
        let nodes = assembly.hinges.iter().map(|hinge| {
            let [a, b, c, d] = assembly.layout.inward(hinge.nodes);
            if a < b { [a, b, c, d] } else { [b, a, d, c] }
        });
        let nodes: Vec<[u32; 4]> = nodes.collect();
        let elements = Elements::new(&nodes, assembly.masses.len());
        let is_turned =
            |row: usize| usize::from(nodes[row][0] != assembly.layout.inward(assembly.hinges[row].nodes)[0]);
        let softening =
            |wing: usize| elements.pack(1.0, |row| 4.0 * (collapse * sizes[row].1[wing ^ is_turned(row)]).powi(2));
        Ok(Self {
            sign: elements.pack(1.0, |row| assembly.model.fold_signs[row]),
            stiffness: elements.pack(0.0, |row| {
                let (length, areas) = sizes[row];
                let height = length_scale.unwrap_or((areas[0] + areas[1]) / length);
                stiffness * bending * length / height
            }),
            softening: [softening(0), softening(1)],
            elements,
            contact_penalty: Lanes::all(contact_penalty),
            natural_angle: Lanes::all(natural_angle),
            is_singular: collapse == 0.0,
            width: assembly.width,
        })
    }

    fn wings(&self, x: Columns<'_>, group: usize) -> Wings {
        Wings::new(self.elements.read_any(x, group), self.sign[group])
    }

    /// u [J] and du/dtheta [N m] of a group.
    #[inline(always)]
    fn potential(&self, group: usize, angle: Lanes) -> (Lanes, Lanes) {
        let opening = angle - self.natural_angle;
        let inside = angle.min(Lanes::ZERO);
        let overlap = (self.contact_penalty - Lanes::all(1.0)) * inside;
        let kappa = self.stiffness[group];
        (Lanes::all(0.5) * kappa * (opening * opening + overlap * inside), kappa * (opening + overlap))
    }
}

/// Adds -dU/dx to the forces.
struct Open<'a> {
    creases: &'a Creases,
    positions: Columns<'a>,
    forces: ColumnsMut<'a>,
}

impl Open<'_> {
    #[inline(always)]
    fn part<const LOOSE: bool>(&mut self) {
        let Creases { elements, sign, softening: [soft_c, soft_d], .. } = self.creases;
        for group in elements.groups::<LOOSE>() {
            let wings = Wings::new(elements.read::<LOOSE>(self.positions, group), sign[group]);
            let (energy, moment) = self.creases.potential(group, wings.angle);
            // 1/(q + s) of each wing, with q the square of its normal: w = q/(q + s).
            let share_c = Lanes::all(1.0) / (wings.square_c + soft_c[group]);
            let share_d = Lanes::all(1.0) / (wings.square_d + soft_d[group]);
            let (weight_c, weight_d) = (wings.square_c * share_c, wings.square_d * share_d);
            // theta = pi - sign * fold angle, so the force -M dtheta/dx is +sign M d(fold angle)/dx; and the gradient
            // of the fold angle at C, times w_C, is |AB| n_C / (q_C + s_C).
            let turn = sign[group] * moment * wings.length;
            let mut at_c = scale(turn * weight_d * share_c, wings.normal_c);
            let mut at_d = scale(turn * weight_c * share_d, wings.normal_d);
            let (mut at_a, mut at_b) = wings.balance(at_c, at_d);
            // -u dw/dx: dw/dq = s/(q + s)^2 and dq/dP = 2 n x (opposite side, taken around the wing).
            let push = Lanes::all(-2.0) * energy;
            let push_c = scale(push * weight_d * soft_c[group] * share_c * share_c, wings.normal_c);
            let push_d = scale(push * weight_c * soft_d[group] * share_d * share_d, wings.normal_d);
            at_c = sum(at_c, cross(push_c, wings.e));
            at_b = sum(at_b, cross(wings.c, push_c));
            at_a = sum(at_a, cross(push_c, sub(wings.c, wings.e)));
            at_d = sum(at_d, cross(wings.e, push_d));
            at_b = sum(at_b, cross(push_d, wings.d));
            at_a = sum(at_a, cross(push_d, sub(wings.e, wings.d)));
            elements.add::<LOOSE>(&mut self.forces, group, [at_a, at_b, at_c, at_d]);
        }
    }
}

impl Sweep for Open<'_> {
    type Output = ();

    #[inline(always)]
    fn sweep(mut self) {
        self.part::<false>();
        self.part::<true>();
    }
}

impl Law for Creases {
    fn name(&self) -> &'static str {
        "creases"
    }

    fn is_conservative(&self) -> bool {
        true
    }

    fn add_forces(&self, at: Instant<'_>, forces: &mut Vectors) -> f64 {
        self.width.run(Open { creases: self, positions: Columns::of(at.positions), forces: ColumnsMut::of(forces) });
        0.0
    }

    fn energy(&self, at: Instant<'_>) -> f64 {
        let x = Columns::of(at.positions);
        let energies = (0..self.elements.group_count()).map(|group| {
            let wings = self.wings(x, group);
            let weight = wings.square_c / (wings.square_c + self.softening[0][group]) * wings.square_d
                / (wings.square_d + self.softening[1][group]);
            (weight * self.potential(group, wings.angle).0).sum()
        });
        energies.sum()
    }

    /// kappa max(1, gamma) g g^T, with g the gradient of the angle, each wing's part times its weight: the stiffness in contact.
    fn add_stiffness_product(&self, at: Instant<'_>, p: &Vectors, out: &mut Vectors) {
        let (x, p) = (Columns::of(at.positions), Columns::of(p));
        let mut out = ColumnsMut::of(out);
        for group in 0..self.elements.group_count() {
            let wings = self.wings(x, group);
            let at_c = scale(wings.length / (wings.square_c + self.softening[0][group]), wings.normal_c);
            let at_d = scale(wings.length / (wings.square_d + self.softening[1][group]), wings.normal_d);
            let (at_a, at_b) = wings.balance(at_c, at_d);
            let [a, b, c, d] = self.elements.read_any(p, group);
            let turn = dot(at_a, a) + dot(at_b, b) + dot(at_c, c) + dot(at_d, d);
            let moment = self.stiffness[group] * self.contact_penalty.max(Lanes::all(1.0)) * turn;
            let product = [scale(moment, at_a), scale(moment, at_b), scale(moment, at_c), scale(moment, at_d)];
            self.elements.add_any(&mut out, group, product);
        }
    }

    fn readings(&self, at: Instant<'_>) -> Readings {
        let x = Columns::of(at.positions);
        let angles = (0..self.elements.group_count()).map(|group| self.wings(x, group).angle);
        Readings::Creases { angle: self.elements.unpack(angles) }
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
        if self.is_singular {
            "without collapse the force grows without bound as a wing collapses: set collapse to 0.05, or use a smaller dt"
        } else {
            "use a smaller dt, a smaller crease stiffness or contact penalty"
        }
    }
}
