//! Every method in the list: its order, its evaluations, its limit, its loss.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use membrane_core::forces::{LawSpec, SpringParameters};
use membrane_core::integrators;
use membrane_core::model::{Cord, Model};
use membrane_core::simulation::{Settings, Simulation};
use membrane_core::width::Width;

/// `masses` masses of `m` along x between two held nodes, joined by cords of stiffness `k`, stretched to twice their rest
/// length so that none goes slack, with small velocities along x.
fn chain(masses: usize, k: f64, m: f64, speed: f64) -> Model {
    let n = masses + 2;
    let mut dice = common::Dice(1);
    Model {
        positions: (0..n).map(|i| [2.0 * i as f64, 0.0, 0.0]).collect(),
        velocities: (0..n).map(|_| [speed * dice.roll(), 0.0, 0.0]).collect(),
        extra_masses: vec![m; n],
        fixed: vec![0, n as u32 - 1],
        cords: (0..n as u32 - 1)
            .map(|i| Cord { nodes: [i, i + 1], stiffness: k, rest_length: 1.0, strain_limit: 10.0 })
            .collect(),
        ..Model::default()
    }
}

/// One mass between two held nodes: a linear oscillator along x with omega = 1.
fn oscillator(offset: f64) -> Model {
    let mut model = chain(1, 0.5, 1.0, 0.0);
    model.positions[1][0] += offset;
    model
}

fn unwatched() -> Settings {
    Settings { watch_interval: u64::MAX, ..Settings::default() }
}

fn amplitude(simulation: &Simulation) -> f64 {
    ((simulation.positions()[1][0] - 2.0).powi(2) + simulation.velocities()[1][0].powi(2)).sqrt()
}

#[test]
fn each_method_has_its_stated_order_and_cost() {
    for name in integrators::names() {
        let error = |steps: u64| {
            let dt = 10.0 / steps as f64;
            let mut simulation = Simulation::new(oscillator(0.3), &[], name, Some(dt), unwatched()).unwrap();
            simulation.step(steps).unwrap();
            assert_eq!(
                simulation.evaluation_count(),
                steps * u64::from(simulation.integrator().evaluations_per_step())
            );
            (simulation.positions()[1][0] - 2.0 - 0.3 * 10.0_f64.cos()).abs()
        };
        let ratio = error(200) / error(400);
        let order = f64::from(integrators::by_name(name, 1, 0, Width::Baseline).unwrap().order());
        assert!((ratio.log2() - order).abs() < 0.1, "{name}: measured order {}", ratio.log2());
    }
}

#[test]
fn each_method_is_stable_just_below_its_predicted_limit_and_not_just_above() {
    for name in integrators::names() {
        for (model, what) in [(chain(1, 0.5, 1.0, 1e-6), "oscillator"), (chain(40, 7.0, 0.3, 1e-6), "chain")] {
            let new = |dt| Simulation::new(model.clone(), &[], name, dt, unwatched()).unwrap();
            let predicted = new(None).limit().unwrap().dt;
            let grows = |dt: f64| {
                let mut simulation = new(Some(dt));
                let before = simulation.accounts().kinetic;
                simulation.step(2000).unwrap();
                let after = simulation.accounts().kinetic;
                after.is_nan() || after > 10.0 * before
            };
            assert!(!grows(0.99 * predicted), "{name}, {what}: grows below its limit");
            assert!(grows(1.02 * predicted), "{name}, {what}: bounded beyond its limit");
        }
    }
}

#[test]
fn rk4_on_a_uniform_chain_is_bounded_to_1_414_root_m_over_k() {
    let limit = Simulation::new(chain(400, 7.0, 0.3, 0.0), &[], "rk4", None, unwatched()).unwrap().limit().unwrap();
    let expected = 2.0_f64.sqrt() * (0.3_f64 / 7.0).sqrt();
    assert!((limit.dt / expected - 1.0).abs() < 1e-3, "{} {expected}", limit.dt);
    assert_eq!(limit.law, "tethers");
}

