//! Every law in the list against its stated properties: power, work class, dependence on velocity, momentum.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use std::collections::BTreeSet;

use common::toys::WearingFriction;
use common::{
    Bench, Dice, acts_by_impulses, creases, every_form, every_law, every_law_with, films, gravity, law_sets, methods,
    sheet, simulation_of, spin,
};
use membrane_core::arrays::state::{NodeVectors, State};
use membrane_core::assembly::Assembly;
use membrane_core::integrators::METHODS;
use membrane_core::laws::{
    CreaseParameters, ForceFrame, GravityParameters, Kernels, Law, LawParameters, LawSpec, NodalLaw,
    PointForcesParameters, PressureParameters, Properties, SolarPressureParameters, WorkClass, spin_of,
};
use membrane_core::model::factor::Factor;
use membrane_core::model::input::{Bridges, Model};
use membrane_core::model::schedule::Schedule;
use membrane_core::simulation::{Settings, Setup, Simulation};

/// The sum of |a| |b|, component by component.
fn size_of(a: &NodeVectors, b: &NodeVectors) -> f64 {
    a.abs().dot(&b.abs())
}

/// Residual of P = F . v + dU/dt along the motion, and its scale [W].
fn power_residual(bench: &mut Bench, row: usize) -> (f64, f64) {
    let (time, start) = (bench.time, bench.state.clone());
    let (forces, power) = bench.evaluate(row, time, &start);
    let step = 1e-8;
    let energy = |s: f64| {
        let state = State { positions: &start.positions + &start.velocities * s, velocities: start.velocities.clone() };
        let at = membrane_core::laws::Instant::new(state.at(time + s), &bench.spin);
        bench.laws[row].energy(at)
    };
    // Fourth-order central difference.
    let rate = (8.0 * (energy(step) - energy(-step)) - (energy(2.0 * step) - energy(-2.0 * step))) / (12.0 * step);
    let scale = size_of(&forces, &start.velocities) + 1e-9 * energy(0.0).abs() / step;
    assert!(forces.amax() > 0.0, "{} exerts no force in this test", bench.laws[row].name());
    (power - forces.dot(&start.velocities) - rate, scale)
}

#[test]
fn the_power_of_every_law_is_that_of_its_forces_and_of_its_energy() {
    for (seed, laws) in (0..6).flat_map(|seed| law_sets().map(move |laws| (seed, laws))) {
        let of_kind = if seed < 3 { Bench::crumpled } else { Bench::patched };
        let mut bench = of_kind(&laws, seed, 0.004);
        for row in 0..bench.laws.len() {
            for direction in 0..4 {
                bench.state.velocities = bench.vectors(1000 * seed + direction, 1.0);
                // Also at a frozen instant, at which no potential changes by itself.
                bench.spin.frozen_at = (direction % 2 == 1).then_some(0.7);
                let (residual, scale) = power_residual(&mut bench, row);
                let name = bench.laws[row].name();
                assert!(residual.abs() <= 1e-6 * scale, "{name}, seed {seed}: {residual:e} of {scale:e} W");
            }
        }
    }
}

#[test]
fn the_work_of_every_law_is_of_its_class() {
    let (mut conservative, mut storing) = (BTreeSet::new(), BTreeSet::new());
    for (seed, laws) in (0..20).flat_map(|seed| law_sets().map(move |laws| (seed, laws))) {
        let mut bench = Bench::crumpled(&laws, seed, 0.004);
        let (time, state) = (bench.time, bench.state.clone());
        for row in 0..bench.laws.len() {
            let (_, power) = bench.evaluate(row, time, &state);
            let Properties { name, work_class, .. } = bench.laws[row].properties();
            let energy = bench.laws[row].energy(bench.instant());
            match work_class {
                WorkClass::Conservative => conservative.insert(name),
                WorkClass::Dissipative => {
                    assert!(power < 0.0, "{name} gains {power:e} W");
                    false
                }
                WorkClass::External => false,
            };
            if energy != 0.0 {
                storing.insert(name);
            }
        }
    }
    assert_eq!(conservative, storing, "laws with a potential, and laws that store energy");
}

#[test]
fn every_law_depends_on_velocity_as_stated() {
    for film in films() {
        let mut bench = Bench::crumpled(&every_law_with(film), 7, 0.004);
        let (time, state) = (bench.time, bench.state.clone());
        let other = State { velocities: bench.vectors(8, 2.0), positions: state.positions.clone() };
        for row in 0..bench.laws.len() {
            let Properties { name, depends_on_velocity, .. } = bench.laws[row].properties();
            let [forces, moved] = [&state, &other].map(|state| bench.evaluate(row, time, state).0);
            assert_eq!(forces != moved, depends_on_velocity, "{name}");
        }
    }
}

