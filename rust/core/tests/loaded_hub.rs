//! Loads from outside on a hub in six degrees of freedom: closed forms, momentum, energy, orders.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;
#[path = "common/hub.rs"]
mod hub;

use std::f64::consts::TAU;

use common::{Dice, sheet, springs};
use hub::{body, linear, momentum, on_axis};
use membrane_core::laws::{
    AirDragParameters, AirMotion, CordDragParameters, ForceFrame, GravityParameters, LawParameters, LawSpec,
    MassDampingParameters, PointForcesParameters, PressureParameters, SolarPressureParameters, SpinParameters,
};
use membrane_core::model::input::{Bridges, Model};
use membrane_core::model::schedule::Schedule;
use membrane_core::simulation::{Settings, Simulation};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

const HUB: f64 = 2e-3;
const SIDE: f64 = 0.04;

/// A light hub that tumbles.
fn light() -> SpinParameters {
    SpinParameters { tumble: [0.3, -0.2], ..body(20.0, HUB, [0.6e-6, 1e-6]) }
}

/// A taut square sheet about the axis with a held rim, and a cord to one of its nodes.
fn net(speed: f64) -> Model {
    let mut model = sheet(4, 4, 0.25 * SIDE);
    let middle = 0.5 * SIDE;
    model.positions[25] = [-0.7 * SIDE, 0.0, 0.0];
    model.positions.iter_mut().for_each(|p| *p = [1.004 * (p[0] - middle), 1.004 * (p[1] - middle), p[2]]);
    model.velocities = Dice(3).vectors(model.positions.len(), speed);
    model.bridges = Bridges::default();
    (model.cords[0].nodes, model.cords[0].rest_length) = ([25, 12], 1.19 * SIDE);
    model.fixed = (0..25).filter(|node| node % 5 == 0 || node % 5 == 4 || !(5..20).contains(node)).collect();
    model.fixed.push(25);
    model.loaded = vec![3, 11, 18];
    model
}

fn start(model: Model, laws: &[LawSpec], integrator: &str, dt: f64) -> Simulation {
    let settings = Settings { loss_tolerance: 0.5, ..Settings::default() };
    Simulation::new(model, laws, integrator, Some(dt), settings).unwrap()
}

fn pull(force: [f64; 3], frame: ForceFrame) -> PointForcesParameters {
    PointForcesParameters { force, frame, ..PointForcesParameters::default() }
}

/// Light at 10 Pa.
fn sunlight(sun: [f64; 3]) -> SolarPressureParameters {
    SolarPressureParameters { sun, distance: 1e8, ..SolarPressureParameters::example() }
}

/// Loads from outside, strong beside the motion, each with its name.
fn loads() -> Vec<(&'static str, LawSpec)> {
    let factor = Schedule::new(vec![0.0, 1e-3], vec![0.5, 1.5], 0.5).unwrap();
    let half = Schedule::new(vec![0.0, 1e-3], vec![0.5, 0.5], 0.0).unwrap();
    let weight = GravityParameters { acceleration: [30.0, -20.0, 50.0], ..GravityParameters::default() };
    let air = AirDragParameters { pressure: 1e5, temperature: 293.0, air: AirMotion::Still };
    let cords = CordDragParameters { diameter: 1e-2, coefficient: 1.1, density: 1.2, air: AirMotion::Still };
    vec![
        ("point_forces", pull([2e-2, 1e-2, -3e-2], ForceFrame::Inertial).into()),
        ("point_forces", pull([2e-2, 1e-2, -3e-2], ForceFrame::Turning).into()),
        ("pressure", PressureParameters { pressure: 10.0, ..PressureParameters::default() }.into()),
        ("solar_pressure", sunlight([0.7, 0.3, 0.6]).into()),
        ("gravity", weight.clone().into()),
        ("gravity", GravityParameters { factor: factor.into(), ..weight.clone() }.into()),
        ("air_drag", air.into()),
        ("cord_drag", cords.into()),
        ("gravity", GravityParameters { factor: half.into(), ..weight }.into()),
    ]
}

/// From components of the hub to those in space, and the origin in space.
fn pose(simulation: &Simulation) -> (UnitQuaternion<f64>, Vector3<f64>) {
    let [_, w, x, y, z, a, b, c, ..] = simulation.hub_state();
    (UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z)), Vector3::new(a, b, c))
}

