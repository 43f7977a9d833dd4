//! Creases that are folded against their side: the angle goes on past 3 pi/2, to contact at 2 pi, and back.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use std::f64::consts::{PI, TAU};

use common::{Bench, FILM, creases, methods, simulation_of, springs};
use membrane_core::error::Error;
use membrane_core::laws::Instant;
use membrane_core::model::input::{Creases, Model};
use membrane_core::simulation::{Settings, Simulation};

const SIZE: f64 = 0.01;
const NATURAL: f64 = 1.0;

/// Two triangles of which one turns about their crease, from an angle at a speed.
fn hinge(angle: f64, speed: f64) -> Model {
    let reference = vec![[0.0; 3], [SIZE, 0.0, 0.0], [0.5 * SIZE, -SIZE, 0.0], [0.5 * SIZE, SIZE, 0.0]];
    let (sine, cosine) = (PI - angle).sin_cos();
    let mut positions = reference.clone();
    positions[3] = [0.5 * SIZE, SIZE * cosine, SIZE * sine];
    let mut velocities = vec![[0.0; 3]; 4];
    velocities[3] = [0.0, speed * sine, -speed * cosine];
    Model {
        positions,
        velocities,
        reference,
        triangles: vec![[0, 2, 1], [0, 1, 3]],
        film: Some(FILM),
        creases: Creases { nodes: vec![[0, 1]], fold_signs: vec![1.0], ..Creases::default() },
        extra_masses: vec![0.0; 4],
        fixed: vec![0, 1, 2],
        ..Model::default()
    }
}

/// From flat against its side, fast enough to touch at 2 pi.
fn turning(method: usize) -> Simulation {
    let laws = [springs(), creases(NATURAL)];
    let method = methods().nth(method).unwrap();
    let settings = Settings { energy_tolerance: 1.0, ..Settings::default() };
    simulation_of(hinge(PI, 15.0), &laws, method, None, settings, |_| Vec::new())
}

fn angle(simulation: &Simulation) -> f64 {
    simulation.crease_angles().unwrap()[0]
}

#[test]
fn a_crease_turns_past_flat_to_contact_and_back_without_a_jump() {
    for (row, method) in methods().enumerate() {
        let mut simulation = turning(row);
        let (mut last, mut largest, mut is_back) = (angle(&simulation), 0.0_f64, false);
        assert!((last - PI).abs() < 1e-12);
        while !is_back {
            simulation.step(1).unwrap();
            let now = angle(&simulation);
            assert!((now - last).abs() < 0.2, "{}: from {last} to {now}", method.name);
            largest = largest.max(now);
            (last, is_back) = (now, now < 0.9 * PI);
            assert!(simulation.time() < 0.1, "{}: still at {now}", method.name);
        }
        assert!((TAU + 0.01..TAU + 0.5).contains(&largest), "{}: {largest}", method.name);
        let error = simulation.ledger().error(&simulation.energy_terms());
        assert!(error.abs() < 0.03, "{}: {error}", method.name);
    }
}

#[test]
fn the_side_is_saved_with_a_run_and_kept_by_a_motion_of_the_same_shape() {
    let mut simulation = turning(0);
    assert_eq!(simulation.progress().law_histories[1].1, Vec::<f64>::new());
    while angle(&simulation) < 1.8 * PI {
        simulation.step(1).unwrap();
    }
    let saved = simulation.progress();
    assert_eq!(saved.law_histories[1], (Vec::new(), vec![1.0]));
    let mut resumed = turning(0);
    resumed.resume(&saved).unwrap();
    assert_eq!(angle(&resumed), angle(&simulation));
    simulation.step(500).unwrap();
    resumed.step(500).unwrap();
    assert_eq!(resumed.progress(), simulation.progress());

    let mut wrong = saved.clone();
    for numbers in [vec![1.0, 0.0], vec![0.5], vec![f64::NAN]] {
        wrong.law_histories[1].1 = numbers;
        assert!(matches!(resumed.resume(&wrong), Err(Error::HistoryMisfit { owner: "creases" })));
    }
    resumed.resume(&saved).unwrap();
    let folded = angle(&resumed);
    resumed.set_motion(&saved.positions, &[[0.0; 3]; 4]).unwrap();
    assert_eq!(angle(&resumed), folded);

    let mut moved = saved.positions.clone();
    moved[3][0] += 1e-9;
    resumed.set_motion(&moved, &saved.velocities).unwrap();
    let own = angle(&resumed);
    assert!((own + TAU - folded).abs() < 1e-6, "{own}");

    let mut other = turning(0);
    for (given, expected) in [(None, own), (Some([folded, 0.0].as_slice()), own), (Some([folded].as_slice()), folded)] {
        other.start_from(0.5, &[0.0; 14], &saved.positions, &saved.velocities, given, &[]).unwrap();
        assert!((angle(&other) - expected).abs() < 1e-6, "{given:?}: {}", angle(&other));
    }
}

