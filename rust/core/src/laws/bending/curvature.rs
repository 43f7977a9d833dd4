//! Bending by the curvature of each triangle, from the fold angles of its three edges.
//!
//! With g = s |e| / A of each edge, and c the cosine of the angle between two edges,
//!
//!     U = sum of M_ii a_i^2 / 2 + sum over pairs of edges of M_ij b_i b_j,   M_ij = A D g_i g_j [(1 - nu) c_ij^2 + nu]
//!
//! with the weighted fold angles a = w_C w_D phi, and b = w_C w_D sin phi, which is a of small angles. At a shut edge
//! phi jumps from pi to -pi, where b is 0: the energy goes on also where other edges are bent. s is 1/2; 1 where the
//! facet on the other side is rigid; 0 on the boundary, along creases, and along edges folded at the start, where no
//! moment acts.

use self::element::Element;
use super::edges::{InnerEdge, inner_edges};
use super::{BendingParameters, PROPERTIES, remedy};
use crate::arrays::blocks::tiles;
use crate::arrays::columns::{Columns, ColumnsMut};
use crate::arrays::jacobian::{JacobianBlocks, at, of_differences};
use crate::arrays::state::NodeVectors;
use crate::assembly::Assembly;
use crate::elements::hinge::{Facets, HingeForces, turned_back};
use crate::elements::hinge_tangent::WeightedAngle;
use crate::error::Result;
use crate::laws::{Inspection, Instant, Kernels, Law, Linearisation, Properties};
use crate::layout::{Coded, ElementSet, Entry};
use crate::simd::dispatch::{BatchKernel, InstructionSet};
use crate::simd::lanes::{F64x8, LANES, SimdF64, Vec3, dot, scale, sum};

mod element;

/// Places of M_ij among the six distinct ones.
const PLACES: [[usize; 3]; 3] = [[0, 3, 4], [3, 1, 5], [4, 5, 2]];

/// The law. The nodes of an element are the corners of a triangle, the one with the lowest number first, and the apexes
/// of the triangles beyond the edges opposite to these; where there is none, the corner itself.
pub(super) struct CurvatureBending {
    elements: ElementSet<6>,
    parameters: Coded<Parameters>,
    /// Sine and cosine of the natural fold angle at each edge, by batch; `None` where all are naturally flat.
    natural: Option<Vec<[[F64x8; 2]; 3]>>,
    is_singular: bool,
    instructions: InstructionSet,
}

/// Parameters of a batch.
#[derive(Debug, Clone, Copy)]
struct Parameters {
    /// (1 + c^2)^4 M_ij, see `PLACES` \[N m\].
    stiffness: [F64x8; 6],
    /// 4 (c A0)^2 of the triangle, and of those beyond its edges \[m4\].
    softening: [F64x8; 4],
}

impl Entry for Parameters {
    type Key = [[u64; LANES]; 10];

    fn key(&self) -> Self::Key {
        std::array::from_fn(|k| if k < 6 { self.stiffness[k] } else { self.softening[k - 6] }.key())
    }
}

impl CurvatureBending {
    /// # Errors
    /// `CurvatureBeyondMesh`.
    pub(super) fn new(parameters: BendingParameters, assembly: &Assembly) -> Result<Self> {
        let BendingParameters { fold_limit, collapse, .. } = parameters;
        let mut edges: Vec<Option<InnerEdge>> = vec![None; assembly.mesh.edges.len()];
        for edge in inner_edges(assembly, fold_limit) {
            edges[edge.hinge.edge as usize] = Some(edge);
        }
        let element = |triangle| Element::new(triangle, parameters, assembly, &edges).transpose();
        let all = (0..assembly.mesh.triangles.len()).filter_map(element).collect::<Result<Vec<Element>>>()?;
        let nodes: Vec<[u32; 6]> = all.iter().map(|element| element.nodes).collect();
        let elements = ElementSet::new(&nodes, assembly.masses.len());
        let stiffness: [_; 6] = std::array::from_fn(|k| elements.pack(0.0, |row| all[row].stiffness[k]));
        let softening: [_; 4] = std::array::from_fn(|k| elements.pack(1.0, |row| all[row].softening[k]));
        let of_batch = |batch: usize| Parameters {
            stiffness: stiffness.each_ref().map(|values| values[batch]),
            softening: softening.each_ref().map(|values| values[batch]),
        };
        let is_curled = all.iter().any(|element| element.natural != [0.0; 3]);
        let natural = is_curled.then(|| {
            let sines: [_; 3] = std::array::from_fn(|k| elements.pack(0.0, |row| all[row].natural[k].sin()));
            let cosines: [_; 3] = std::array::from_fn(|k| elements.pack(1.0, |row| all[row].natural[k].cos()));
            let of_batch = |batch: usize| std::array::from_fn(|k| [sines[k][batch], cosines[k][batch]]);
            (0..elements.batch_count()).map(of_batch).collect()
        });
        Ok(Self {
            parameters: Coded::new((0..elements.batch_count()).map(of_batch)),
            natural,
            elements,
            is_singular: collapse == 0.0,
            instructions: assembly.instructions,
        })
    }

