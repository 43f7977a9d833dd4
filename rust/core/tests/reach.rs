//! The nodes that each law reads for a tile: none at its bound or above, and none before the tile.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use common::toys::SEMI_IMPLICIT_EULER;
use common::{Dice, acts_by_impulses, every_form, films, sheet, simulation_of};
use membrane_core::arrays::blocks::{TILE, row_blocks, rows_of, tiles};
use membrane_core::arrays::history::History;
use membrane_core::arrays::state::{NodeVectors, State, rows, rows_mut};
use membrane_core::integrators::{Integrator, Method, Options, Properties, System};
use membrane_core::laws::LawSpec;
use membrane_core::model::input::{Bridges, Cord, Model};
use membrane_core::simulation::Settings;

/// A method that evaluates each step twice: with all rows, and tile by tile with only those that a tile may read.
const TWO_EVALUATIONS: Method = Method {
    name: "two_evaluations",
    make: |options: &Options| {
        let evaluation = || Evaluation {
            accelerations: NodeVectors::zeros(options.nodes),
            powers: vec![0.0; options.works],
            exact_powers: vec![0.0; options.works],
        };
        let other = (SEMI_IMPLICIT_EULER.make)(options);
        Box::new(TwoEvaluations { whole: evaluation(), hidden: evaluation(), first_reach: 0, other })
    },
};

/// Accelerations, the power of each law, and that of laws along links on the corrected velocities.
struct Evaluation {
    accelerations: NodeVectors,
    powers: Vec<f64>,
    exact_powers: Vec<f64>,
}

impl Evaluation {
    /// Evaluates the system tile by tile, each with its own state.
    fn run(&mut self, system: &mut dyn System, time: f64, state_of: impl Fn(&dyn System, usize) -> State) {
        let Self { accelerations, powers, exact_powers } = self;
        let count = accelerations.nrows();
        for tile in tiles(count) {
            let state = state_of(system, tile);
            system.accumulate_forces(tile, state.at(time), powers);
            for range in row_blocks(rows_of(tile, count)) {
                system.accelerations(range.clone(), state.at(time), rows_mut(accelerations, range.clone()), powers);
                system.row_power_at(range.clone(), rows(&state.velocities, range), powers);
            }
            system.power_of_tile(tile, state.at(time), exact_powers);
        }
    }
}

struct TwoEvaluations {
    whole: Evaluation,
    hidden: Evaluation,
    /// The bound of the first tile.
    first_reach: usize,
    other: Box<dyn Integrator>,
}

impl Integrator for TwoEvaluations {
    fn properties(&self) -> Properties {
        Properties { name: "two_evaluations", predicts_velocity: true, ..self.other.properties() }
    }

    fn amplification(&self, omega: f64, damping: f64, dt: f64) -> f64 {
        self.other.amplification(omega, damping, dt)
    }

    fn step(&mut self, system: &mut dyn System, time: f64, _dt: f64, state: &mut State, _work: &mut [f64]) {
        self.first_reach = system.reach(0);
        self.whole.run(system, time, |_, _| state.clone());
        let count = state.positions.nrows();
        self.hidden.run(system, time, |system, tile| {
            let mut read = state.clone();
            let own = rows_of(tile, count);
            let reach = system.reach(tile).clamp(own.end, count);
            for vectors in [&mut read.positions, &mut read.velocities] {
                for hidden in [0..own.start, reach..count] {
                    rows_mut(vectors, hidden).into_iter().for_each(|column| column.fill(f64::NAN));
                }
            }
            read
        });
    }

    /// The results of both evaluations, and the bound of the first tile.
    fn history(&self) -> History {
        let both = [&self.whole, &self.hidden];
        let powers =
            both.iter().flat_map(|evaluation| evaluation.powers.iter().chain(&evaluation.exact_powers)).copied();
        History {
            numbers: powers.chain([self.first_reach as f64]).collect(),
            vectors: both.map(|evaluation| evaluation.accelerations.clone()).to_vec(),
        }
    }
}