#[test]
fn every_internal_law_conserves_total_momentum_and_no_other_does() {
    for film in films() {
        let mut bench = Bench::crumpled(&every_law_with(film), 7, 0.004);
        let (time, state) = (bench.time, bench.state.clone());
        let x = &state.positions;
        for row in 0..bench.laws.len() {
            let Properties { name, is_internal, .. } = bench.laws[row].properties();
            let (forces, _) = bench.evaluate(row, time, &state);
            let size = forces.abs().sum();
            let off = (0..3).map(|axis| {
                let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
                let torque = x.column(i).dot(&forces.column(j)) - x.column(j).dot(&forces.column(i));
                (forces.column(axis).sum() / size, torque / (0.1 * size))
            });
            let worst = off.fold(0.0, |most: f64, (force, torque)| most.max(force.abs()).max(torque.abs()));
            assert_eq!(worst < 1e-12, is_internal, "{name}: {worst:e}");
        }
    }
}

#[test]
fn a_law_with_three_times_its_power_is_found() {
    let mut bench = Bench::crumpled(&every_law(), 1, 0.004);
    let row = bench.laws.len() - 1;
    assert_eq!(bench.laws[row].name(), "wearing_friction");
    let (residual, scale) = power_residual(&mut bench, row);
    assert!(residual.abs() <= 1e-6 * scale);
    let mut faulty = WearingFriction::new(&bench.assembly);
    faulty.fault = 3.0;
    bench.laws[row] = Box::new(faulty);
    let (residual, scale) = power_residual(&mut bench, row);
    assert!(residual.abs() > 1e-2 * scale, "{residual:e} of {scale:e} W");
}

/// A sheet in smooth motion with vibrations, without buckling, which would make it chaotic.
fn moving() -> Model {
    let mut model = sheet(4, 3, 0.01);
    model.positions.iter_mut().for_each(|p| *p = [1.002 * p[0] + 0.04, 1.002 * p[1], 0.1 * p[0]]);
    model.velocities = Dice(3).vectors(model.positions.len(), 0.05);
    model
}

#[test]
fn every_law_works_with_every_method_and_restarts_with_the_same_bits() {
    // Each law of force with each film, and a law with a history outside the list.
    for (film, law) in films().flat_map(|film| {
        let others = every_form().filter(|law| law.film().is_none() && !acts_by_impulses(law));
        others.map(move |law| (film.clone(), law))
    }) {
        let laws = [film, law];
        let mut works: Vec<(&str, Vec<f64>)> = Vec::new();
        for (method, substeps) in methods().map(|method| (method, 1)).chain([(METHODS[1], 2)]) {
            let settings = Settings { substeps, loss_tolerance: 1.0, energy_tolerance: 1.0, ..Settings::default() };
            let (dt, steps) = (1e-7 * f64::from(substeps), 120 / u64::from(substeps));
            let new = || {
                simulation_of(moving(), &laws, method, Some(dt), settings, |assembly| {
                    vec![Box::new(WearingFriction::new(assembly))]
                })
            };
            let (mut whole, mut first, mut second) = (new(), new(), new());
            whole.step(steps).unwrap();
            first.step(steps / 3).unwrap();
            second.resume(&first.progress()).unwrap();
            second.step(steps - steps / 3).unwrap();
            assert_eq!(whole.progress(), second.progress(), "{}, {}", laws[1].kind(), method.name);
            let (wear, start) = (&whole.progress().law_histories, &new().progress().law_histories);
            assert!(wear.last() != start.last(), "the history has not changed");
            works.push((method.name, whole.ledger().work.clone()));
        }
        let (_, known) = works[0].clone();
        for (method, found) in works {
            for (row, (found, known)) in found.iter().zip(&known).enumerate() {
                let off = (found - known).abs();
                let name = laws[1].kind();
                assert!(off <= 3e-2 * known.abs(), "{name}, {method}, row {row}: work of {found:e}, not {known:e}");
            }
        }
    }
}