#[test]
fn rk4_loses_amplitude_as_predicted() {
    for dt in [0.4, 0.8] {
        let mut simulation = Simulation::new(oscillator(0.3), &[], "rk4", Some(dt), unwatched()).unwrap();
        let before = amplitude(&simulation);
        simulation.step(100).unwrap();
        let loss = 1.0 - (amplitude(&simulation) / before).powf(0.01);
        let predicted = dt.powi(6) / 144.0;
        // The next term is of relative size (omega dt)^2 / 8.
        assert!((loss / predicted - 1.0).abs() < dt * dt / 6.0, "{loss:e} {predicted:e}");
    }
}

#[test]
fn a_damped_oscillator_keeps_its_energy_balance_and_its_limit() {
    for ratio in [0.02, 0.5, 2.0] {
        let laws = [LawSpec::SpringDamping(ratio)];
        let mut simulation = Simulation::new(oscillator(0.3), &laws, "rk4", None, unwatched()).unwrap();
        let limit = simulation.limit().unwrap().dt;
        simulation.set_dt(0.02 * limit).unwrap();
        simulation.step(500).unwrap();
        let error = simulation.ledger().error(&simulation.accounts());
        assert!(error.abs() < 1e-6, "zeta {ratio}: energy balance {error:e}");
        let stable = |dt: f64| {
            let mut simulation = Simulation::new(oscillator(1e-6), &laws, "rk4", Some(dt), unwatched()).unwrap();
            simulation.step(2000).unwrap();
            amplitude(&simulation) < 1e-5
        };
        assert!(stable(0.99 * limit) && !stable(1.02 * limit), "zeta {ratio}: limit {limit}");
    }
}

#[test]
fn the_same_run_gives_the_same_bits_whole_or_in_pieces() {
    let new = || {
        Simulation::new(
            chain(30, 7.0, 0.3, 0.3),
            &[LawSpec::SpringDamping(0.02)],
            "rk4",
            Some(0.05),
            Settings::default(),
        )
        .unwrap()
    };
    let (mut whole, mut first, mut second) = (new(), new(), new());
    whole.step(1000).unwrap();
    first.step(337).unwrap();
    second.resume(&first.progress()).unwrap();
    second.step(663).unwrap();
    assert_eq!(whole.progress(), second.progress());
}

#[test]
fn a_step_too_large_is_stopped_with_time_place_law_and_cure() {
    let mut simulation = Simulation::new(chain(30, 7.0, 0.3, 0.3), &[], "rk4", Some(0.5), Settings::default()).unwrap();
    let text = simulation.step(10_000).unwrap_err().to_string();
    for word in ["t = ", "step ", "node", "tethers", "above the stability limit"] {
        assert!(text.contains(word), "{text}");
    }
    assert!(simulation.positions().iter().flatten().all(|value| value.is_finite()));
}

#[test]
fn what_cannot_be_stepped_is_refused() {
    let refuse = |model: Model, laws: &[LawSpec], name: &str, dt: Option<f64>| {
        Simulation::new(model, laws, name, dt, Settings::default()).map(|_| ()).unwrap_err().to_string()
    };
    assert!(refuse(oscillator(0.0), &[], "rk5", None).contains("rk4"));
    for dt in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(refuse(oscillator(0.0), &[], "rk4", Some(dt)).contains("dt"));
    }
    assert!(refuse(oscillator(0.0), &[], "rk4", Some(1e3)).contains("times the stability limit"));
    let loose = Model { cords: Vec::new(), ..oscillator(0.0) };
    assert!(refuse(loose, &[], "rk4", None).contains("give dt"));
    let massless = Model { extra_masses: vec![1.0, 0.0, 1.0], ..oscillator(0.0) };
    assert!(refuse(massless, &[], "rk4", None).contains("node 1"));
    let bad =
        SpringParameters { buckling: f64::NAN, buckling_on_creases: 1.0, buckling_length: None, strain_limit: 0.1 };
    assert!(refuse(oscillator(0.0), &[LawSpec::Springs(bad)], "rk4", None).contains("buckling"));
}
