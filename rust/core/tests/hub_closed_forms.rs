//! A hub that nothing drives: closed forms.
#![allow(missing_docs, clippy::unwrap_used)]

#[path = "common/hub.rs"]
mod hub;

use std::f64::consts::{PI, TAU};

use hub::{body, momentum, on_axis};
use membrane_core::laws::{LawSpec, SpinParameters, SpoolContactParameters};
use membrane_core::model::input::{Cord, Model};
use membrane_core::model::schedule::Schedule;
use membrane_core::simulation::{Settings, Simulation};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

const SPOOL: f64 = 0.025;

/// Two masses on cords wound on a spool against the spin, and the laws; C = 1 + I/(m R^2) = 41.
fn yo_yo(segments: usize, tip: f64, cord: f64, stiffness: f64) -> (Model, Vec<LawSpec>) {
    let length = 6.35 * SPOOL;
    let step = length / segments as f64;
    let angle = 2.0 * (0.5 * step / SPOOL).asin();
    let mut model = Model::default();
    for side in 0..2 {
        let first = model.positions.len() as u32;
        for k in 0..=segments {
            let azimuth = PI * f64::from(side) - k as f64 * angle;
            model.positions.push([SPOOL * azimuth.cos(), SPOOL * azimuth.sin(), 0.0]);
            let node = first + k as u32;
            if k > 0 {
                let nodes = [node - 1, node];
                model.cords.push(Cord {
                    nodes,
                    stiffness: stiffness / step,
                    rest_length: step,
                    strain_limit: 1.0,
                    ..Default::default()
                });
                model.contacts.nodes.push(node);
            }
            let share = if k == 0 || k == segments { 0.5 } else { 1.0 };
            model.extra_masses.push(share * cord / segments as f64 + if k == segments { tip } else { 0.0 });
        }
        model.fixed.push(first);
    }
    model.velocities = vec![[0.0; 3]; model.positions.len()];
    let contact = SpoolContactParameters { radius: SPOOL, stiffness: 2000.0, half_height: None, membrane: false };
    (model, vec![on_axis(TAU * 3.0, 40.0 * 2.0 * tip * SPOOL * SPOOL).into(), contact.into()])
}

/// Free length of a cord over the radius of the spool, from the place of its mass.
fn unwound(simulation: &Simulation, node: usize) -> f64 {
    let [x, y, _] = simulation.positions()[node];
    ((x * x + y * y) / (SPOOL * SPOOL) - 1.0).max(0.0).sqrt()
}

#[test]
fn a_yo_yo_takes_the_spin_of_its_hub_by_the_length_that_has_unwound() {
    let (segments, ratio) = (60, 41.0);
    let (model, laws) = yo_yo(segments, 0.36e-3, 0.0036e-3, 50.0);
    let mut simulation = Simulation::new(model, &laws, "leapfrog", None, Settings::default()).unwrap();
    let start = momentum(&simulation).z;
    let (mut largest, mut reached) = (0.0_f64, 0.0);
    for k in 1..=31 {
        simulation.reach(0.01 * f64::from(k), u64::MAX).unwrap();
        let f = unwound(&simulation, segments);
        if f > 6.1 {
            break;
        }
        let expected = (ratio - f * f) / (ratio + f * f);
        largest = largest.max((simulation.hub_rate() / (TAU * 3.0) - expected).abs());
        reached = f;
    }
    assert!(reached > 5.5, "{reached}");
    assert!(largest < 2e-3, "{largest}");
    assert!((momentum(&simulation).z / start - 1.0).abs() < 1e-12);
    let ledger = simulation.ledger();
    assert!(ledger.error(&simulation.energy_terms()).abs() < 1e-3);
}

