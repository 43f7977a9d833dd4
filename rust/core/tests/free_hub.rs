//! A hub that nothing drives: closed forms, momentum, orders, and what it does not go with.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;
#[path = "common/hub.rs"]
mod hub;

use std::f64::consts::TAU;

use common::{Dice, acts_by_impulses, sheet, springs};
use hub::{body, linear, momentum, on_axis};
use membrane_core::error::Error;
use membrane_core::laws::{
    AirDragParameters, AirMotion, LawParameters, LawSpec, SolarPressureParameters, SpinParameters,
};
use membrane_core::model::input::{Bridges, Model};
use membrane_core::model::schedule::Schedule;
use membrane_core::simd::dispatch::InstructionSet;
use membrane_core::simulation::{Settings, Simulation};
use nalgebra::Vector3;

/// A crumpled sheet of which one corner and the end of its tether are held, in motion.
fn sail(specs: &[LawSpec], integrator: &str, dt: f64, settings: Settings) -> Simulation {
    let mut model = sheet(6, 4, 0.01);
    let mut dice = Dice(5);
    for (point, kick) in model.positions.iter_mut().zip(dice.vectors(100, 2e-4)) {
        *point = [point[0] + 0.05 + kick[0], point[1] + kick[1], point[2] + kick[2]];
    }
    model.velocities = dice.vectors(model.positions.len(), 0.2);
    model.fixed = vec![model.positions.len() as u32 - 1, 6];
    Simulation::new(model, specs, integrator, Some(dt), Settings { loss_tolerance: 0.5, ..settings }).unwrap()
}

/// A taut sheet with a held rim, whose forces are smooth functions of positions.
fn taut(specs: &[LawSpec], integrator: &str, dt: f64) -> Simulation {
    let mut model = sheet(6, 4, 0.01);
    model.positions.iter_mut().for_each(|p| *p = [1.004 * p[0] + 0.05, 1.004 * p[1], 0.1 * p[0]]);
    model.velocities = Dice(3).vectors(model.positions.len(), 0.02);
    (model.cords, model.bridges) = (Vec::new(), Bridges::default());
    model.fixed = (0..36).filter(|node| node % 7 == 0 || node % 7 == 6 || !(7..28).contains(node)).collect();
    let settings = Settings { loss_tolerance: 0.5, ..Settings::default() };
    Simulation::new(model, specs, integrator, Some(dt), settings).unwrap()
}

#[test]
fn momentum_is_kept_to_rounding_by_leapfrog_and_to_its_order_by_rk4() {
    for spin in [on_axis(20.0, 1e-5), body(20.0, 0.02, [0.6e-5, 1e-5])] {
        let spin = SpinParameters { tumble: spin.mass.map_or([0.0; 2], |_| [0.3, -0.2]), ..spin };
        let laws = [springs(), LawSpec::SpringDamping(0.02.into()), spin.clone().into()];
        let drift = |integrator: &str, dt: f64| {
            let mut simulation = sail(&laws, integrator, dt, Settings::default());
            let (before, along) = (momentum(&simulation), spin.mass.map(|mass| linear(&simulation, mass)));
            simulation.step((0.01 / dt) as u64).unwrap();
            let apart = (momentum(&simulation) - before).norm() / before.norm();
            let moved = spin.mass.zip(along).map_or(0.0, |(mass, along)| (linear(&simulation, mass) - along).norm());
            let on_axis = (momentum(&simulation) - before).z.abs() / before.z.abs();
            assert!(moved < 1e-7 || integrator == "rk4", "{moved}");
            if spin.mass.is_some() { apart.max(moved) } else { on_axis }
        };
        assert!(drift("leapfrog", 1e-6) < 1e-12, "{spin:?}: {}", drift("leapfrog", 1e-6));
        let [coarse, fine] = [2e-6, 1e-6].map(|dt| drift("rk4", dt));
        assert!(fine < 1e-7 && coarse > 8.0 * fine, "{spin:?}: {coarse} {fine}");
    }
}