/// Force, and torque about the point from which the displacement of the origin counts, of a law in space.
fn in_space(simulation: &mut Simulation, law: &str) -> [Vector3<f64>; 2] {
    let (attitude, origin) = pose(simulation);
    let (places, forces) = (simulation.positions(), simulation.forces(Some(law)).unwrap());
    let mut sums = [Vector3::zeros(); 2];
    let mut add = |place: Vector3<f64>, force: Vector3<f64>| {
        let force = attitude * force;
        sums[0] += force;
        sums[1] += (origin + attitude * place).cross(&force);
    };
    places.iter().zip(&forces).for_each(|(place, force)| add((*place).into(), (*force).into()));
    if law == "gravity" {
        // That of the hub, by the acceleration of any node.
        add(Vector3::zeros(), Vector3::from(forces[12]) * (HUB / simulation.masses()[12]));
    }
    sums
}

#[test]
fn momentum_changes_by_the_impulse_of_each_load() {
    let dt = 5e-7;
    for (name, load) in loads() {
        for integrator in ["leapfrog", "rk4"] {
            let laws = [springs(), load.clone(), light().into()];
            let mut simulation = start(net(0.02), &laws, integrator, dt);
            let before = [linear(&simulation, HUB), momentum(&simulation)];
            let mut impulse = [Vector3::zeros(); 2];
            let steps = 1000;
            for step in 0..=steps {
                if step > 0 {
                    simulation.step(1).unwrap();
                }
                // Leapfrog has the rule of trapezoids itself; that of Simpson for rk4.
                let weight = match (integrator, step) {
                    ("leapfrog", _) => {
                        if step % steps == 0 {
                            0.5
                        } else {
                            1.0
                        }
                    }
                    _ => {
                        if step % steps == 0 {
                            1.0 / 3.0
                        } else {
                            f64::from(2 + 2 * (step % 2)) / 3.0
                        }
                    }
                };
                let loads = in_space(&mut simulation, name);
                (0..2).for_each(|k| impulse[k] += loads[k] * (weight * dt));
            }
            let after = [linear(&simulation, HUB), momentum(&simulation)];
            // Drag is evaluated with predicted velocities by leapfrog.
            let tolerance = match (integrator, name) {
                ("leapfrog", "air_drag" | "cord_drag") => 1e-3,
                ("leapfrog", _) => 1e-10,
                // |S . V| has kinks, where the rule of Simpson is of lower order.
                (_, "air_drag") => 1e-5,
                _ => 1e-7,
            };
            for k in 0..2 {
                let size = impulse[k].norm() + 1e-3 * before[k].norm();
                let error = (after[k] - before[k] - impulse[k]).norm() / size;
                assert!(
                    impulse[k].norm() > 1e-12 && error < tolerance,
                    "{name} {integrator} {k}: {error:e} {impulse:?}"
                );
            }
        }
    }
}

#[test]
fn the_work_of_each_load_closes_the_balance_at_the_order_of_the_method() {
    let between = [
        ("mass_damping", MassDampingParameters { rate: 300.0 }.into()),
        ("air_drag", AirDragParameters { pressure: 1e5, temperature: 293.0, air: AirMotion::Turning }.into()),
    ];
    for (name, load) in loads().into_iter().chain(between) {
        for (integrator, least) in [("leapfrog", 3.6), ("rk4", 14.0)] {
            let residual = |dt: f64| {
                let mut simulation = start(net(0.02), &[springs(), load.clone(), light().into()], integrator, dt);
                let terms = simulation.energy_terms();
                simulation.step((5e-4 / dt).round() as u64).unwrap();
                let now = simulation.energy_terms();
                let exchanged = simulation.ledger().reference_energy(&now);
                let work: f64 = simulation.ledger().of_laws().iter().sum();
                ((now.total() - terms.total() - work) / exchanged).abs()
            };
            let [coarse, fine] = [2e-6, 1e-6].map(residual);
            assert!(
                fine < 1e-2 && (coarse > least * fine || coarse < 1e-9),
                "{name} {integrator}: {coarse:e} {fine:e}"
            );
        }
    }
}

