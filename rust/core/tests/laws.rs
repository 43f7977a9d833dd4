//! Every law in the list: force = -dU/dx, rigid motions cost nothing, no force or torque from inside, work = power.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use common::{Dice, creases, every_law, every_law_with, films, sheet};
use membrane_core::arrays::state::{Instant, NodeVectors};
use membrane_core::assembly::Assembly;
use membrane_core::laws::{self, CreaseParameters, LawSpec, Spin};
use membrane_core::simd::dispatch::InstructionSet;
use membrane_core::simulation::{Settings, Simulation};

/// A sheet of 4 x 3 squares of 1 cm of this film, every law on, crumpled by `size`.
fn crumpled(film: LawSpec, seed: u64, size: f64) -> Simulation {
    let mut dice = Dice(seed);
    let mut model = sheet(4, 3, 0.01);
    for (point, kick) in model.positions.iter_mut().zip(dice.vectors(100, size)) {
        (0..3).for_each(|axis| point[axis] += kick[axis]);
    }
    model.velocities = dice.vectors(model.positions.len(), 1.0);
    Simulation::new(model, &every_law_with(film), "rk4", Some(1e-12), Settings::default()).unwrap()
}

fn energy(simulation: &Simulation, law: usize) -> f64 {
    simulation.energy_terms().stored[law]
}

fn dot(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| a * b).sum()
}

#[test]
fn every_conservative_force_is_the_gradient_of_its_energy() {
    let mut tested = 0;
    for (seed, film) in (0..6).flat_map(|seed| films().map(|(_, film)| (seed, film))) {
        let mut simulation = crumpled(film, seed, 0.004);
        let (x, rest) = (simulation.positions(), vec![[0.0; 3]; simulation.positions().len()]);
        // At rest, so that velocity-dependent forces (Coriolis) are silent.
        simulation.set_motion(&x, &rest).unwrap();
        let names: Vec<_> = simulation.laws().iter().map(|law| (law.name(), law.is_conservative())).collect();
        for (k, (name, conservative)) in names.into_iter().enumerate() {
            if !conservative {
                continue;
            }
            let mut forces = simulation.forces(Some(name)).unwrap();
            if name == "spin" {
                // The Euler force has no potential: compare what is left without it.
                let euler: Vec<[f64; 3]> =
                    x.iter().zip(simulation.masses()).map(|(p, m)| [-2.0 * m * p[1], 2.0 * m * p[0], 0.0]).collect();
                forces.iter_mut().zip(euler).for_each(|(f, e)| (0..3).for_each(|axis| f[axis] -= e[axis]));
            }
            for direction in 0..4 {
                let way = Dice(1000 * seed + direction).vectors(x.len(), 1.0);
                let step = 1e-8;
                let mut at = |s: f64| {
                    let moved: Vec<[f64; 3]> =
                        x.iter().zip(&way).map(|(p, w)| [0, 1, 2].map(|axis| p[axis] + s * w[axis])).collect();
                    simulation.set_motion(&moved, &rest).unwrap();
                    energy(&simulation, k)
                };
                // Fourth-order central difference.
                let slope = (8.0 * (at(step) - at(-step)) - (at(2.0 * step) - at(-2.0 * step))) / (12.0 * step);
                let work = dot(&forces, &way);
                let size = forces.iter().flatten().map(|f| f.abs()).sum::<f64>();
                assert!(
                    (slope + work).abs() <= 1e-6 * size + 1e-13,
                    "{name}, seed {seed}: dU = {slope:e}, -F.d = {:e}",
                    -work
                );
                assert!(size > 0.0, "{name} exerts no force in this test");
                tested += 1;
            }
            simulation.set_motion(&x, &rest).unwrap();
        }
    }
    assert_eq!(tested, 2 * 6 * 4 * 7);
}

#[test]
fn internal_laws_leave_no_force_and_no_torque() {
    let cases = films().into_iter().flat_map(|(name, film)| {
        [name, "spring_damping", "creases", "tethers", "bridges"].map(|name| (name, film.clone()))
    });
    for (name, film) in cases {
        let simulation = crumpled(film, 7, 0.004);
        let x = simulation.positions();
        let forces = simulation.forces(Some(name)).unwrap();
        let size: f64 = forces.iter().flatten().map(|f| f.abs()).sum();
        assert!(size > 0.0, "{name} exerts no force in this test");
        for axis in 0..3 {
            let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
            let force: f64 = forces.iter().map(|f| f[axis]).sum();
            let torque: f64 = x.iter().zip(&forces).map(|(p, f)| p[i] * f[j] - p[j] * f[i]).sum();
            assert!(force.abs() < 1e-12 * size, "{name} pushes");
            assert!(torque.abs() < 1e-13 * size, "{name} turns");
        }
    }
}