#[test]
fn methods_agree_on_the_motion_at_their_orders() {
    for spin in [on_axis(20.0, 1e-5), body(20.0, 0.02, [0.6e-5, 1e-5])] {
        let laws = [springs(), spin.into()];
        let motion = |integrator: &str, dt: f64| {
            let mut simulation = taut(&laws, integrator, dt);
            simulation.step((1e-4 / dt).round() as u64).unwrap();
            let mut all: Vec<f64> = simulation.positions().concat();
            all.extend(simulation.hub_state());
            all
        };
        let best = motion("rk4", 2.5e-8);
        let error = |integrator: &str, dt: f64| {
            motion(integrator, dt).iter().zip(&best).fold(0.0_f64, |largest, (a, b)| largest.max((a - b).abs()))
        };
        let [first, second] = [1e-7, 5e-8].map(|dt| error("leapfrog", dt));
        assert!((first / second - 4.0).abs() < 0.4, "leapfrog: {first} {second}");
        let [first, second] = [5e-7, 2.5e-7].map(|dt| error("rk4", dt));
        assert!(first / second > 12.0, "rk4: {first} {second}");
    }
}

#[test]
fn a_heavy_hub_is_a_driven_one() {
    let run = |spin: SpinParameters, integrator: &str| {
        let laws = [springs(), LawSpec::SpringDamping(0.02.into()), spin.into()];
        let mut simulation = taut(&laws, integrator, 1e-6);
        simulation.step(3000).unwrap();
        (simulation.positions(), simulation.ledger().error(&simulation.energy_terms()))
    };
    let driven = SpinParameters { frequency: 20.0 / TAU, ..SpinParameters::default() };
    for integrator in ["leapfrog", "rk4"] {
        let (expected, error) = run(driven.clone(), integrator);
        for heavy in [on_axis(20.0, 1e6), body(20.0, 1e6, [1e6, 1e6])] {
            let (found, own) = run(heavy, integrator);
            let apart = found.iter().zip(&expected).map(|(a, b)| (Vector3::from(*a) - Vector3::from(*b)).norm());
            let apart = apart.fold(0.0, f64::max);
            assert!(apart < 1e-9, "{integrator}: {apart}");
            assert!((own - error).abs() < 1e-4, "{integrator}: {own} {error}");
        }
    }
}

#[test]
fn the_energy_is_balanced_where_held_nodes_are_parts_of_the_hub() {
    // A mass vibrates against a light hub with a heavy held node: mostly this node takes its torque.
    for spin in [on_axis(20.0, 1e-6), body(20.0, 0.002, [0.6e-6, 1e-6])] {
        let model = Model {
            positions: vec![[0.1, 0.0, 0.0]; 2],
            velocities: vec![[0.0; 3], [0.0, 0.1, 0.0]],
            extra_masses: vec![2e-3, 1e-3],
            fixed: vec![0],
            bridges: Bridges { nodes: vec![[0, 1]], stiffness: 1000.0 },
            ..Model::default()
        };
        let settings = Settings { loss_tolerance: 0.5, ..Settings::default() };
        let mut simulation = Simulation::new(model, &[spin.into()], "rk4", Some(1e-6), settings).unwrap();
        let (mut change, mut error) = (0.0_f64, 0.0_f64);
        for _ in 0..40 {
            simulation.step(100).unwrap();
            change = change.max((simulation.hub_rate() - 20.0).abs());
            error = error.max(simulation.ledger().error(&simulation.energy_terms()).abs());
        }
        assert!(change > 0.1 && error < 1e-6, "{change} {error}");
    }
}

#[test]
fn air_at_rest_takes_momentum_and_its_work_balances_the_energy() {
    let air = AirDragParameters { pressure: 4000.0, temperature: 293.0, air: AirMotion::Still };
    for integrator in ["leapfrog", "rk4"] {
        for rate in [60.0, 0.0] {
            let laws = [springs(), air.into(), on_axis(rate, 1e-5).into()];
            let mut simulation = sail(&laws, integrator, 2.5e-7, Settings::default());
            let (before, terms) = (momentum(&simulation).z, simulation.energy_terms());
            simulation.step(40_000).unwrap();
            let now = simulation.energy_terms();
            let work: f64 = simulation.ledger().of_laws().iter().sum();
            assert!(work < 0.0 && ((now.total() - terms.total()) / work - 1.0).abs() < 2e-2, "{integrator} {rate}");
            assert!((momentum(&simulation).z - before).abs() > 1e-9, "{integrator} {rate}");
        }
    }
}