#[test]
fn a_slow_change_of_shape_turns_the_hub_by_its_momentum() {
    // A mass on a spring of no rest length goes slowly to another radius as the hub is turned down by its motor.
    let mut model = Model {
        positions: vec![[0.1, 0.0, 0.0], [0.3, 0.0, 0.0]],
        velocities: vec![[0.0; 3]; 2],
        extra_masses: vec![0.0, 0.01],
        fixed: vec![0],
        cords: vec![Cord {
            nodes: [0, 1],
            stiffness: 40.0,
            rest_length: 0.19,
            strain_limit: 9.0,
            ..Default::default()
        }],
        ..Model::default()
    };
    let (rate, inertia) = (20.0, 5e-4);
    let balanced = |rate: f64| (40.0 * 0.29) / (40.0 - 0.01 * rate * rate);
    model.positions[1][0] = balanced(rate);
    let before = inertia + 0.01 * balanced(rate).powi(2);
    let (ramp, torque) = (20.0, -3e-4);
    let schedule = Schedule::new(vec![0.0, ramp], vec![torque, torque], 0.0).unwrap();
    let spin = SpinParameters { torque: Some(schedule), ..on_axis(rate, inertia) };
    let mut simulation = Simulation::new(model, &[spin.into()], "leapfrog", Some(1e-3), Settings::default()).unwrap();
    simulation.reach(ramp, u64::MAX).unwrap();
    let (after, now) = (simulation.hub_rate(), Vector3::from(simulation.positions()[1]).norm());
    assert!(now < balanced(rate) - 0.01 && after < 0.9 * rate);
    // I w + J w falls by the impulse of the motor, whose work is the change of energy.
    let momentum = (inertia + 0.01 * now * now) * after;
    assert!((momentum / (before * rate + torque * ramp) - 1.0).abs() < 1e-3, "{momentum}");
    assert!((now - balanced(after)).abs() < 2e-3, "{now}");
    let work = simulation.motor_work().unwrap();
    let stored = |radius: f64| 20.0 * (radius - 0.29).powi(2);
    let turning = |rate: f64, radius: f64| 0.5 * (inertia + 0.01 * radius * radius) * rate * rate;
    let change = stored(now) + turning(after, now) - stored(balanced(rate)) - turning(rate, balanced(rate));
    assert!(work < 0.0 && (work / change - 1.0).abs() < 4e-3, "{work} {change}");
}

#[test]
fn the_hub_nutates_with_the_masses_that_it_holds() {
    let (across, along, arm, link, mass) = (61.0, 91.0, 0.8, 6.0, 2.0);
    let reach = arm + link;
    let (ratio, coupling) = (reach / link, mass * reach * reach * arm / (2.0 * link));
    let of =
        |mu: f64| (-across * mu * mu + along * mu + coupling) * ((mu - 1.0).powi(2) - ratio) + coupling * (ratio - 1.0);
    // Roots of the equation of the modes, but for 0.
    let roots: Vec<f64> = (-100..300)
        .map(|k| 0.01 * f64::from(k) + 0.005)
        .filter(|mu| of(*mu) * of(mu + 0.01) < 0.0 && (mu + 0.005).abs() > 0.02)
        .map(|mut low| {
            let mut high = low + 0.01;
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if of(low) * of(middle) <= 0.0 { high = middle } else { low = middle }
            }
            low
        })
        .collect();
    assert_eq!(roots.len(), 3, "{roots:?}");
    let mut model = Model::default();
    let stiffness = 1e5;
    for k in 0..4 {
        let (sine, cosine) = (0.5 * PI * f64::from(k)).sin_cos();
        // Taut at the rate of 1 rad/s.
        let rest = link - 0.25 * mass * reach / stiffness;
        model.positions.extend([[arm * cosine, arm * sine, 0.0], [reach * cosine, reach * sine, 0.0]]);
        model.extra_masses.extend([0.0, 0.25 * mass]);
        let nodes = [2 * k as u32, 2 * k as u32 + 1];
        model.cords.push(Cord { nodes, stiffness, rest_length: rest, strain_limit: 1.0, ..Default::default() });
        model.fixed.push(nodes[0]);
    }
    model.velocities = vec![[0.0; 3]; 8];
    let spin = SpinParameters { tumble: [1e-3 / TAU, 0.0], ..body(1.0, 290.0, [across, along]) };
    let mut simulation = Simulation::new(model, &[spin.into()], "leapfrog", Some(2e-3), Settings::default()).unwrap();
    let (start, time, every) = (momentum(&simulation), 400.0, 50);
    let mut tilt = Vec::new();
    while simulation.time() < time {
        simulation.step(every).unwrap();
        let ([w, x, y, z], _) = simulation.hub_pose();
        let axis = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z)) * Vector3::z();
        tilt.push((simulation.time(), axis.x, axis.y));
    }
    assert!((momentum(&simulation) - start).norm() / start.norm() < 1e-12, "{} {start}", momentum(&simulation) - start);
    let height = |mu: f64| {
        let sum = tilt.iter().fold((0.0, 0.0), |(re, im), (t, x, y)| {
            let (window, (sine, cosine)) = ((PI * t / time).sin().powi(2), (mu * t).sin_cos());
            (re + window * (x * cosine + y * sine), im + window * (y * cosine - x * sine))
        });
        sum.0.hypot(sum.1)
    };
    for root in roots {
        let peak = (-20..=20).map(|k| root + 5e-4 * f64::from(k)).max_by(|a, b| height(*a).total_cmp(&height(*b)));
        assert!((peak.unwrap() - root).abs() < 2.5e-3, "{root} {peak:?}");
    }
}
