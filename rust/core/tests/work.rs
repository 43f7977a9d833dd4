//! Measures of cost without times: allocations of a step, memory of a scene, share of contiguous batches.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;
#[path = "common/sheets.rs"]
mod sheets;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use common::{sail, springs};
use membrane_core::laws::{LawSpec, PressureParameters, Scheme};
use membrane_core::simulation::{Settings, Simulation};
use membrane_core::stability::Limit;
use sheets::{Scene, placed, square, work};

thread_local! {
    /// Bytes that this thread has allocated since its start, and bytes that it has not freed.
    static ALLOCATED: Cell<usize> = const { Cell::new(0) };
    static HELD: Cell<isize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: every call is forwarded unchanged to the system's allocator; counting touches no memory of the blocks.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATED.set(ALLOCATED.get() + layout.size());
        HELD.set(HELD.get() + layout.size() as isize);
        // SAFETY: the caller's contract.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        HELD.set(HELD.get() - layout.size() as isize);
        // SAFETY: the caller's contract.
        unsafe { System.dealloc(place, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

fn simulation(fineness: usize, integrator: &str, settings: Settings) -> Simulation {
    Simulation::new(sail::sail(fineness), &sail::laws(), integrator, Some(1e-7), settings).unwrap()
}

#[test]
fn a_step_allocates_no_memory() {
    for (integrator, substeps, evaluations) in [("rk4", 1, 4), ("leapfrog", 1, 1), ("leapfrog", 4, 4)] {
        let settings = Settings { substeps, check_interval: u64::MAX, ..Settings::default() };
        let mut simulation = simulation(1, integrator, settings);
        // In the first steps exchanges are recorded.
        simulation.step(100).unwrap();
        let (allocated, evaluated) = (ALLOCATED.get(), simulation.evaluation_count());
        simulation.step(20).unwrap();
        assert_eq!(ALLOCATED.get() - allocated, 0, "{integrator}, {substeps} substeps");
        assert_eq!(simulation.evaluation_count() - evaluated, 20 * evaluations, "{integrator}, {substeps} substeps");
    }
}

/// Four light layers between two that are a thousand times as heavy and approach each other, or of which one is held:
/// sweeps do not suffice, so that the nodes become rigid zones. The first list is made anew every 64 steps at least.
fn hammer(is_held: bool) -> Scene {
    const LAYERS: usize = 6;
    let mut scene = Scene::new();
    let (points, triangles) = square(2, 2, 0.011);
    for layer in 0..LAYERS {
        let at = layer as f64;
        let side = [-1.0, 0.0, 1.0][usize::from(layer > 0) + usize::from(layer + 1 == LAYERS)];
        let shift = [1.3e-3 * at, -0.7e-3 * at, 4e-6 * at + 4e-4 * side];
        let velocity = if is_held && layer == 0 { 0.0 } else { -5.0 * side };
        let nodes = scene.add(&placed(&points, 0.0, 0.13 * at, shift), &triangles, [0.0, 0.0, velocity]);
        if side != 0.0 {
            scene.model.extra_masses[nodes.clone()].fill(1e-3);
        }
        if is_held && layer == 0 {
            scene.hold(nodes);
        }
    }
    scene.specs = vec![springs(), LawSpec::SpringDamping(0.02.into())];
    scene.contact.scheme = Scheme { horizons: [16.0, 8.0, 4.0, 2.0], ..Scheme::default() };
    (scene.settings.loss_tolerance, scene.settings.energy_tolerance) = (1e9, 1e9);
    scene.settings.check_interval = u64::MAX;
    scene
}

#[test]
fn a_step_with_contact_allocates_no_memory() {
    for (is_held, substeps) in [(false, 1), (true, 1), (true, 4)] {
        let mut scene = hammer(is_held);
        scene.settings.substeps = substeps;
        let mut simulation = scene.started();
        let [positions, velocities] = [simulation.positions(), simulation.velocities()];
        let mut allocated = usize::MAX;
        // The same motion again and again: what it needs grows in the first ones.
        for _ in 0..5 {
            simulation.start_from(0.0, &[0.0; 14], &positions, &velocities, None, &[]).unwrap();
            // In the first steps exchanges are recorded.
            simulation.step(64).unwrap();
            allocated = 0;
            let rigid = simulation.contact_statistics().rigid;
            for _ in 0..300 {
                let (before, checks) = (ALLOCATED.get(), simulation.contact_statistics().checks);
                simulation.step(1).unwrap();
                // An exact check does.
                let is_checked = simulation.contact_statistics().checks > checks;
                allocated += if is_checked { 0 } else { ALLOCATED.get() - before };
            }
            assert!(simulation.contact_statistics().rigid > rigid);
            assert!(work(&simulation) < 0.0, "{is_held}, {substeps} substeps");
        }
        assert_eq!(allocated, 0, "{is_held}, {substeps} substeps");
    }
}

#[test]
fn a_scene_holds_little_memory() {
    for integrator in ["rk4", "leapfrog"] {
        let before = HELD.get();
        let simulation = simulation(4, integrator, Settings::default());
        let held = HELD.get() - before;
        let model = sail::sail(4);
        // Euler's formula for a ring, and the tethers.
        let springs = sail::node_count(4) + model.triangles.len() + model.cords.len();
        let most = 400 * model.positions.len() + 200 * springs;
        assert!(held as usize <= most, "{integrator}: {held} bytes, more than {most}");
        assert!(simulation.time() == 0.0);
    }
}

#[test]
fn a_load_independent_of_velocity_needs_no_forces_of_its_own() {
    let held = |integrator: &str, pressure: Option<f64>| {
        let (before, model) = (HELD.get(), sail::sail(4));
        let nodes = model.positions.len() as isize;
        let load = pressure.map(|pressure| PressureParameters { pressure, ..Default::default() }.into());
        let laws: Vec<LawSpec> = sail::laws().into_iter().chain(load).collect();
        let simulation = Simulation::new(model, &laws, integrator, Some(1e-7), Settings::default()).unwrap();
        let held = HELD.get() - before;
        assert!(simulation.time() == 0.0);
        (held, nodes)
    };
    let [of_rk4, of_leapfrog] = ["rk4", "leapfrog"].map(|name| held(name, Some(1.0)).0 - held(name, None).0);
    let vector = 24 * held("rk4", None).1;
    assert!((of_leapfrog - of_rk4).abs() < vector / 4, "{of_leapfrog} and {of_rk4} bytes, {vector} per vector");
}

#[test]
fn the_sail_has_contiguous_batches() {
    for (fineness, least) in [(1, 0.97), (4, 0.99)] {
        for law in simulation(fineness, "rk4", Settings::default()).laws() {
            let share = law.inspection().and_then(|law| law.contiguous_share()).unwrap_or(1.0);
            assert!(share >= least || law.name() == "tethers", "{}: {share}", law.name());
        }
    }
}

#[test]
fn a_known_limit_is_not_computed_again() {
    let new = |known: Option<Limit>| {
        let before = ALLOCATED.get();
        let simulation = sail::simulation(sail::sail(1), "rk4", None, Settings::default(), known);
        (simulation, ALLOCATED.get() - before)
    };
    let (found, allocated) = new(None);
    let limit = found.limit().unwrap();
    let (known, less) = new(Some(limit.clone()));
    assert_eq!((known.dt(), known.limit().unwrap()), (found.dt(), limit.clone()));
    assert!(less < allocated / 6, "{less} bytes, {allocated} where the limit is computed");
    // It is not checked.
    let (doubled, _) = new(Some(Limit { dt: 2.0 * limit.dt, ..limit }));
    assert!((doubled.dt() / found.dt() - 2.0).abs() < 0.02, "{} {}", doubled.dt(), found.dt());
}