#[test]
fn sunlight_changes_momentum_by_its_torque_and_its_work_balances_the_energy() {
    // At 1 kPa, so that it stands out beside the motion at the start.
    let light = SolarPressureParameters { sun: [1.0, 0.3, 0.4], distance: 1e7, ..SolarPressureParameters::example() };
    for integrator in ["leapfrog", "rk4"] {
        let laws = [springs(), light.clone().into(), on_axis(60.0, 1e-5).into()];
        let mut simulation = taut(&laws, integrator, 2.5e-7);
        let (start, terms) = (momentum(&simulation).z, simulation.energy_terms());
        let mut impulse = 0.0;
        for part in 0..=8000 {
            if part > 0 {
                simulation.step(1).unwrap();
            }
            let (places, forces) = (simulation.positions(), simulation.forces(Some("solar_pressure")).unwrap());
            let torque: f64 = places.iter().zip(&forces).map(|(x, f)| x[0] * f[1] - x[1] * f[0]).sum();
            // By Simpson's rule.
            let weight = if part % 8000 == 0 { 1.0 } else { f64::from(2 + 2 * (part % 2)) };
            impulse += weight * torque * 2.5e-7 / 3.0;
        }
        let change = momentum(&simulation).z - start;
        assert!(change.abs() > 1e-8 && (change / impulse - 1.0).abs() < 1e-8, "{integrator}: {change} {impulse}");
        let work: f64 = simulation.ledger().of_laws().iter().sum();
        let gained = simulation.energy_terms().total() - terms.total();
        assert!(work.abs() > 1e-5 && (gained / work - 1.0).abs() < 1e-4, "{integrator}: {gained} {work}");
    }
}

#[test]
fn a_run_goes_on_with_the_same_bits_in_pieces_at_every_width_and_past_outputs() {
    let torque = Schedule::new(vec![0.0, 1.03e-4, 1.03e-4, 2e-4], vec![1e-4, 1e-4, -2e-4, 0.0], 0.0).unwrap();
    for spin in [on_axis(20.0, 1e-5), body(20.0, 0.02, [0.6e-5, 1e-5])] {
        let laws = [springs(), SpinParameters { torque: Some(torque.clone()), ..spin }.into()];
        for integrator in ["leapfrog", "rk4"] {
            let new = |instructions| sail(&laws, integrator, 1e-6, Settings { instructions, ..Settings::default() });
            let mut whole = new(InstructionSet::Baseline);
            whole.reach(3.004e-4, u64::MAX).unwrap();
            let mut cut = new(InstructionSet::widest());
            for time in [0.3e-6, 1.7e-6, 5e-5, 1.03e-4, 1.5005e-4, 3.004e-4] {
                cut.reach(time, u64::MAX).unwrap();
                let saved = cut.progress();
                cut.forces(None).unwrap();
                let rate = cut.hub_rate();
                cut = new(InstructionSet::widest());
                cut.resume(&saved).unwrap();
                assert_eq!((cut.progress(), cut.hub_rate()), (saved, rate), "{integrator} {time}");
            }
            assert_eq!(cut.progress(), whole.progress(), "{integrator}");
            // A motion that is set leaves the hub as it turns.
            let (positions, velocities, rate) = (cut.positions(), cut.velocities(), cut.hub_rate());
            cut.set_motion(&positions, &velocities).unwrap();
            assert_eq!(cut.hub_rate(), rate);
            let mut lost = whole.progress();
            lost.law_histories.clear();
            assert_eq!(cut.resume(&lost), Err(Error::HistoryMisfit { owner: "spin" }));
            assert_eq!(cut.hub_rate(), rate);
        }
    }
}