#[test]
fn the_side_is_that_on_which_the_crease_was_last_open() {
    let mut bench = Bench::new(hinge(PI, 0.0), &[creases(NATURAL)]);
    let moved = bench.assembly.numbering.to_internal([3])[0] as usize;
    let mut at = |angle: f64, height: f64| {
        let (sine, cosine) = (PI - angle).sin_cos();
        for (axis, value) in [0.5 * SIZE, height * cosine, height * sine].into_iter().enumerate() {
            bench.state.positions[(moved, axis)] = value;
        }
        let instant = Instant::new(bench.state.at(0.0), &bench.spin);
        bench.laws[0].history_dependent_mut().unwrap().accept(instant);
        bench.laws[0].inspection().unwrap().crease_angles(instant).unwrap()[0]
    };
    // (angle of the positions, height of the facet, angle of the crease).
    for (angle, height, expected) in [
        (0.2, SIZE, 0.2),
        (-1.5, SIZE, -1.5),
        (3.0, SIZE, 3.0),
        (1.6, SIZE, 1.6),
        (-0.5, SIZE, -0.5),
        (4.0, SIZE, 4.0),
        (5.5, SIZE, 5.5),
        (7.8, SIZE, 7.8),
        (4.0, 1e-3 * SIZE, 4.0),
        (5.5, 1e-3 * SIZE, 5.5),
        (5.5, SIZE, 5.5),
        (3.1, SIZE, 3.1),
        (1.6, 1e-3 * SIZE, 1.6),
        (-0.5, SIZE, -0.5),
        (4.6, SIZE, 4.6),
        (5.5, SIZE, 5.5),
        (3.1, SIZE, 3.1),
        (-0.1, SIZE, -0.1),
    ] {
        let found = at(angle, height);
        assert!((found - expected).abs() < 1e-12, "{found} in place of {expected}");
    }
}

/// Work of the forces and change of the energy along a path of the apex, in equal parts; each point is an angle and the
/// height of the facet, negative where it is inverted.
fn along(path: &[(f64, f64)], parts: usize) -> [f64; 2] {
    let mut bench = Bench::new(hinge(PI, 0.0), &[creases(NATURAL)]);
    let moved = bench.assembly.numbering.to_internal([3])[0] as usize;
    let (mut work, mut energies, mut last) = (0.0, Vec::new(), None);
    for pair in path.windows(2) {
        for part in 0..=parts {
            let share = part as f64 / parts as f64;
            let [angle, height] =
                [pair[0].0 + share * (pair[1].0 - pair[0].0), pair[0].1 + share * (pair[1].1 - pair[0].1)];
            let apex = [0.5 * SIZE, SIZE * height * (PI - angle).cos(), SIZE * height * (PI - angle).sin()];
            for (axis, value) in apex.into_iter().enumerate() {
                bench.state.positions[(moved, axis)] = value;
            }
            let instant = Instant::new(bench.state.at(0.0), &bench.spin);
            bench.laws[0].history_dependent_mut().unwrap().accept(instant);
            let state = bench.state.clone();
            let (forces, _) = bench.evaluate(0, 0.0, &state);
            let force = [0, 1, 2].map(|axis| forces[(moved, axis)]);
            if let Some((before, pull)) = last.replace((apex, force)) {
                work += (0..3).map(|k| 0.5 * (force[k] + pull[k]) * (apex[k] - before[k])).sum::<f64>();
            }
            energies.push(bench.laws[0].energy(bench.instant()));
        }
    }
    [work, energies[energies.len() - 1] - energies[0]]
}

#[test]
fn the_energy_goes_on_where_a_facet_collapses_and_turns_over() {
    // Folded on the other side, collapsed and opened there; collapsed, unfolded to its own side and opened; inverted.
    let other = [(PI, 1.0), (5.5, 1.0), (5.5, 0.02), (4.0, 0.02), (5.5, 0.02), (5.5, 1.0)];
    let own = [(PI, 1.0), (4.0, 1.0), (4.0, 0.02), (1.6, 0.02), (0.3, 0.02), (0.3, 1.0)];
    let over = [(PI, 1.0), (2.0, 1.0), (2.0, -1.0), (2.0, 1.0)];
    for path in [&other[..], &own, &over] {
        let misfits = [2000, 4000].map(|parts| {
            let [work, energy] = along(path, parts);
            work + energy
        });
        assert!((3.9..4.1).contains(&(misfits[0] / misfits[1])), "{path:?}: {misfits:?}");
        assert!(misfits[1].abs() < 1e-10, "{path:?}: {misfits:?}");
    }
}