/// A crumpled sheet of three tiles in motion at a height \[m\], without tethers and bridges.
fn film_of_three_tiles(height: f64) -> Model {
    let mut model = sheet(79, 59, 0.01);
    let kicks = Dice(1).vectors(model.positions.len(), 2e-4);
    for (point, kick) in model.positions.iter_mut().zip(kicks) {
        (0..3).for_each(|axis| point[axis] += kick[axis]);
        point[2] += height;
    }
    let velocities = Dice(2).vectors(model.positions.len(), 0.1);
    Model { velocities, cords: Vec::new(), bridges: Bridges::default(), ..model }
}

/// The nodes of that sheet, with tethers or bridges alone: each joins two nodes with one between them.
fn nets_of_three_tiles() -> [Model; 2] {
    let Model { positions, velocities, .. } = film_of_three_tiles(0.0);
    let nodes: Vec<[u32; 2]> = (2..positions.len() as u32).map(|node| [node - 2, node]).collect();
    let bare = Model { extra_masses: vec![1.0; positions.len()], positions, velocities, ..Model::default() };
    let cord = |nodes: &[u32; 2]| Cord {
        nodes: *nodes,
        stiffness: 50.0,
        rest_length: 0.005,
        strain_limit: 1e9,
        ..Default::default()
    };
    let cords = nodes.iter().map(cord).collect();
    [Model { cords, ..bare.clone() }, Model { bridges: Bridges { nodes, stiffness: 3.0 }, ..bare }]
}

/// Every law of force alone; damping with each film, whose elements it has; drag of cords with cords.
fn scenes() -> impl Iterator<Item = (Model, Vec<LawSpec>)> {
    let forces = every_form().filter(|law| !acts_by_impulses(law));
    let of_film = forces.flat_map(|law| match law {
        LawSpec::SpringDamping(_) => films().map(|film| vec![film, law.clone()]).collect(),
        _ => vec![vec![law]],
    });
    let nets = nets_of_three_tiles().into_iter().map(|model| (model, Vec::new()));
    // Above the middle of the spool, in which the sheet would be too deep, but in the bodies.
    let height = |laws: &[LawSpec]| if matches!(laws, [LawSpec::SpoolContact(_)]) { 0.015 } else { 0.0 };
    let scene = move |laws: Vec<LawSpec>| match laws[..] {
        [LawSpec::CordDrag(_)] => (nets_of_three_tiles()[0].clone(), laws),
        _ => (film_of_three_tiles(height(&laws)), laws),
    };
    of_film.map(scene).chain(nets)
}

#[test]
fn the_laws_read_for_a_tile_its_nodes_and_those_below_their_bound_alone() {
    let (mut scene_count, mut bounded) = (0, 0);
    for (model, laws) in scenes() {
        let nodes = model.positions.len();
        assert!(nodes > 2 * TILE);
        let settings = Settings { check_interval: u64::MAX, ..Settings::default() };
        let mut simulation = simulation_of(model, &laws, TWO_EVALUATIONS, Some(1e-7), settings, |_| Vec::new());
        simulation.step(1).unwrap();
        let names: Vec<_> = simulation.laws().iter().map(|law| law.name()).collect();
        let History { numbers, vectors } = simulation.integrator().history();
        assert!(vectors[0].amax() > 0.0, "{names:?} exert no force in this test");
        let differing = (0..nodes).find(|&node| vectors[0].row(node) != vectors[1].row(node));
        assert_eq!(differing, None, "{names:?}: a node with other forces");
        let (powers, reach) = (&numbers[..numbers.len() - 1], numbers[numbers.len() - 1]);
        let (whole, hidden) = powers.split_at(powers.len() / 2);
        assert!(whole.iter().all(|power| power.is_finite()) && whole == hidden, "{names:?}: {whole:?} {hidden:?} W");
        scene_count += 1;
        bounded += usize::from(reach < nodes as f64);
    }
    // Contact with bodies reads all nodes at once.
    assert!(bounded + 3 >= scene_count, "{bounded} of {scene_count} scenes");
}
