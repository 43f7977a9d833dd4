//! Leapfrog with substeps: the slow laws, order, energy balance and bits.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use common::sail;
use membrane_core::laws::{LawSpec, MassDampingParameters};
use membrane_core::model::input::{Cord, Model};
use membrane_core::simd::dispatch::InstructionSet;
use membrane_core::simulation::{Settings, Simulation};

/// Mass of the oscillator \[kg\].
const MASS: f64 = 0.3;

/// Three masses on a taut chain between two held nodes, oscillating in all directions in an accelerated frame; friction
/// and weight are slow beside the cords.
fn chain(name: &str, substeps: u32, dt: f64) -> Simulation {
    let model = Model {
        positions: (0..5).map(|i| [2.0 * f64::from(i), 0.0, 0.0]).collect(),
        velocities: common::Dice(7).vectors(5, 0.5),
        extra_masses: vec![1.0; 5],
        fixed: vec![0, 4],
        cords: (0..4)
            .map(|i| Cord {
                nodes: [i, i + 1],
                stiffness: 7.0,
                rest_length: 1.0,
                strain_limit: 10.0,
                ..Default::default()
            })
            .collect(),
        ..Model::default()
    };
    let spin = common::spin(0.7, 0.05);
    let laws = [
        LawSpec::SpringDamping(0.1.into()),
        spin,
        MassDampingParameters { rate: 0.05 }.into(),
        common::gravity([0.3, -0.2, 0.4]),
    ];
    let settings = Settings { substeps, check_interval: u64::MAX, ..Settings::default() };
    Simulation::new(model, &laws, name, Some(dt), settings).unwrap()
}

fn sail_in(substeps: u32, dt: Option<f64>) -> Simulation {
    let settings = Settings { substeps, ..Settings::default() };
    Simulation::new(sail::sail(1), &sail::laws(), "leapfrog", dt, settings).unwrap()
}

#[test]
fn slow_laws_have_a_limit_of_ten_times_that_of_the_scene() {
    let slow = |simulation: &Simulation| simulation.slow_laws().collect::<Vec<_>>();
    assert_eq!(slow(&chain("leapfrog", 4, 0.01)), ["mass_damping", "gravity"]);
    for (name, count) in [("leapfrog", 1), ("rk4", 4)] {
        assert!(slow(&chain(name, count, 0.01)).is_empty());
    }
    let (whole, divided) = (sail_in(1, None), sail_in(4, None));
    assert!(slow(&divided).contains(&"creases") && slow(&divided).contains(&"air_drag"), "{:?}", slow(&divided));
    assert!((divided.limit().unwrap().dt / whole.limit().unwrap().dt / 4.0 - 1.0).abs() < 1e-3);
}

#[test]
fn the_default_step_is_shorter_than_half_a_period_of_any_mode() {
    let mut last = 0.0;
    for count in 2..12 {
        let simulation = sail_in(count, None);
        let phase = simulation.dt() * simulation.limit().unwrap().largest_frequency;
        assert!(phase < std::f64::consts::PI && phase >= 0.99 * last, "{count}: {phase}");
        last = phase;
    }
    // Steps of a whole number in a power of ten of a second are shorter by up to a hundredth.
    assert!(last > 2.75, "{last}");
}

