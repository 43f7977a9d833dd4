//! The constants of one triangle. With n_i the normals of its edges, a film of two moduli has in place of
//! (1 - nu) c_ij^2 + nu the product (1 - nu^2) n_i n_i : C/E : n_j n_j.

use super::PLACES;
use crate::assembly::Assembly;
use crate::elements::facet::from_lowest;
use crate::error::Result;
use crate::laws::bending::BendingParameters;
use crate::laws::bending::edges::{InnerEdge, natural_fold};
use crate::model::mesh;
use crate::model::orthotropy::symmetric;

/// One element.
pub(super) struct Element {
    /// Internal numbers.
    pub(super) nodes: [u32; 6],
    pub(super) stiffness: [f64; 6],
    pub(super) softening: [f64; 4],
    /// The natural fold angle at each edge, by the curvature of this triangle \[rad\].
    pub(super) natural: [f64; 3],
}

impl Element {
    /// `None` for a triangle that has no stiffness.
    ///
    /// # Errors
    /// `CurvatureBeyondMesh`.
    pub(super) fn new(
        triangle: usize,
        parameters: BendingParameters,
        assembly: &Assembly,
        edges: &[Option<InnerEdge>],
    ) -> Result<Option<Self>> {
        let Some(films) = &assembly.film else { return Ok(None) };
        let film = films.of(triangle);
        let BendingParameters { stiffness, collapse, .. } = parameters;
        let (nodes, own_edges) = (assembly.mesh.triangles[triangle], assembly.mesh.triangle_edges[triangle]);
        let points = nodes.map(|node| assembly.mesh.reference[node as usize]);
        let sides: [[f64; 3]; 3] = std::array::from_fn(|k| mesh::sub(points[(k + 2) % 3], points[(k + 1) % 3]));
        let lengths = assembly.mesh.side_lengths(triangle);
        let normal = mesh::cross(sides[2], sides[0]);
        let area = 0.5 * mesh::dot(normal, normal).sqrt();
        let (mut apexes, mut factors, mut areas, mut folds) = (nodes, [0.0; 3], [area; 3], [0.0; 3]);
        for k in 0..3 {
            let Some(edge) = edges[own_edges[k] as usize] else { continue };
            let own = usize::from(edge.hinge.nodes[3] == nodes[k]);
            apexes[k] = edge.hinge.nodes[3 - own];
            areas[k] = edge.size.areas[1 - own];
            if edge.bends[own] {
                factors[k] = if edge.bends[1 - own] { 0.5 } else { 1.0 } * lengths[k] / area;
                folds[k] = natural_fold(assembly, films, &edge, [triangle as u32; 2])?;
            }
        }
        if factors == [0.0; 3] {
            return Ok(None);
        }
        let weights = (1.0 + collapse * collapse).powi(4);
        let rigidity = stiffness * film.bending_stiffness() * area * weights;
        let (_, places) = from_lowest(assembly.numbering.to_internal(nodes));
        let own = |k: usize| (k + places) % 3;
        let mut stiffness = [0.0; 6];
        for (i, row) in PLACES.iter().enumerate() {
            for (j, &place) in row.iter().enumerate().skip(i) {
                let (i, j) = (own(i), own(j));
                let cosine = mesh::dot(sides[i], sides[j]) / (lengths[i] * lengths[j]);
                let (nu, square) = (film.film.poisson_ratio, if i == j { 1.0 } else { cosine * cosine });
                let share = films.orthotropy().map_or((1.0 - nu) * square + nu, |moduli| {
                    let normal = |k: usize| {
                        let [along, across] = moduli.components(sides[k]).map(|component| component / lengths[k]);
                        symmetric([-across, along], [-across, along])
                    };
                    (1.0 - nu * nu) * moduli.product(nu, normal(i), normal(j))
                });
                stiffness[place] = rigidity * factors[i] * factors[j] * share;
            }
        }
        let external = std::array::from_fn(|k| if k < 3 { nodes[own(k)] } else { apexes[own(k - 3)] });
        let soft = |area: f64| 4.0 * (collapse * area).powi(2);
        Ok(Some(Self {
            nodes: assembly.numbering.to_internal(external),
            stiffness,
            softening: std::array::from_fn(|k| soft(if k == 0 { area } else { areas[own(k - 1)] })),
            natural: std::array::from_fn(|k| folds[own(k)]),
        }))
    }
}
