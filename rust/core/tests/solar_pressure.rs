//! Pressure of sunlight: no force edge-on, slivers, parameters that are refused, work by every method.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use common::{films, sheet};
use membrane_core::integrators::METHODS;
use membrane_core::laws::{LawParameters, LawSpec, SolarPressureParameters};
use membrane_core::model::input::{Film, Model};
use membrane_core::simulation::{Settings, Simulation};

const FILM: Film = Film { youngs_modulus: 1e6, poisson_ratio: 0.3, density: 1000.0, thickness: 1e-4 };

fn light() -> SolarPressureParameters {
    SolarPressureParameters::example()
}

/// A triangle of 1 m2 across the axis, and a second one that hangs on its first side, with its third node at `tip`.
fn forces(light: SolarPressureParameters, tip: [f64; 3]) -> Vec<[f64; 3]> {
    let points = [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, -1.0, 0.0]];
    let model = Model {
        positions: vec![points[0], points[1], points[2], tip],
        velocities: vec![[0.0; 3]; 4],
        extra_masses: vec![0.0; 4],
        reference: points.to_vec(),
        triangles: vec![[0, 1, 2], [1, 0, 3]],
        film: Some(FILM),
        ..Model::default()
    };
    let mut simulation = Simulation::new(model, &[light.into()], "rk4", Some(1e-9), Settings::default()).unwrap();
    simulation.forces(Some("solar_pressure")).unwrap()
}

#[test]
fn a_facet_edge_on_and_a_facet_without_area_bear_nothing() {
    // In the plane of the sun and the side; collapsed onto the side; collapsed to a point of it.
    let along = SolarPressureParameters { sun: [0.0, 0.0, 2.0], ..light() };
    for tip in [[1.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0; 3]] {
        let found = forces(along.clone(), tip);
        assert_eq!(found[3], [0.0; 3], "{tip:?}");
        assert!(found[2][2] < 0.0 && found[..3].iter().all(|force| *force == found[2]), "{found:?}");
    }
}

#[test]
fn the_force_is_continuous_where_a_facet_turns_its_other_side_to_the_sun() {
    let along = SolarPressureParameters { sun: [0.0, 0.0, 2.0], ..light() };
    let at = |tilt: f64| forces(along.clone(), [1.0, -tilt, -1.0])[3];
    for tilt in [1e-3, 1e-6, 1e-9] {
        let size = [at(tilt), at(-tilt)].concat().iter().fold(0.0_f64, |most, force| most.max(force.abs()));
        assert!(size > 0.0 && size < 10.0 * tilt, "{tilt}: {size}");
    }
}

#[test]
fn the_direction_to_the_sun_has_any_length() {
    let tip = [1.0, -0.5, 0.5];
    let known = forces(light(), tip);
    for factor in [1e-200, 3.0, 1e200] {
        let found = forces(SolarPressureParameters { sun: light().sun.map(|s| factor * s), ..light() }, tip);
        for (found, known) in found.as_flattened().iter().zip(known.as_flattened()) {
            assert!((found - known).abs() < 1e-14, "{factor}: {found} {known}");
        }
    }
}

#[test]
fn parameters_without_meaning_are_refused_by_name() {
    let cases = [
        (SolarPressureParameters { sun: [0.0; 3], ..light() }, "direction to the sun"),
        (SolarPressureParameters { sun: [f64::NAN, 0.0, 1.0], ..light() }, "direction to the sun"),
        (SolarPressureParameters { distance: 0.0, ..light() }, "distance from the sun"),
        (SolarPressureParameters { distance: 1e-200, ..light() }, "pressure of sunlight at its distance"),
        (SolarPressureParameters { front_specular: 1.5, ..light() }, "specular share of the front"),
        (SolarPressureParameters { front_diffuse: 0.5, ..light() }, "reflected share of the front"),
        (SolarPressureParameters { back_diffuse: 0.9, ..light() }, "reflected share of the back"),
        (SolarPressureParameters { back_lambert: -0.5, ..light() }, "Lambert coefficient of the back"),
        (
            SolarPressureParameters { front_emissivity: 0.0, back_emissivity: 0.0, ..light() },
            "emissivity of both sides",
        ),
    ];
    for (parameters, words) in cases {
        let laws: [LawSpec; 1] = [parameters.into()];
        let error = Simulation::new(sheet(2, 2, 0.01), &laws, "rk4", Some(1e-9), Settings::default()).err().unwrap();
        assert!(error.to_string().contains(words), "{error}");
    }
}

#[test]
fn its_work_closes_the_balance_at_the_order_of_each_method() {
    let film = films().next().unwrap();
    let model = || {
        let mut model = sheet(4, 3, 0.01);
        model.positions.iter_mut().for_each(|p| *p = [1.01 * p[0], 1.01 * p[1], 0.3 * p[0]]);
        (model.cords, model.bridges) = (Vec::new(), Default::default());
        model
    };
    // About 5 kPa.
    let light = SolarPressureParameters { distance: 4.5e6, ..light() };
    for method in METHODS {
        let residual = |steps: u64| {
            let dt = 4e-6 / steps as f64;
            let laws = [film.clone(), light.clone().into()];
            let mut simulation = Simulation::new(model(), &laws, method.name, Some(dt), Settings::default()).unwrap();
            simulation.step(steps).unwrap();
            assert!(simulation.ledger().work[1] > 0.0, "{}", method.name);
            simulation.ledger().error(&simulation.energy_terms()).abs()
        };
        let (coarse, fine) = (residual(50), residual(100));
        assert!(fine < 1e-3 && (fine < 0.35 * coarse || fine < 1e-9), "{}: {coarse:e} {fine:e}", method.name);
    }
}