    /// The fold angle of hinge k of the batch at this place, less its natural one, and the sine and the cosine of it.
    #[inline(always)]
    fn bend<V: SimdF64>(&self, place: usize, k: usize, facets: &Facets<V>) -> (V, [V; 2]) {
        match &self.natural {
            None => (facets.fold_angle(), facets.fold_direction()),
            Some(natural) => {
                let natural = [V::load(&natural[place][k][0]), V::load(&natural[place][k][1])];
                (facets.fold_beyond(natural), turned_back(facets.fold_direction(), natural))
            }
        }
    }
}

/// The corners of hinge k of an element as A, B, C, D.
const CORNERS: [[usize; 4]; 3] = [[1, 2, 0, 3], [2, 0, 1, 4], [0, 1, 2, 5]];

/// The vectors of hinge k.
#[inline(always)]
fn of_hinge<V: SimdF64>(vectors: &[Vec3<V>; 6], k: usize) -> [Vec3<V>; 4] {
    let [a, b, c, d] = CORNERS[k];
    [vectors[a], vectors[b], vectors[c], vectors[d]]
}

/// Adds the vectors of hinge k.
#[inline(always)]
fn add_to<V: SimdF64>(sums: &mut [Vec3<V>; 6], k: usize, vectors: [Vec3<V>; 4]) {
    for (place, corner) in CORNERS[k].into_iter().enumerate() {
        sums[corner] = sum(sums[corner], vectors[place]);
    }
}

/// The triangles of a batch: per edge its fold angle, the sine and the cosine of it, w_C w_D, dU/da and dU/db.
struct Bent<V> {
    angles: [V; 3],
    sines: [V; 3],
    cosines: [V; 3],
    weights: [V; 3],
    own: [V; 3],
    crossed: [V; 3],
}

impl<V: SimdF64> Bent<V> {
    #[inline(always)]
    fn new(bending: &CurvatureBending, place: usize, points: &[Vec3<V>; 6], parameters: &Parameters) -> Self {
        let zeros = [V::zero(); 3];
        let mut bent = Self { angles: zeros, sines: zeros, cosines: zeros, weights: zeros, own: zeros, crossed: zeros };
        for k in 0..3 {
            let facets = Facets::new(of_hinge(points, k));
            (bent.angles[k], [bent.sines[k], bent.cosines[k]]) = bending.bend(place, k, &facets);
            bent.weights[k] = facets.weight(parameters.of_facets(k));
            bent.own[k] = V::load(&parameters.stiffness[k]) * bent.weights[k] * bent.angles[k];
        }
        let [a, b, c] = bent.sines;
        let [of_a, of_b, of_c] = bent.weights;
        bent.crossed = parameters.product_of_others([of_a * a, of_b * b, of_c * c]);
        bent
    }
}

impl<V: SimdF64> Bent<V> {
    /// u of edge k, and du/dphi.
    #[inline(always)]
    fn potential(&self, k: usize) -> [V; 2] {
        let (own, crossed) = (self.own[k], self.crossed[k]);
        [self.angles[k] * own + self.sines[k] * crossed, own + self.cosines[k] * crossed]
    }
}

impl Parameters {
    /// 4 (c A0)^2 of both facets of hinge k.
    #[inline(always)]
    fn of_facets<V: SimdF64>(&self, k: usize) -> [V; 2] {
        [V::load(&self.softening[0]), V::load(&self.softening[k + 1])]
    }