#[test]
fn methods_agree_on_the_motion_in_flight_at_their_orders() {
    let laws: Vec<LawSpec> =
        [springs(), light().into()].into_iter().chain(loads().into_iter().map(|(_, load)| load)).collect();
    let laws: Vec<LawSpec> =
        laws.into_iter().filter(|law| !matches!(law, LawSpec::AirDrag(_) | LawSpec::CordDrag(_))).collect();
    // One law of each kind.
    let laws = [&laws[..3], &laws[4..7]].concat();
    let motion = |integrator: &str, dt: f64| {
        let mut simulation = start(net(0.02), &laws, integrator, dt);
        simulation.step((2e-4 / dt).round() as u64).unwrap();
        let mut all: Vec<f64> = simulation.positions().concat();
        all.extend(simulation.hub_state());
        all
    };
    let best = motion("rk4", 5e-8);
    let error = |integrator: &str, dt: f64| {
        motion(integrator, dt).iter().zip(&best).fold(0.0_f64, |largest, (a, b)| largest.max((a - b).abs()))
    };
    let [first, second] = [2e-7, 1e-7].map(|dt| error("leapfrog", dt));
    assert!((first / second - 4.0).abs() < 0.4, "leapfrog: {first:e} {second:e}");
    let [first, second] = [1e-6, 5e-7].map(|dt| error("rk4", dt));
    assert!(first / second > 12.0, "rk4: {first:e} {second:e}");
}

#[test]
fn a_heavy_body_bears_loads_as_a_hub_on_its_axis() {
    let between = [
        ("mass_damping", MassDampingParameters { rate: 300.0 }.into()),
        (
            "cord_drag",
            CordDragParameters { diameter: 1e-2, coefficient: 1.1, density: 1.2, air: AirMotion::Turning }.into(),
        ),
    ];
    for (name, load) in loads().into_iter().chain(between).filter(|(name, _)| *name != "gravity") {
        for integrator in ["leapfrog", "rk4"] {
            let run = |spin: SpinParameters| {
                let mut simulation = start(net(0.02), &[springs(), load.clone(), spin.into()], integrator, 1e-6);
                simulation.step(500).unwrap();
                let work = simulation.ledger().of_laws().to_vec();
                (simulation.positions(), simulation.hub_rate(), work)
            };
            let (expected, rate, work) = run(on_axis(20.0, 1e-6));
            let (found, own, done) = run(body(20.0, 1e9, [1e9, 1e-6]));
            let apart = found.iter().zip(&expected).map(|(a, b)| (Vector3::from(*a) - Vector3::from(*b)).norm());
            let apart = apart.fold(0.0, f64::max);
            assert!(apart < 1e-10 && (own / rate - 1.0).abs() < 1e-8, "{name} {integrator}: {apart:e} {own} {rate}");
            let of = |works: &[f64]| works[1];
            assert!((of(&done) / of(&work) - 1.0).abs() < 1e-6, "{name} {integrator}: {done:?} {work:?}");
        }
    }
}

#[test]
fn a_constant_force_moves_the_centre_of_mass_as_a_point() {
    let force = Vector3::new(2e-2, 1e-2, -3e-2);
    let laws = [springs(), pull(force.into(), ForceFrame::Inertial).into(), light().into()];
    let mut simulation = start(net(0.02), &laws, "leapfrog", 1e-6);
    let mass = HUB + simulation.masses().iter().sum::<f64>();
    let centre = |simulation: &Simulation| {
        let (attitude, origin) = pose(simulation);
        let places = simulation.positions();
        let of_nodes: Vector3<f64> = simulation.masses().iter().zip(places).map(|(m, x)| *m * Vector3::from(x)).sum();
        origin + attitude * of_nodes / mass
    };
    let (place, velocity) = (centre(&simulation), linear(&simulation, HUB) / mass);
    simulation.step(4000).unwrap();
    let time = simulation.time();
    let expected = place + velocity * time + 3.0 * force * (0.5 * time * time / mass);
    let moved = expected - place;
    assert!(moved.norm() > 1e-5 && (centre(&simulation) - expected).norm() < 1e-12 * (1.0 + moved.norm()), "{moved}");
}

#[test]
fn in_a_uniform_field_the_whole_falls_and_moves_as_without() {
    let field = [30.0, -20.0, 50.0];
    for integrator in ["leapfrog", "rk4"] {
        let run = |g: [f64; 3]| {
            let weight = GravityParameters { acceleration: g, ..GravityParameters::default() };
            let mut simulation = start(net(0.02), &[springs(), weight.into(), light().into()], integrator, 1e-6);
            simulation.step(2000).unwrap();
            simulation
        };
        let (falling, flying) = (run(field), run([0.0; 3]));
        let apart = falling
            .positions()
            .concat()
            .iter()
            .zip(flying.positions().concat())
            .fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        assert!(apart < 1e-11, "{integrator}: {apart:e}");
        let fallen =
            pose(&falling).1 - pose(&flying).1 - Vector3::from(field) * (0.5 * falling.time() * falling.time());
        assert!(fallen.norm() < 1e-11, "{integrator}: {fallen}");
        let turned = pose(&falling).0.angle_to(&pose(&flying).0);
        assert!(turned < 1e-7, "{integrator}: {turned:e}");
    }
}

