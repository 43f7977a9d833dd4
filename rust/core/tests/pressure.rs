//! Uniform pressure: forces on one triangle, closed surfaces, work by every method.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use std::ops::Range;

use common::{Dice, films, sheet, simulation_of};
use membrane_core::assembly::Assembly;
use membrane_core::integrators::METHODS;
use membrane_core::laws::{Instant, Kernels, Law, LawSpec, NodalLaw, PressureParameters, Properties, WorkClass};
use membrane_core::model::input::{Film, Model};
use membrane_core::simulation::{Settings, Simulation};

const FILM: Film = Film { youngs_modulus: 1e6, poisson_ratio: 0.3, density: 1000.0, thickness: 1e-4 };

fn pressure(pressure: f64) -> LawSpec {
    PressureParameters { pressure, ..Default::default() }.into()
}

/// A surface with these corners and triangles, and random displacements of `size`.
fn surface(points: &[[f64; 3]], triangles: &[[u32; 3]], size: f64) -> Model {
    let kicks = Dice(1).vectors(points.len(), size);
    let moved = points.iter().zip(kicks).map(|(p, k)| [0, 1, 2].map(|axis| p[axis] + k[axis]));
    Model {
        positions: moved.collect(),
        velocities: vec![[0.0; 3]; points.len()],
        extra_masses: vec![0.0; points.len()],
        reference: points.to_vec(),
        triangles: triangles.to_vec(),
        film: Some(FILM),
        ..Model::default()
    }
}

fn forces(model: Model, laws: &[LawSpec]) -> Vec<[f64; 3]> {
    let mut simulation = Simulation::new(model, laws, "rk4", Some(1e-9), Settings::default()).unwrap();
    simulation.forces(Some("pressure")).unwrap()
}

#[test]
fn a_triangle_bears_a_third_of_pressure_times_area_on_each_node_towards_its_normal() {
    let points = [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0]];
    // Counterclockwise seen from +z, from any first node.
    for triangle in [[0, 1, 2], [1, 2, 0], [2, 0, 1]] {
        for force in forces(surface(&points, &[triangle], 0.0), &[pressure(5.0)]) {
            assert_eq!(force, [0.0, 0.0, 5.0]);
        }
    }
    assert_eq!(forces(surface(&points, &[[0, 2, 1]], 0.0), &[pressure(5.0)])[0], [0.0, 0.0, -5.0]);
}

#[test]
fn the_total_force_and_torque_on_a_closed_surface_vanish() {
    let [e, o] = [1.0, 0.0];
    let octahedron = [[e, o, o], [-e, o, o], [o, e, o], [o, -e, o], [o, o, e], [o, o, -e]];
    let triangles = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    let model = surface(&octahedron, &triangles, 0.3);
    let found = forces(model.clone(), &[pressure(7.0)]);
    let size: f64 = found.iter().flatten().map(|f| f.abs()).sum();
    for axis in 0..3 {
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        let force: f64 = found.iter().map(|f| f[axis]).sum();
        let torque: f64 = model.positions.iter().zip(&found).map(|(p, f)| p[i] * f[j] - p[j] * f[i]).sum();
        assert!(force.abs() < 1e-14 * size && torque.abs() < 1e-14 * size, "{force:e} {torque:e} of {size:e}");
    }
    // Outward: positive work on an expansion.
    assert!(
        found.iter().zip(&model.positions).map(|(f, p)| f[0] * p[0] + f[1] * p[1] + f[2] * p[2]).sum::<f64>() > 0.0
    );
}

#[test]
fn its_work_is_external_and_closes_the_balance_at_the_order_of_each_method() {
    // A sheet accelerated by pressure, without buckling, so that the motion is smooth.
    let film = films().next().unwrap();
    let model = || {
        let mut model = sheet(4, 3, 0.01);
        model.positions.iter_mut().for_each(|p| *p = [1.01 * p[0], 1.01 * p[1], p[2]]);
        (model.cords, model.bridges) = (Vec::new(), Default::default());
        model
    };
    for method in METHODS {
        let residual = |steps: u64| {
            let dt = 4e-6 / steps as f64;
            let laws = [film.clone(), pressure(2000.0)];
            let mut simulation = Simulation::new(model(), &laws, method.name, Some(dt), Settings::default()).unwrap();
            simulation.step(steps).unwrap();
            assert!(simulation.ledger().work[1] > 0.0, "{}", method.name);
            simulation.ledger().error(&simulation.energy_terms()).abs()
        };
        let (coarse, fine) = (residual(50), residual(100));
        assert!(fine < 1e-3 && (fine < 0.35 * coarse || fine < 1e-9), "{}: {coarse:e} {fine:e}", method.name);
    }
}

/// A constant force along x on each node, whose work is missing in the balance: a law at fault.
struct Push;

impl Law for Push {
    fn properties(&self) -> Properties {
        let work_class = WorkClass::Conservative;
        Properties { name: "push", work_class, depends_on_velocity: false, is_internal: false }
    }

    fn kernels(&self) -> Kernels {
        Kernels::default()
    }

    fn nodal(&mut self) -> Option<&mut dyn NodalLaw> {
        Some(self)
    }

    fn remedy(&self) -> &'static str {
        "correct its energy"
    }
}

impl NodalLaw for Push {
    fn add_to_rows(&mut self, _rows: Range<usize>, _at: Instant<'_>, [x, ..]: [&mut [f64]; 3]) -> f64 {
        x.iter_mut().for_each(|force| *force += 1.0);
        0.0
    }
}

#[test]
fn its_negative_work_does_not_hide_a_spurious_gain() {
    // A triangle that moves against the pressure.
    let mut model = surface(&[[0.0; 3], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0]], &[[0, 1, 2]], 0.0);
    model.velocities = vec![[0.0, 0.0, -2.0]; 3];
    let settings = Settings { loss_tolerance: 1.0, ..Settings::default() };
    let run = |more: fn(&Assembly) -> Vec<Box<dyn Law>>| {
        let mut simulation = simulation_of(model.clone(), &[pressure(1.0)], METHODS[0], Some(1e-3), settings, more);
        let result = simulation.step(64);
        (result, simulation.ledger().work[0])
    };
    let (result, work) = run(|_| Vec::new());
    assert!(result.is_ok() && work < -0.3, "{work}");
    let text = run(|_| vec![Box::new(Push)]).0.unwrap_err().to_string();
    assert!(text.contains("a spurious gain of"), "{text}");
}