#[test]
fn slow_friction_and_weight_leave_the_order_of_motion_work_and_energy_at_two() {
    let run = |name: &str, steps: u64| {
        let mut simulation = chain(name, 4, 2.0 / steps as f64);
        simulation.step(steps).unwrap();
        simulation
    };
    let exact = run("dopri5", 4000);
    let errors = [40, 80].map(|steps| {
        let found = run("leapfrog", steps);
        let distance = |a: &[[f64; 3]], b: &[[f64; 3]]| {
            a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        let work = |simulation: &Simulation, law: usize| simulation.ledger().work[law];
        [
            distance(&found.positions(), &exact.positions()),
            distance(&found.velocities(), &exact.velocities()),
            (work(&found, 2) - work(&exact, 2)).abs(),
            found.ledger().residual(&found.energy_terms()).abs(),
        ]
    });
    assert_eq!(chain("leapfrog", 4, 0.01).integrator().properties().order, 2);
    for (k, what) in ["position", "velocity", "work of friction", "energy"].iter().enumerate() {
        let order = (errors[0][k] / errors[1][k]).log2();
        let is_met = if k < 2 { (order - 2.0).abs() < 0.25 } else { order > 1.7 };
        assert!(is_met, "{what}: order {order}, error {:e}", errors[1][k]);
    }
}

#[test]
fn the_balance_of_a_sail_is_that_of_leapfrog_at_a_quarter_of_the_slow_evaluations() {
    let run = |substeps: u32, steps: u64, dt: f64| {
        let mut simulation = sail_in(substeps, Some(dt));
        simulation.step(steps).unwrap();
        simulation
    };
    let (whole, divided) = (run(1, 400, 1e-6), run(4, 100, 4e-6));
    assert_eq!(whole.evaluation_count(), divided.evaluation_count());
    assert!((whole.time() - divided.time()).abs() < 1e-12);
    let [a, b] = [&whole, &divided].map(|simulation| simulation.ledger().error(&simulation.energy_terms()));
    assert!((a - b).abs() < 0.05 * a.abs() + 1e-6, "{a:e} {b:e}");
    for name in ["air_drag", "spring_damping"] {
        let row = whole.laws().iter().position(|law| law.name() == name).unwrap();
        let [whole, divided] = [&whole, &divided].map(|simulation| simulation.ledger().work[row]);
        assert!((divided / whole - 1.0).abs() < 1e-3, "{name}: {divided:e} {whole:e}");
    }
}

/// A mass between two taut cords, which moves along them at 1 m/s with a damping ratio, in steps of a phase \[rad\].
fn oscillator(substeps: u32, ratio: f64, phase: f64) -> Simulation {
    let (mass, stiffness) = (MASS, 7.0);
    let model = Model {
        positions: (0..3).map(|i| [2.0 * f64::from(i), 0.0, 0.0]).collect(),
        velocities: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0; 3]],
        extra_masses: vec![mass; 3],
        fixed: vec![0, 2],
        cords: (0..2)
            .map(|i| Cord { nodes: [i, i + 1], stiffness, rest_length: 0.5, strain_limit: 10.0, ..Default::default() })
            .collect(),
        ..Model::default()
    };
    let frequency = f64::sqrt(2.0 * stiffness / mass);
    // Of both cords c = 4 r (k m)^1/2 = 2 (2^1/2 r) omega m.
    let laws = [LawSpec::SpringDamping((ratio / f64::sqrt(2.0)).into())];
    let settings = Settings {
        substeps,
        energy_tolerance: 1.0,
        loss_tolerance: 1.0,
        check_interval: u64::MAX,
        ..Settings::default()
    };
    Simulation::new(model, &laws, "leapfrog", Some(phase / frequency), settings).unwrap()
}

#[test]
fn the_work_of_dashpots_is_within_the_energy_error_of_the_method() {
    // Bounds relative to (omega dt)^2/4, by which the energy of leapfrog oscillates; with the predicted velocity alone
    // the work would be wrong by twice this.
    for (phase, bound) in [(0.5, 0.05), (1.0, 0.1), (2.0, 0.4), (2.8, 1.5)] {
        for ratio in [0.02, 0.1] {
            let steps = f64::ceil(15.0 / (ratio * phase)) as u64;
            let (mut divided, mut whole) = (oscillator(4, ratio, phase), oscillator(1, ratio, phase / 4.0));
            divided.step(steps).unwrap();
            whole.step(4 * steps).unwrap();
            let energy = 0.5 * MASS;
            let error = (divided.ledger().of_laws()[1] - whole.ledger().of_laws()[1]).abs() / energy;
            let oscillation = (phase / 4.0).powi(2) / 4.0;
            assert!(error < bound * oscillation, "{phase}, {ratio}: {error:e}, {oscillation:e}");
            // All energy is lost by then.
            let left = divided.energy_terms().kinetic / energy;
            assert!(left < 1e-9, "{phase}, {ratio}: {left:e}");
        }
    }
}

#[test]
fn a_sail_continues_with_the_same_bits_at_every_width() {
    let new = || sail_in(4, Some(4e-6));
    let mut whole = new();
    whole.step(50).unwrap();
    for steps in [0, 1, 17] {
        let (mut first, mut second) = (new(), new());
        first.step(steps).unwrap();
        // A side step evaluates the start of a run.
        first.reach(first.time() + 1e-6, 1).unwrap();
        second.resume(&first.progress()).unwrap();
        second.step(50 - steps).unwrap();
        assert_eq!(whole.progress(), second.progress(), "{steps}");
    }
    for instructions in InstructionSet::ALL {
        let settings = Settings { substeps: 4, instructions, ..Settings::default() };
        let mut other = Simulation::new(sail::sail(1), &sail::laws(), "leapfrog", Some(4e-6), settings).unwrap();
        other.step(50).unwrap();
        assert_eq!(whole.progress(), other.progress(), "{instructions:?}");
    }
}