#[test]
fn internal_laws_do_not_resist_a_rigid_motion_of_the_flat_sheet() {
    let mut model = sheet(4, 3, 0.01);
    let axis = [0.3, -0.5, 0.8];
    let (sine, cosine) = 0.7_f64.sin_cos();
    for (position, velocity) in model.positions.iter_mut().zip(&mut model.velocities) {
        // Rotation about z and translation; velocity of a translation and a rotation about `axis`.
        let p = [cosine * position[0] - sine * position[1] + 0.4, sine * position[0] + cosine * position[1], -0.2];
        *position = p;
        *velocity =
            [axis[1] * p[2] - axis[2] * p[1] + 1.0, axis[2] * p[0] - axis[0] * p[2], axis[0] * p[1] - axis[1] * p[0]];
    }
    // The scale: the force of the film at a strain of one.
    let scale = common::FILM.youngs_modulus * common::FILM.thickness * 0.01;
    for film in films() {
        let laws = [film, LawSpec::SpringDamping(0.02.into())];
        let mut bench = Bench::new(Model { cords: Vec::new(), bridges: Bridges::default(), ..model.clone() }, &laws);
        let (time, state) = (bench.time, bench.state.clone());
        for row in (0..bench.laws.len()).filter(|&row| bench.laws[row].properties().is_internal).collect::<Vec<_>>() {
            let most = bench.evaluate(row, time, &state).0.amax();
            assert!(most < 1e-11 * scale, "{}: {most:e}", bench.laws[row].name());
        }
    }
    // Flat creases have moments towards their natural angle, but the energy of the flat sheet before the motion.
    let energy = |model: Model| {
        let bench = Bench::new(model, &[creases(1.0)]);
        bench.laws[0].energy(bench.instant())
    };
    assert!((energy(model) / energy(sheet(4, 3, 0.01)) - 1.0).abs() < 1e-12);
}

#[test]
fn a_law_that_is_there_twice_is_refused_by_name() {
    let build = |laws: &[LawSpec]| Simulation::new(sheet(2, 2, 0.01), laws, "rk4", Some(1e-12), Settings::default());
    for film in films() {
        let once = every_law_with(film);
        for law in &once {
            let error = build(&[once.clone(), vec![law.clone()]].concat()).err().unwrap().to_string();
            assert!(error.contains(&format!("law {} is there twice", law.kind())), "{error}");
        }
    }
}

#[test]
fn two_laws_for_the_film_are_refused_by_name() {
    let both: Vec<LawSpec> = films().collect();
    let build = Simulation::new(sheet(2, 2, 0.01), &both, "rk4", Some(1e-12), Settings::default());
    let error = build.err().unwrap().to_string();
    assert!(error.contains("springs and triangles are both"), "{error}");
}

/// A nodal law that states elements too.
struct Mixed(WearingFriction);

impl Law for Mixed {
    fn properties(&self) -> Properties {
        self.0.properties()
    }

    fn kernels(&self) -> Kernels {
        Kernels::of_elements()
    }

    fn nodal(&mut self) -> Option<&mut dyn NodalLaw> {
        self.0.nodal()
    }

    fn remedy(&self) -> &'static str {
        self.0.remedy()
    }
}

#[test]
fn a_nodal_law_with_elements_is_refused_by_name() {
    for method in methods() {
        let assembly = Assembly::new(sheet(2, 2, 0.01), Settings::default().instructions).unwrap();
        let laws: Vec<Box<dyn Law>> = vec![Box::new(Mixed(WearingFriction::new(&assembly)))];
        let setup = Setup { assembly, laws, spin: spin_of(&[]), method, dt: Some(1e-9), limit: None };
        let error = Simulation::with(setup, Settings::default()).err().unwrap().to_string();
        assert!(error.contains("law wearing_friction is nodal"), "{error}");
    }
}

