//! Every method in the list: order, evaluations, limit and dissipation.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use common::{methods, simulation_of};
use membrane_core::integrators::{Integrator, Method, Options, Properties, Tolerance};
use membrane_core::laws::{DampingParameters, LawSpec, Limited, MassDampingParameters, SpringParameters};
use membrane_core::model::input::{Cord, Model};
use membrane_core::simulation::{Settings, Simulation};

/// `masses` masses of `m` along x between two held nodes, joined by cords of stiffness `k`, stretched to twice their
/// rest length so that none becomes slack, with small velocities along x.
fn chain(masses: usize, k: f64, m: f64, speed: f64) -> Model {
    let n = masses + 2;
    let mut dice = common::Dice(1);
    Model {
        positions: (0..n).map(|i| [2.0 * i as f64, 0.0, 0.0]).collect(),
        velocities: (0..n).map(|_| [speed * dice.roll(), 0.0, 0.0]).collect(),
        extra_masses: vec![m; n],
        fixed: vec![0, n as u32 - 1],
        cords: (0..n as u32 - 1)
            .map(|i| Cord {
                nodes: [i, i + 1],
                stiffness: k,
                rest_length: 1.0,
                strain_limit: 10.0,
                ..Default::default()
            })
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

fn without_monitor() -> Settings {
    Settings { check_interval: u64::MAX, ..Settings::default() }
}

fn amplitude(simulation: &Simulation) -> f64 {
    ((simulation.positions()[1][0] - 2.0).powi(2) + simulation.velocities()[1][0].powi(2)).sqrt()
}

#[test]
fn each_method_has_its_stated_order_and_cost() {
    for name in names() {
        let error = |steps: u64| {
            let dt = 10.0 / steps as f64;
            let mut simulation = simulation(oscillator(0.3), &[], name, Some(dt), without_monitor());
            simulation.step(steps).unwrap();
            let Properties { evaluations_per_step, evaluations_at_start, .. } = simulation.integrator().properties();
            let expected = steps * u64::from(evaluations_per_step) + u64::from(evaluations_at_start);
            assert_eq!(simulation.evaluation_count(), expected);
            (simulation.positions()[1][0] - 2.0 - 0.3 * 10.0_f64.cos()).abs()
        };
        let ratio = error(200) / error(400);
        let order = f64::from(by_name(name).properties().order);
        assert!((ratio.log2() - order).abs() < 0.1, "{name}: measured order {}", ratio.log2());
    }
}

fn names() -> impl Iterator<Item = &'static str> {
    methods().map(|method| method.name)
}

fn method(name: &str) -> Method {
    methods().find(|method| method.name == name).unwrap()
}

fn by_name(name: &str) -> Box<dyn Integrator> {
    (method(name).make)(&Options::default())
}

fn simulation(model: Model, laws: &[LawSpec], name: &str, dt: Option<f64>, settings: Settings) -> Simulation {
    simulation_of(model, laws, method(name), dt, settings, |_| Vec::new())
}

/// Methods with a limit of the step.
fn limited() -> impl Iterator<Item = &'static str> {
    names().filter(|name| !by_name(name).properties().is_implicit)
}

/// Steps after which a mode with a thousandth of the amplitude dominates the motion at 1.02 of the limit.
fn steps_to_instability(simulation: &Simulation, damping: f64) -> u64 {
    let limit = simulation.limit().unwrap();
    let amplification = simulation.integrator().amplification(limit.largest_frequency, damping, 1.02 * limit.dt);
    assert!(amplification > 1.0);
    (3e3_f64.ln() / amplification.ln()).ceil() as u64 + 100
}

#[test]
fn each_method_is_stable_just_below_its_predicted_limit_and_not_just_above() {
    for name in limited() {
        for (model, what) in [(chain(1, 0.5, 1.0, 1e-6), "oscillator"), (chain(8, 7.0, 0.3, 1e-6), "chain")] {
            let new = |dt| simulation(model.clone(), &[], name, Some(dt), without_monitor());
            let first = new(0.01);
            let predicted = first.limit().unwrap().dt;
            let steps = steps_to_instability(&first, 0.0);
            let grows = |dt: f64| {
                let mut simulation = new(dt);
                let before = simulation.energy_terms().kinetic;
                simulation.step(steps).unwrap();
                // The energy of leapfrog oscillates: at 0.99 of its limit fiftyfold.
                let after = simulation.energy_terms();
                let after = after.kinetic + after.stored.iter().sum::<f64>() - simulation.ledger().start.stored[0];
                after.is_nan() || after > 1e3 * before
            };
            assert!(!grows(0.99 * predicted), "{name}, {what}: grows below its limit");
            assert!(grows(1.02 * predicted), "{name}, {what}: bounded beyond its limit");
        }
    }
}

