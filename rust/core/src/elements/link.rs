//! Links between two nodes: the sides of the mesh, the pieces of tether.

use std::cell::OnceCell;
use std::sync::Arc;

use crate::assembly::Assembly;
use crate::layout::Elements;

/// The springs of a scene, arranged once for both laws.
#[derive(Default)]
pub(crate) struct SpringNetworks {
    film: OnceCell<Arc<Elements<2>>>,
    cords: OnceCell<Arc<Elements<2>>>,
}

impl SpringNetworks {
    /// The sides of the mesh.
    pub(crate) fn film(&self, assembly: &Assembly) -> Arc<Elements<2>> {
        self.film.get_or_init(|| arranged(assembly.mesh.edges.iter().copied(), assembly)).clone()
    }

    /// The pieces of tether.
    pub(crate) fn cords(&self, assembly: &Assembly) -> Arc<Elements<2>> {
        self.cords.get_or_init(|| arranged(assembly.model.cords.iter().map(|cord| cord.nodes), assembly)).clone()
    }
}

fn arranged(pairs: impl Iterator<Item = [u32; 2]>, assembly: &Assembly) -> Arc<Elements<2>> {
    Arc::new(Elements::new(&assembly.layout.pairs_to_internal(pairs), assembly.masses.len()))
}