#[test]
fn sunlight_along_the_axis_of_a_flat_sail_is_a_thrust() {
    // A black film takes the momentum of the light on its projection, which the held rim bounds.
    let black = SolarPressureParameters {
        front_specular: 0.0,
        front_diffuse: 0.0,
        front_emissivity: 1.0,
        back_emissivity: 1.0,
        front_lambert: 0.5,
        back_lambert: 0.5,
        factor: Default::default(),
        ..sunlight([0.0, 0.0, 1.0])
    };
    let pressure = 4.56e-6 * (149_597_870_700.0_f64 / 1e8).powi(2);
    let laws = [springs(), black.into(), body(20.0, HUB, [0.6e-6, 1e-6]).into()];
    let mut simulation = start(net(0.0), &laws, "leapfrog", 1e-6);
    let before = linear(&simulation, HUB);
    simulation.step(2000).unwrap();
    let thrust = (linear(&simulation, HUB) - before) / simulation.time();
    let expected = -pressure * (1.004 * SIDE).powi(2);
    assert!(
        (thrust.z / expected - 1.0).abs() < 1e-9 && thrust.xy().norm() < 1e-9 * thrust.z.abs(),
        "{thrust} {expected}"
    );
    assert!(pose(&simulation).1.z < -1e-5);
}

#[test]
fn a_spun_hub_precesses_by_the_torque_over_its_angular_momentum() {
    // The rate is met exactly at whole periods of the nutation, but for terms of second order.
    let (rate, [across, along], height, force) = (50.0, [0.8, 1.0], 0.1, 0.2);
    let mut model = Model { loaded: vec![0], fixed: vec![0], ..Model::default() };
    model.positions = vec![[0.0, 0.0, height], [0.01, 0.0, height]];
    model.velocities = vec![[0.0; 3]; 2];
    model.extra_masses = vec![0.0, 1e-9];
    model.bridges = Bridges { nodes: vec![[0, 1]], stiffness: 1e-4 };
    let laws = [pull([force, 0.0, 0.0], ForceFrame::Inertial).into(), body(rate, 2.0, [across, along]).into()];
    for integrator in ["leapfrog", "rk4"] {
        let mut simulation = start(model.clone(), &laws, integrator, 1e-4);
        let time = 10.0 * TAU * across / (along * rate);
        simulation.reach(time, u64::MAX).unwrap();
        let (attitude, origin) = pose(&simulation);
        let axis = attitude * Vector3::z();
        let expected = height * force / (along * rate) * time;
        assert!(expected > 4e-4 && (axis.y / expected - 1.0).abs() < 1e-3, "{integrator}: {} {expected}", axis.y);
        assert!(axis.x.abs() < 1e-3 * expected, "{integrator}: {}", axis.x);
        assert!((origin.x / (0.5 * force / 2.0 * time * time) - 1.0).abs() < 1e-6, "{integrator}: {origin}");
    }
}

#[test]
fn a_falling_sail_reaches_the_speed_at_which_the_air_bears_its_weight() {
    let gravity = GravityParameters { acceleration: [0.0, 0.0, -9.81], ..GravityParameters::default() };
    let air = AirDragParameters { pressure: 1e5, temperature: 293.0, air: AirMotion::Still };
    let spin = body(0.0, HUB, [0.6e-6, 1e-6]);
    for integrator in ["leapfrog", "rk4"] {
        let laws = [springs(), gravity.clone().into(), air.into(), spin.clone().into()];
        let mut simulation = start(net(0.0), &laws, integrator, 2e-6);
        let mass = HUB + simulation.masses().iter().sum::<f64>();
        let density = 1e5 / (287.0 * 293.0);
        let last = (2.0 * mass * 9.81 / (density * (1.004 * SIDE).powi(2))).sqrt();
        let time: f64 = 0.4;
        simulation.reach(time, u64::MAX).unwrap();
        let speed = -(linear(&simulation, HUB) / mass).z;
        let expected = last * (9.81 * time / last).tanh();
        assert!((speed / expected - 1.0).abs() < 1e-3, "{integrator}: {speed} {expected} {last}");
    }
}