#[test]
fn rk4_on_a_uniform_chain_is_bounded_to_1_414_root_m_over_k() {
    let limit =
        Simulation::new(chain(400, 7.0, 0.3, 0.0), &[], "rk4", None, without_monitor()).unwrap().limit().unwrap();
    let expected = 2.0_f64.sqrt() * (0.3_f64 / 7.0).sqrt();
    assert!((limit.dt / expected - 1.0).abs() < 1e-3, "{} {expected}", limit.dt);
    assert_eq!(limit.law, "tethers");
}

#[test]
fn rk4_loses_amplitude_as_predicted() {
    for dt in [0.4, 0.8] {
        let mut simulation = Simulation::new(oscillator(0.3), &[], "rk4", Some(dt), without_monitor()).unwrap();
        let before = amplitude(&simulation);
        simulation.step(100).unwrap();
        let loss = 1.0 - (amplitude(&simulation) / before).powf(0.01);
        let predicted = dt.powi(6) / 144.0;
        // The next term is of relative size (omega dt)^2 / 8.
        assert!((loss / predicted - 1.0).abs() < dt * dt / 6.0, "{loss:e} {predicted:e}");
    }
}

/// Dashpots without the kink of a limit.
fn linear_dashpots(ratio: f64) -> LawSpec {
    LawSpec::SpringDamping(DampingParameters { limited: Limited::None, ..DampingParameters::from(ratio) })
}

#[test]
fn a_damped_oscillator_keeps_its_energy_balance_and_its_limit() {
    for (name, allowed) in [("rk4", 1e-6), ("leapfrog", 1e-3), ("dopri5", 1e-6)] {
        for ratio in [0.02, 0.5, 2.0] {
            let laws = [linear_dashpots(ratio)];
            let new = |offset, dt| {
                // Hardly stretched: transverse to the cords, without dashpots, tension would limit dopri5 first.
                let mut model = oscillator(offset);
                model.cords.iter_mut().for_each(|cord| cord.rest_length = 1.9);
                simulation(model, &laws, name, Some(dt), without_monitor())
            };
            let limit = new(0.05, 0.01).limit().unwrap().dt;
            let mut simulation = new(0.05, 0.02 * limit);
            simulation.step(500).unwrap();
            let error = simulation.ledger().error(&simulation.energy_terms());
            assert!(error.abs() < allowed, "{name}, zeta {ratio}: energy balance {error:e}");
            // Two cords of k = 1/2, each with its dashpot: c = 2 (2 zeta sqrt(k m)).
            let steps = steps_to_instability(&new(0.05, 0.01), 4.0 * ratio * 0.5_f64.sqrt());
            let stable = |dt: f64| {
                let mut simulation = new(1e-6, dt);
                simulation.step(steps).unwrap();
                amplitude(&simulation) < 1e-5
            };
            assert!(stable(0.99 * limit) && !stable(1.02 * limit), "{name}, zeta {ratio}: limit {limit}");
        }
    }
}

/// Masses that oscillate in all directions in an accelerated frame, with dashpots, friction and weight.
fn damped_chain() -> (Model, Vec<LawSpec>) {
    let mut model = chain(3, 7.0, 1.0, 0.0);
    model.velocities = common::Dice(7).vectors(5, 0.5);
    let spin = common::spin(0.7, 0.05);
    let laws =
        vec![linear_dashpots(0.5), spin, MassDampingParameters { rate: 0.4 }.into(), common::gravity([0.3, -0.2, 0.4])];
    (model, laws)
}

#[test]
fn order_holds_with_strong_damping_coriolis_and_time_dependent_laws() {
    let (model, laws) = damped_chain();
    let run = |name: &str, steps: u64| {
        let dt = 2.0 / steps as f64;
        let mut simulation = simulation(model.clone(), &laws, name, Some(dt), without_monitor());
        simulation.step(steps).unwrap();
        simulation
    };
    let exact = run("dopri5", 4000);
    for name in names() {
        let errors = [160, 320].map(|steps| {
            let found = run(name, steps);
            let distance = |a: Vec<[f64; 3]>, b: Vec<[f64; 3]>| {
                a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
            };
            let of_work: Vec<f64> =
                found.ledger().work.iter().zip(&exact.ledger().work).map(|(a, b)| (a - b).abs()).collect();
            [
                distance(found.positions(), exact.positions()),
                distance(found.velocities(), exact.velocities()),
                of_work.iter().fold(0.0, |a, b| a.max(*b)),
                found.ledger().residual(&found.energy_terms()).abs(),
            ]
        });
        let order = f64::from(by_name(name).properties().order);
        for (k, what) in ["position", "velocity", "work", "energy"].iter().enumerate() {
            let measured = (errors[0][k] / errors[1][k]).log2();
            let is_met = if k < 2 { (measured - order).abs() < 0.25 } else { measured > order - 0.3 };
            assert!(is_met, "{name}: measured order of {what} {measured} ({:e})", errors[1][k]);
        }
    }
}