#[test]
fn a_rigid_motion_of_the_flat_sheet_meets_no_resistance() {
    let model = sheet(4, 3, 0.01);
    let axis = [0.3, -0.5, 0.8];
    let (sine, cosine) = 0.7_f64.sin_cos();
    let turned = |p: [f64; 3]| {
        // Turn about z, shift; velocity = translation + rotation about `axis`.
        [cosine * p[0] - sine * p[1] + 0.4, sine * p[0] + cosine * p[1], p[2] - 0.2]
    };
    let positions: Vec<_> = model.positions.iter().map(|&p| turned(p)).collect();
    let velocities: Vec<_> = positions
        .iter()
        .map(|p| {
            [axis[1] * p[2] - axis[2] * p[1] + 1.0, axis[2] * p[0] - axis[0] * p[2], axis[0] * p[1] - axis[1] * p[0]]
        })
        .collect();
    // What the same film bears at a strain of one, as the measure of nothing.
    let strong = common::FILM.youngs_modulus * common::FILM.thickness * 0.01;
    let cases = films().into_iter().flat_map(|(name, film)| [name, "spring_damping"].map(|name| (name, film.clone())));
    for (name, film) in cases {
        let laws = every_law_with(film);
        let mut simulation = Simulation::new(model.clone(), &laws, "rk4", Some(1e-12), Settings::default()).unwrap();
        simulation.set_motion(&positions, &velocities).unwrap();
        let forces = simulation.forces(Some(name)).unwrap();
        let most = forces.iter().flatten().fold(0.0, |most: f64, f| most.max(f.abs()));
        assert!(most < 1e-11 * strong, "{name}: {most:e}");
    }
    // Flat creases pull towards their natural angle, but their energy is that of the flat sheet before the motion.
    let mut simulation = Simulation::new(model, &every_law(), "rk4", Some(1e-12), Settings::default()).unwrap();
    simulation.set_motion(&positions, &velocities).unwrap();
    let flat = Simulation::new(sheet(4, 3, 0.01), &every_law(), "rk4", Some(1e-12), Settings::default()).unwrap();
    assert!((energy(&simulation, 2) / energy(&flat, 2) - 1.0).abs() < 1e-12);
}

#[test]
fn the_power_of_each_law_is_what_its_forces_do() {
    for (_, film) in films() {
        let mut simulation = crumpled(film, 3, 0.004);
        // The laws' own energy term over one tiny step, against F.v at its start.
        let expected: Vec<(&str, f64)> = ["spring_damping", "air_drag", "mass_damping"]
            .map(|name| (name, dot(&simulation.forces(Some(name)).unwrap(), &simulation.velocities())))
            .to_vec();
        simulation.step(1).unwrap();
        let dt = simulation.dt();
        for (name, power) in expected {
            let k = simulation.laws().iter().position(|law| law.name() == name).unwrap();
            let done = simulation.ledger().work[k] / dt;
            assert!(power != 0.0 && (done / power - 1.0).abs() < 1e-2, "{name}: {done} {power}");
            if name != "air_drag" {
                assert!(power < 0.0, "{name} must take energy out");
            }
        }
    }
}

#[test]
fn what_a_law_remembers_gives_the_power_of_its_forces_on_other_velocities() {
    let mut tested = 0;
    for with_springs in [true, false] {
        // Dashpots go through one pass with the springs, or through their own.
        let specs: Vec<LawSpec> =
            every_law().into_iter().filter(|spec| with_springs || !matches!(spec, LawSpec::Springs(_))).collect();
        let assembly = Assembly::new(sheet(4, 3, 0.01), InstructionSet::widest()).unwrap();
        let mut laws = laws::build(&specs, &assembly).unwrap();
        let cached: Vec<usize> = (0..laws.len()).filter(|&row| laws[row].caches_forces()).collect();
        let nodes = assembly.masses.len();
        let mut dice = Dice(7);
        let [rest, moved] = [1.0, 1.0].map(|size| assembly.layout.internal_vectors(&dice.vectors(nodes, size)));
        let positions = assembly.layout.internal_vectors(&assembly.model.positions);
        let at = |velocities| Instant { time: 0.0, positions: &positions, velocities };
        let (mut all, mut powers) = (NodeVectors::zeros(nodes), vec![0.0; laws.len()]);
        membrane_core::evaluation::damped_springs::add_all(&laws, at(&rest), &mut all, &mut powers);
        for row in cached {
            assert!(!laws[row].is_conservative());
            let recomputed = laws[row].power_at(at(&moved));
            let mut own = NodeVectors::zeros(nodes);
            laws[row].add_forces(at(&rest), &mut own);
            let expected = own.dot(&moved);
            let scale = own.abs().dot(&moved.abs());
            assert!((recomputed - expected).abs() <= 1e-12 * scale, "{}: {recomputed} {expected}", laws[row].name());
            tested += 1;
        }
    }
    assert_eq!(tested, 2);
}