    /// M b without the diagonal of M.
    #[inline(always)]
    fn product_of_others<V: SimdF64>(&self, [a, b, c]: [V; 3]) -> [V; 3] {
        let [ab, ac, bc] = [V::load(&self.stiffness[3]), V::load(&self.stiffness[4]), V::load(&self.stiffness[5])];
        [ab * b + ac * c, ab * a + bc * c, ac * a + bc * b]
    }
}

/// Adds -dU/dx of the triangles of one tile to the forces.
struct MomentKernel<'a> {
    bending: &'a CurvatureBending,
    tile: usize,
    positions: Columns<'a>,
    forces: ColumnsMut<'a>,
}

impl BatchKernel for MomentKernel<'_> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.bending.elements.pass::<KIND>(self.tile, self.positions.rows());
        let positions = pass.reader(self.positions);
        let mut sums = pass.adder(&mut self.forces);
        let parameters = self.bending.parameters.of(&pass);
        for batch in 0..pass.len() {
            let (points, parameters) = (positions.read::<V>(batch), &parameters[batch]);
            let bent = Bent::new(self.bending, pass.place(batch), &points, parameters);
            let mut forces = [[V::zero(); 3]; 6];
            for k in 0..3 {
                let (facets, [energy, slope]) = (Facets::new(of_hinge(&points, k)), bent.potential(k));
                let of_edge = HingeForces::new(&facets, parameters.of_facets(k), energy, -slope);
                add_to(&mut forces, k, of_edge.on_nodes(&facets));
            }
            sums.add(batch, forces);
        }
        V::zero()
    }
}

/// The sum of U.
struct EnergyKernel<'a> {
    bending: &'a CurvatureBending,
    tile: usize,
    positions: Columns<'a>,
}

impl BatchKernel for EnergyKernel<'_> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.bending.elements.pass::<KIND>(self.tile, self.positions.rows());
        let positions = pass.reader(self.positions);
        let parameters = self.bending.parameters.of(&pass);
        let mut energy = V::zero();
        for batch in 0..pass.len() {
            let bent = Bent::new(self.bending, pass.place(batch), &positions.read::<V>(batch), &parameters[batch]);
            for k in 0..3 {
                energy += V::all(0.5) * bent.weights[k] * bent.potential(k)[0];
            }
        }
        energy
    }
}

/// Adds K p of the triangles of one tile.
struct StiffnessKernel<'a> {
    bending: &'a CurvatureBending,
    tile: usize,
    positions: Columns<'a>,
    p: Columns<'a>,
    out: ColumnsMut<'a>,
}

impl BatchKernel for StiffnessKernel<'_> {
    #[inline(always)]
    fn sweep_kind<V: SimdF64, const KIND: usize>(&mut self) -> V {
        let pass = self.bending.elements.pass::<KIND>(self.tile, self.positions.rows());
        let (positions, p) = (pass.reader(self.positions), pass.reader(self.p));
        let mut sums = pass.adder(&mut self.out);
        let parameters = self.bending.parameters.of(&pass);
        for batch in 0..pass.len() {
            let (points, p, parameters) = (positions.read::<V>(batch), p.read::<V>(batch), &parameters[batch]);
            let (mut rotations, mut cosines) = ([V::zero(); 3], [V::zero(); 3]);
            for k in 0..3 {
                let facets = Facets::new(of_hinge(&points, k));
                let [at_a, at_b, at_c, at_d] = facets.weighted_gradients(parameters.of_facets(k));
                (_, [_, cosines[k]]) = self.bending.bend(pass.place(batch), k, &facets);
                let [a, b, c, d] = of_hinge(&p, k);
                rotations[k] = dot(at_a, a) + dot(at_b, b) + dot(at_c, c) + dot(at_d, d);
            }
            let ([a, b, c], [of_a, of_b, of_c]) = (rotations, cosines);
            let others = parameters.product_of_others([of_a * a, of_b * b, of_c * c]);
            let mut product = [[V::zero(); 3]; 6];
            for k in 0..3 {
                let [at_a, at_b, at_c, at_d] =
                    Facets::new(of_hinge(&points, k)).weighted_gradients(parameters.of_facets(k));
                let m = V::load(&parameters.stiffness[k]) * rotations[k] + cosines[k] * others[k];
                add_to(&mut product, k, [scale(m, at_a), scale(m, at_b), scale(m, at_c), scale(m, at_d)]);
            }
            sums.add(batch, product);
        }
        V::zero()
    }
}