#[test]
fn a_method_that_conserves_energy_conserves_it_for_a_hundred_thousand_oscillations() {
    // One mass that oscillates in all directions: several frequencies, no chaos.
    let mut model = chain(1, 7.0, 1.0, 0.0);
    model.velocities[1] = [0.3, 0.5, 0.2];
    let laws = [common::spin(0.7, 0.0)];
    let mut seen = 0;
    for name in names() {
        let mut simulation = simulation(model.clone(), &laws, name, Some(0.01), without_monitor());
        if !simulation.integrator().properties().conserves_energy {
            continue;
        }
        seen += 1;
        let limit = simulation.limit().unwrap();
        simulation.set_dt(0.25 * limit.dt).unwrap();
        let period = std::f64::consts::TAU / limit.largest_frequency;
        let steps = (1e5 * period / simulation.dt()) as u64;
        let mut residuals = Vec::new();
        for _ in 0..100 {
            let mut worst: f64 = 0.0;
            for _ in 0..100 {
                simulation.step(steps / 10_000).unwrap();
                worst = worst.max(simulation.ledger().residual(&simulation.energy_terms()).abs());
            }
            residuals.push(worst / simulation.ledger().start.kinetic);
        }
        let (first, last) = (&residuals[..10], &residuals[90..]);
        let mean = |residuals: &[f64]| residuals.iter().sum::<f64>() / 10.0;
        assert!(mean(first) < 0.2 && (mean(last) / mean(first) - 1.0).abs() < 0.1, "{name}: {first:?} {last:?}");
    }
    assert!(seen > 0);
}

#[test]
fn the_same_run_gives_the_same_bits_whole_or_in_pieces() {
    for name in names() {
        let new = || {
            let spin = common::spin(0.05, 0.001);
            let laws = [LawSpec::SpringDamping(0.02.into()), spin];
            simulation(chain(30, 7.0, 0.3, 0.3), &laws, name, Some(0.005), Settings::default())
        };
        let (mut whole, mut first, mut second) = (new(), new(), new());
        whole.step(1000).unwrap();
        first.step(337).unwrap();
        second.resume(&first.progress()).unwrap();
        second.step(663).unwrap();
        assert_eq!(whole.progress(), second.progress(), "{name}");
    }
}

#[test]
fn a_progress_that_does_not_fit_changes_nothing() {
    for name in names() {
        let new = || simulation(oscillator(0.3), &[], name, Some(0.01), without_monitor());
        let (mut simulation, mut later) = (new(), new());
        simulation.step(3).unwrap();
        later.step(7).unwrap();
        let (before, mut unfit) = (simulation.progress(), later.progress());
        unfit.history.0.push(unfit.positions.clone());
        assert!(simulation.resume(&unfit).is_err(), "{name}");
        assert_eq!(simulation.progress(), before, "{name}");
        simulation.step(2).unwrap();
        let mut whole = new();
        whole.step(5).unwrap();
        assert_eq!(simulation.progress(), whole.progress(), "{name}");
    }
}

fn adaptive(model: Model, laws: &[LawSpec], relative: f64) -> Simulation {
    let tolerance = Tolerance { relative, length: 0.1, speed: 1.0 };
    Simulation::new(model, laws, "dopri5", None, Settings { tolerance, ..Settings::default() }).unwrap()
}

#[test]
fn an_adaptive_run_gives_the_same_bits_whole_or_in_pieces_at_any_output_times() {
    let (model, laws) = damped_chain();
    let new = || adaptive(model.clone(), &laws, 1e-6);
    let (mut whole, mut cut) = (new(), new());
    assert!(whole.is_adaptive() && whole.reach(5.0, u64::MAX).unwrap());
    for k in 1..=500 {
        if k % 50 == 0 {
            let saved = cut.progress();
            cut = new();
            cut.resume(&saved).unwrap();
            assert_eq!(cut.progress(), saved);
        }
        assert!(cut.reach(0.01 * f64::from(k), u64::MAX).unwrap());
        assert_eq!(cut.time(), 0.01 * f64::from(k));
    }
    assert_eq!(whole.progress(), cut.progress());
    assert_eq!(whole.positions(), cut.positions());
    assert_eq!(whole.energy_terms(), cut.energy_terms());
    assert!(!whole.reach(50.0, 3).unwrap());
    cut.step(3).unwrap();
    assert_eq!(whole.progress(), cut.progress());
}