#[test]
fn stiffness_and_damping_products_are_the_slopes_of_the_forces() {
    // A flat sheet at rest, taut: the forces are linear to first order in what moves and how fast.
    let model = sheet(4, 3, 0.01);
    let way = Dice(11).vectors(model.positions.len(), 1.0);
    for (name, film) in films() {
        let laws = [film, LawSpec::SpringDamping(0.02.into())];
        let assembly = Assembly::new(model.clone(), InstructionSet::widest()).unwrap();
        let built = laws::build(&laws, &assembly).unwrap();
        // Stretched a little, so that nothing buckles within the step of the difference.
        let start: Vec<_> = model.positions.iter().map(|p| [1.001 * p[0], 1.001 * p[1], 0.0]).collect();
        let at_rest = assembly.layout.internal_vectors(&vec![[0.0; 3]; start.len()]);
        let flat: Vec<_> = way.iter().map(|w| [w[0], w[1], 0.0]).collect();
        let (x, p) = (assembly.layout.internal_vectors(&start), assembly.layout.internal_vectors(&flat));
        for (law, is_stiffness) in [(0, true), (1, false)] {
            let force = |s: f64| {
                let (positions, velocities) =
                    if is_stiffness { (&x + &p * s, at_rest.clone()) } else { (x.clone(), &p * s) };
                let mut out = NodeVectors::zeros(start.len());
                built[law].add_forces(Instant { time: 0.0, positions: &positions, velocities: &velocities }, &mut out);
                out
            };
            let step = 1e-7;
            let slope = (force(-step) - force(step)) / (2.0 * step);
            let mut product = NodeVectors::zeros(start.len());
            let at = Instant { time: 0.0, positions: &x, velocities: &at_rest };
            if is_stiffness {
                built[law].add_stiffness_product(at, &p, &mut product);
            } else {
                built[law].add_damping_product(at, &p, &mut product);
            }
            // The geometric part, of the order of the strain, is left out of the stiffness.
            let (apart, size) = ((&slope - &product).norm(), product.norm());
            assert!(size > 0.0 && apart < 5e-3 * size, "{name}, law {law}: {apart:e} of {size:e}");
        }
    }
}

#[test]
fn a_law_that_is_there_twice_is_refused_by_name() {
    let build = |laws: &[LawSpec]| Simulation::new(sheet(2, 2, 0.01), laws, "rk4", Some(1e-12), Settings::default());
    for (_, film) in films() {
        let once = every_law_with(film);
        for law in &once {
            let name = build(std::slice::from_ref(law)).unwrap().laws()[0].name();
            let error = build(&[once.clone(), vec![law.clone()]].concat()).err().unwrap().to_string();
            assert!(error.contains(&format!("law {name} is there twice")), "{error}");
        }
    }
}

#[test]
fn a_length_beside_the_crease_that_is_none_is_refused() {
    for length in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let LawSpec::Creases(parameters) = creases(1.0) else { unreachable!("creases are creases") };
        let law = LawSpec::Creases(CreaseParameters { length_scale: Some(length), ..parameters });
        let error = Simulation::new(sheet(2, 2, 0.01), &[law], "rk4", Some(1e-6), Settings::default()).err().unwrap();
        assert!(error.to_string().contains("length scale of the creases"), "{error}");
    }
}

#[test]
fn a_law_that_is_left_out_exerts_nothing() {
    let simulation =
        Simulation::new(sheet(2, 2, 0.01), &[common::springs()], "rk4", None, Settings::default()).unwrap();
    let names: Vec<_> = simulation.laws().iter().map(|law| law.name()).collect();
    assert_eq!(names, ["springs", "tethers", "bridges"]);
    let error = simulation.forces(Some("creases")).unwrap_err().to_string();
    assert!(error.contains("springs, tethers, bridges"), "{error}");
}

#[test]
fn the_turning_frame_gives_the_motion_of_the_fixed_one() {
    // A stretched sheet that flies and turns: once in the fixed frame, once in one that turns and speeds up.
    let spin = Spin { rate: 30.0, acceleration: 40.0 };
    let mut model = sheet(3, 2, 0.01);
    model.positions.iter_mut().for_each(|p| *p = [1.001 * p[0] + 0.05, 1.001 * p[1], 0.2 * p[0]]);
    model.velocities = Dice(5).vectors(model.positions.len(), 0.1);
    let laws = [common::springs(), common::creases(2.0), common::gravity()];
    let run = |model: &membrane_core::model::input::Model, laws: &[LawSpec]| {
        let mut simulation = Simulation::new(model.clone(), laws, "rk4", Some(1e-7), Settings::default()).unwrap();
        simulation.step(2000).unwrap();
        simulation
    };
    let fixed = run(&model, &laws);
    let mut turning_model = model.clone();
    for (v, p) in turning_model.velocities.iter_mut().zip(&model.positions) {
        *v = [v[0] + spin.rate * p[1], v[1] - spin.rate * p[0], v[2]];
    }
    let turning = run(&turning_model, &[&laws[..], &[LawSpec::Spin(spin)]].concat());
    let (sine, cosine) = spin.angle_at(turning.time()).sin_cos();
    for (p, q) in turning.positions().iter().zip(fixed.positions()) {
        let seen = [cosine * p[0] - sine * p[1], sine * p[0] + cosine * p[1], p[2]];
        (0..3).for_each(|axis| assert!((seen[axis] - q[axis]).abs() < 1e-12, "{seen:?} {q:?}"));
    }
    for simulation in [&fixed, &turning] {
        let error = simulation.ledger().error(&simulation.energy_terms());
        assert!(error.abs() < 1e-3, "energy balance {error:e}");
    }
}