#[test]
fn a_light_hub_shortens_the_step() {
    // A mass linked to a place on the hub vibrates across the arm r with omega^2 = k (1/m + r^2/I).
    let (mass, arm) = (1e-3, 0.1);
    let new = |inertia: f64, dt: Option<f64>| {
        let model = Model {
            positions: vec![[arm, 0.0, 0.0]; 2],
            velocities: vec![[0.0; 3], [0.0, 0.1, 0.0]],
            extra_masses: vec![0.0, mass],
            fixed: vec![0],
            bridges: Bridges { nodes: vec![[0, 1]], stiffness: 100.0 },
            ..Model::default()
        };
        Simulation::new(model, &[on_axis(0.0, inertia).into()], "leapfrog", dt, Settings::default()).unwrap()
    };
    let limit = new(mass * arm * arm, None).start_limit().dt;
    assert!((limit / (2.0 / (2.0_f64 * 100.0 / mass).sqrt()) - 1.0).abs() < 1e-6, "{limit}");
    new(mass * arm * arm, Some(0.98 * limit)).step(3000).unwrap();
    assert!(new(mass * arm * arm, Some(1.02 * limit)).step(3000).is_err());
    new(1e3, Some(1.02 * limit)).step(3000).unwrap();
}

#[test]
fn the_forces_of_the_frame_are_those_that_hold_the_nodes_on_the_hub() {
    // In the frame, forces give the change of the relative velocities.
    for spin in [on_axis(20.0, 1e-5), body(20.0, 0.02, [0.6e-5, 1e-5])] {
        let laws = [springs(), spin.into()];
        let mut simulation = sail(&laws, "rk4", 1e-8, Settings::default());
        let (forces, before) = (simulation.forces(None).unwrap(), simulation.velocities());
        simulation.step(1).unwrap();
        let (after, masses) = (simulation.velocities(), simulation.masses());
        for node in (0..masses.len()).filter(|node| ![6, masses.len() - 1].contains(node)) {
            for k in 0..3 {
                let expected = forces[node][k] / masses[node];
                let found = (after[node][k] - before[node][k]) / 1e-8;
                assert!((found - expected).abs() < 1e-3 * (1.0 + expected.abs()), "{node} {k}: {found} {expected}");
            }
        }
    }
}

#[test]
fn what_does_not_go_with_a_free_hub_is_refused() {
    let refusal = |specs: &[LawSpec], integrator: &str, settings: Settings| {
        let mut model = sheet(2, 2, 0.01);
        model.fixed = vec![0];
        Simulation::new(model, specs, integrator, Some(1e-6), settings).err().map(|error| error.to_string())
    };
    let (axis, free) = (on_axis(20.0, 1e-5), body(20.0, 0.02, [0.6e-5, 1e-5]));
    let with = |more: LawSpec, spin: &SpinParameters| vec![springs(), more, spin.clone().into()];
    let alone = |spin: SpinParameters| vec![springs(), spin.into()];
    let cases = [
        (alone(axis.clone()), "dopri5", Settings::default(), "the method dopri5"),
        (alone(axis.clone()), "generalized_alpha", Settings::default(), "the method generalized_alpha"),
        (alone(axis.clone()), "leapfrog", Settings { substeps: 2, ..Settings::default() }, "substeps = 2"),
        (alone(axis.clone()), "rk4", Settings { frozen_at: Some(0.0), ..Settings::default() }, "a frozen time"),
        (
            alone(SpinParameters { inertia: Some(0.0), ..axis.clone() }),
            "rk4",
            Settings::default(),
            "inertia of the hub",
        ),
        (
            alone(SpinParameters { acceleration: 1.0, ..axis.clone() }),
            "rk4",
            Settings::default(),
            "follows from its inertia",
        ),
        (alone(SpinParameters { mass: None, ..free.clone() }), "rk4", Settings::default(), "six degrees of freedom"),
        (alone(SpinParameters { tumble: [0.1, 0.0], ..axis.clone() }), "rk4", Settings::default(), "about x or y"),
        (alone(body(1.0, 1.0, [1.0, 2.1])), "rk4", Settings::default(), "twice the transverse"),
    ];
    for (specs, integrator, settings, expected) in cases {
        let found = refusal(&specs, integrator, settings);
        assert!(found.as_ref().is_some_and(|text| text.contains(expected)), "{expected}: {found:?}");
    }
    let goes: Vec<LawSpec> =
        LawSpec::examples().into_iter().filter(|law| law.film().is_none() && !acts_by_impulses(law)).collect();
    for spin in [&axis, &free] {
        for law in goes.iter().filter(|law| !matches!(law, LawSpec::Spin(_))) {
            assert_eq!(refusal(&with(law.clone(), spin), "leapfrog", Settings::default()), None);
        }
    }
}