impl Law for CurvatureBending {
    fn properties(&self) -> Properties {
        PROPERTIES
    }

    fn kernels(&self) -> Kernels {
        Kernels::of_elements()
    }

    fn reach(&self, tile: usize) -> usize {
        self.elements.reach(tile)
    }

    fn add_to_tile(&mut self, tile: usize, at: Instant<'_>, forces: &mut NodeVectors) -> f64 {
        let (positions, forces) = (Columns::of(at.positions), ColumnsMut::of(forces));
        self.instructions.run_batches(MomentKernel { bending: self, tile, positions, forces })
    }

    fn energy(&self, at: Instant<'_>) -> f64 {
        let positions = Columns::of(at.positions);
        let of_tile = |tile| self.instructions.run_batches(EnergyKernel { bending: self, tile, positions });
        tiles(positions.rows()).map(of_tile).sum()
    }

    fn linearisation(&self) -> Option<&dyn Linearisation> {
        Some(self)
    }

    fn inspection(&self) -> Option<&dyn Inspection> {
        Some(self)
    }

    fn remedy(&self) -> &'static str {
        remedy(self.is_singular)
    }
}

impl Linearisation for CurvatureBending {
    /// The sum of M_ij g_i g_j^T, with g the gradients of the angles, of the sines where i is not j.
    fn add_stiffness_product(&self, at: Instant<'_>, p: &NodeVectors, out: &mut NodeVectors) {
        let (positions, p) = (Columns::of(at.positions), Columns::of(p));
        for tile in tiles(p.rows()) {
            let out = ColumnsMut::of(out);
            self.instructions.run_batches(StiffnessKernel { bending: self, tile, positions, p, out });
        }
    }

    fn visit_couplings(&self, visit: &mut dyn FnMut(&[u32])) {
        self.elements.each().for_each(|(.., nodes)| visit(&nodes));
    }

    fn add_jacobian(&self, instant: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        let x = Columns::of(instant.positions);
        for (batch, lane, nodes) in self.elements.each() {
            let Parameters { stiffness, softening } = self.parameters[batch];
            let bent = Bent::<F64x8>::new(self, batch, &self.elements.read_any(x, batch), &self.parameters[batch]);
            let of_hinge = |k: usize| {
                let nodes = CORNERS[k].map(|corner| nodes[corner]);
                let points = nodes.map(|node| at(instant.positions, node));
                let angle = WeightedAngle::new(points, [softening[0].0[lane], softening[k + 1].0[lane]]);
                let [phi, sine, cosine] = [bent.angles[k], bent.sines[k], bent.cosines[k]].map(|values| values.0[lane]);
                (nodes, sine, angle.gradients(phi, 1.0), angle.gradients(sine, cosine), angle)
            };
            let hinges = [of_hinge(0), of_hinge(1), of_hinge(2)];
            for (i, (nodes, sine, own, of_sine, angle)) in hinges.iter().enumerate() {
                let [energy, slope] = bent.potential(i).map(|values| values.0[lane]);
                let hessian = angle.hessian(energy, slope, -sine * bent.crossed[i].0[lane]);
                of_differences(*nodes, &hessian, |on, of, block| jacobian.by_position(on, of, block));
                for (j, (others, _, _, of_other_sine, _)) in hinges.iter().enumerate() {
                    let m = stiffness[PLACES[i][j]].0[lane];
                    let [lefts, rights] = if i == j { [own; 2] } else { [of_sine, of_other_sine] };
                    for (on, left) in nodes.iter().zip(lefts) {
                        for (of, right) in others.iter().zip(rights) {
                            jacobian.by_position(*on, *of, &(left * right.transpose() * -m));
                        }
                    }
                }
            }
        }
    }
}

impl Inspection for CurvatureBending {
    fn lanes(&self) -> [usize; 2] {
        self.elements.lanes()
    }

    fn contiguous_share(&self) -> Option<f64> {
        Some(self.elements.contiguous_share())
    }
}