#[test]
fn the_error_of_an_adaptive_run_is_proportional_to_its_tolerance_also_between_steps() {
    let worst = |relative: f64| {
        let mut simulation = adaptive(oscillator(0.3), &[], relative);
        let mut worst: f64 = 0.0;
        for k in 1..=400 {
            let time = 0.05 * f64::from(k);
            simulation.reach(time, u64::MAX).unwrap();
            worst = worst.max((simulation.positions()[1][0] - 2.0 - 0.3 * time.cos()).abs());
        }
        let attempts = simulation.step_count() + simulation.rejected_count();
        assert_eq!(simulation.evaluation_count(), 1 + 6 * attempts);
        (worst, simulation.evaluation_count())
    };
    let ((coarse, few), (fine, many)) = (worst(1e-5), worst(1e-8));
    assert!(fine < 1e-6 && coarse < 1e-3 && (1e2..1e4).contains(&(coarse / fine)), "{coarse:e} {fine:e}");
    // 1000^(1/5) = 4 times the evaluations.
    assert!((2.5..6.0).contains(&(many as f64 / few as f64)), "{few} {many}");
}

#[test]
fn an_adaptive_run_rejects_steps_at_a_sudden_change_and_stops_where_none_is_small_enough() {
    // A mass moves freely until its cords become taut.
    let mut model = oscillator(0.0);
    model.cords.iter_mut().for_each(|cord| (cord.rest_length, cord.stiffness) = (4.0, 1e6));
    model.velocities[1] = [0.0, 1.0, 0.0];
    let mut simulation = adaptive(model, &[], 1e-8);
    simulation.reach(10.0, u64::MAX).unwrap();
    assert!(simulation.rejected_count() > 0);
    let error = simulation.ledger().error(&simulation.energy_terms());
    assert!(error.abs() < 1e-4, "{error:e}");
    let mut hopeless = adaptive(damped_chain().0, &[], 1e-300);
    let text = hopeless.reach(1.0, u64::MAX).unwrap_err().to_string();
    assert!(text.contains("no step is small enough"), "{text}");
    assert_eq!(hopeless.time(), 0.0);
}

#[test]
fn a_step_too_large_is_stopped_with_time_place_law_and_remedy() {
    for name in limited() {
        let model = chain(30, 7.0, 0.3, 0.3);
        let mut simulation = simulation(model, &[], name, Some(0.5), Settings::default());
        let text = simulation.step(10_000).unwrap_err().to_string();
        for word in ["t = ", "step ", "node", "tethers", "above the stability limit"] {
            assert!(text.contains(word), "{name}: {text}");
        }
        assert!(simulation.positions().iter().flatten().all(|value| value.is_finite()));
    }
}

#[test]
fn invalid_scenes_and_steps_are_refused() {
    let refuse = |model: Model, laws: &[LawSpec], name: &str, dt: Option<f64>| {
        Simulation::new(model, laws, name, dt, Settings::default()).map(|_| ()).unwrap_err().to_string()
    };
    assert!(refuse(oscillator(0.0), &[], "rk5", None).contains("rk4"));
    for dt in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(refuse(oscillator(0.0), &[], "rk4", Some(dt)).contains("dt"));
    }
    assert!(refuse(oscillator(0.0), &[], "rk4", Some(1e3)).contains("times the stability limit"));
    let without_cords = Model { cords: Vec::new(), ..oscillator(0.0) };
    for name in ["rk4", "leapfrog"] {
        assert!(refuse(without_cords.clone(), &[], name, None).contains("give dt"));
    }
    adaptive(without_cords, &[], 1e-6).reach(1.0, u64::MAX).unwrap();
    let massless = Model { extra_masses: vec![1.0, 0.0, 1.0], ..oscillator(0.0) };
    assert!(refuse(massless, &[], "rk4", None).contains("node 1"));
    let bad = SpringParameters {
        buckling: f64::NAN,
        buckling_on_creases: 1.0,
        buckling_length: None,
        crease_length: None,
        strain_limit: 0.1,
    };
    assert!(refuse(oscillator(0.0), &[LawSpec::Springs(bad)], "rk4", None).contains("buckling"));
}
