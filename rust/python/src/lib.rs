//! The Python module `membrane_rs._core`: registration only.

mod arrays;
mod components;
mod crossings;
mod errors;
mod graph;
mod laws;
mod mesh;
mod past;
mod progress;
mod readings;
mod results;
mod simulation;

use membrane_core::simd::aligned::Aligned;
use pyo3::prelude::*;

#[global_allocator]
static ALLOCATOR: Aligned = Aligned;

/// The compiled core of membrane_rs; use it through the package's own classes.
#[pymodule]
mod _core {
    #[pymodule_export]
    use super::crossings::{Crossings, crossings};
    #[pymodule_export]
    use super::graph::{groups, shortest_paths};
    #[pymodule_export]
    use super::mesh::{edges, hinge_count, lumped_masses, rectangle_constants, rectangles, spring_constants};
    #[pymodule_export]
    use super::readings::{FilmStates, FilmStress, HubLoad, LinkReadings};
    #[pymodule_export]
    use super::results::{
        ContactStatistics, EnergyBalance, HubMotion, MethodFacts, NewtonStatistics, StepLimit, integrators,
    };
    #[pymodule_export]
    use super::simulation::Simulation;
}