#[test]
fn an_unknown_parameter_of_a_law_is_refused_by_name() {
    let read = |text: &str| serde_json::from_str::<LawSpec>(text);
    assert!(read(r#"{"kind": "mass_damping", "rate": 1.0}"#).is_ok());
    let error = read(r#"{"kind": "spring_damping", "ratio": 0.1, "lenght": 0.01}"#).unwrap_err().to_string();
    assert!(error.contains("lenght"), "{error}");
}

#[test]
fn an_invalid_length_scale_of_the_creases_is_refused() {
    for length in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let LawSpec::Creases(parameters) = creases(1.0) else { unreachable!("creases are creases") };
        let law = LawSpec::Creases(CreaseParameters { length_scale: Some(length), ..parameters });
        let error = Simulation::new(sheet(2, 2, 0.01), &[law], "rk4", Some(1e-6), Settings::default()).err().unwrap();
        assert!(error.to_string().contains("length scale of the creases"), "{error}");
    }
}

#[test]
fn a_scene_has_no_law_that_is_left_out() {
    let mut simulation =
        Simulation::new(sheet(2, 2, 0.01), &[common::springs()], "rk4", None, Settings::default()).unwrap();
    let names: Vec<_> = simulation.laws().iter().map(|law| law.name()).collect();
    assert_eq!(names, ["springs", "tethers", "bridges"]);
    let error = simulation.forces(Some("creases")).unwrap_err().to_string();
    assert!(error.contains("springs, tethers, bridges"), "{error}");
}

#[test]
fn the_name_in_the_list_is_that_of_the_law() {
    for law in every_law() {
        let simulation =
            Simulation::new(sheet(2, 2, 0.01), std::slice::from_ref(&law), "rk4", Some(1e-9), Settings::default());
        assert_eq!(simulation.unwrap().laws()[0].name(), law.kind());
    }
}

#[test]
fn the_turning_frame_gives_the_motion_of_the_fixed_one() {
    // A stretched sheet in free motion, in the fixed frame and in an accelerated one.
    let turning_frame = spin(30.0, 40.0);
    let hub = spin_of(std::slice::from_ref(&turning_frame));
    let mut model = sheet(3, 2, 0.01);
    model.positions.iter_mut().for_each(|p| *p = [1.001 * p[0] + 0.05, 1.001 * p[1], 0.2 * p[0]]);
    model.velocities = Dice(5).vectors(model.positions.len(), 0.1);
    let light = LawSpec::examples().into_iter().find(|law| law.kind() == "solar_pressure").unwrap();
    let laws = [common::springs(), creases(2.0), gravity([1.0, -2.0, -9.81]), light];
    let run = |model: &Model, laws: &[LawSpec]| {
        let mut simulation = Simulation::new(model.clone(), laws, "rk4", Some(1e-7), Settings::default()).unwrap();
        simulation.step(2000).unwrap();
        simulation
    };
    let fixed = run(&model, &laws);
    let mut turning_model = model.clone();
    for (v, p) in turning_model.velocities.iter_mut().zip(&model.positions) {
        *v = [v[0] + hub.rate * p[1], v[1] - hub.rate * p[0], v[2]];
    }
    let turning = run(&turning_model, &[&laws[..], &[turning_frame]].concat());
    let (sine, cosine) = hub.at(turning.time()).angle.sin_cos();
    for (p, q) in turning.positions().iter().zip(fixed.positions()) {
        let seen = [cosine * p[0] - sine * p[1], sine * p[0] + cosine * p[1], p[2]];
        (0..3).for_each(|axis| assert!((seen[axis] - q[axis]).abs() < 1e-12, "{seen:?} {q:?}"));
    }
    for simulation in [&fixed, &turning] {
        let error = simulation.ledger().error(&simulation.energy_terms());
        assert!(error.abs() < 1e-3, "energy balance {error:e}");
    }
}

#[test]
fn the_balance_closes_where_loads_change_with_time_by_themselves_and_at_jumps() {
    // A hanging sheet off the axis of a hub that speeds up; the factor rises, jumps, and falls.
    let film = films().next().unwrap();
    let mut model = sheet(4, 3, 0.01);
    model.positions.iter_mut().for_each(|p| *p = [1.01 * p[0] + 0.03, 1.01 * p[1], 0.2 * p[0]]);
    (model.cords, model.bridges) = (Vec::new(), Bridges::default());
    (model.fixed, model.loaded) = (vec![0, 1, 2, 3, 4, 20], vec![17, 12]);
    let schedule = Schedule::new(vec![0.0, 4e-5, 4e-5, 1e-4], vec![0.5, 1.0, -2.0, 3.0], 0.2).unwrap();
    let factor = Factor::from(schedule);
    let loads: [LawSpec; 4] = [
        GravityParameters { acceleration: [3e3, -2e3, -4e3], factor: factor.clone() }.into(),
        PressureParameters { pressure: 500.0, factor: factor.clone() }.into(),
        SolarPressureParameters { distance: 1e7, factor: factor.clone(), ..SolarPressureParameters::example() }.into(),
        PointForcesParameters { force: [0.1, -0.2, 0.4], frame: ForceFrame::Inertial, factor }.into(),
    ];
    for load in loads {
        for method in METHODS {
            let laws = [film.clone(), load.clone(), spin(30.0, 400.0)];
            let run = |dt: f64| {
                let settings = Settings { loss_tolerance: 1.0, energy_tolerance: 1.0, ..Settings::default() };
                let mut simulation = Simulation::new(model.clone(), &laws, method.name, Some(dt), settings).unwrap();
                simulation.reach(1e-4, u64::MAX).unwrap();
                let now = simulation.energy_terms();
                (simulation.ledger().error(&now).abs(), simulation.ledger().work[1], simulation.ledger().changes[2])
            };
            let ((coarse, ..), (fine, work, change)) = (run(2e-7), run(1e-7));
            let name = format!("{}, {}", load.kind(), method.name);
            assert!(work.abs() > 1e-5, "{name}: {work:e}");
            assert_eq!(change, 0.0, "{name}");
            assert!(fine < 3e-5 && (fine < 0.9 * coarse || fine < 5e-6), "{name}: {coarse:e} {fine:e}");
        }
    }
}
