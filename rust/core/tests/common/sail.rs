//! The square sail of model 1 at any fineness: the mesh of `membrane_rs.folding.SquareSail` in its layout "ruled", node
//! for node, slightly folded in place of stowed; tethers and laws as in the built-in scene.

use super::{Dice, FILM};
use membrane_core::assembly::Assembly;
use membrane_core::integrators::by_name;
use membrane_core::laws::{
    AirDragParameters, AirMotion, CreaseParameters, LawSpec, SpinParameters, SpoolContactParameters, SpringParameters,
    build, spin_of,
};
use membrane_core::model::input::{Cord, Model};
use membrane_core::simulation::{Settings, Setup, Simulation};
use membrane_core::stability::Limit;

/// Half the inner and half the outer width [m].
const INNER: f64 = 0.0515;
const OUTER: f64 = 0.2275;
/// Strips of each petal; rows of cells in each, and cells along the inner edge, at fineness 1.
const STRIPS: usize = 8;
const ROWS: usize = 2;
const COLUMNS: usize = 11;
/// Inclination of the strips to the plane [rad].
const INCLINATION: f64 = 0.2;
/// Segments of each tether, and radius of the spool [m].
const SEGMENTS: usize = 19;
const SPOOL: f64 = 0.025;
/// Axial stiffness EA [N], and mass per length [kg/m].
const TETHER: (f64, f64) = (17.0, 1.004e-4);
const TIP_MASS: f64 = 0.36e-3;

/// Number of nodes of the tethers.
pub const TETHER_NODES: usize = 4 * SEGMENTS;

/// Number of nodes of the mesh at a fineness.
pub fn node_count(fineness: usize) -> usize {
    let rows = STRIPS * ROWS * fineness;
    4 * (rows + 1) * (COLUMNS * fineness + rows)
}

/// The sail with cells `fineness` times as fine as those of model 1, with random displacements of a hundredth of a
/// cell, in motion.
pub fn sail(fineness: usize) -> Model {
    let (rows, columns) = (STRIPS * ROWS * fineness, COLUMNS * fineness);
    let distance = |row: usize| INNER + (OUTER - INNER) * row as f64 / rows as f64;
    // The first node of each row lies on the diagonal and belongs to the previous petal.
    let size = node_count(fineness) / 4;
    let before = |row: usize| row * columns + row * row.saturating_sub(1);
    let node = |petal: usize, row: usize, column: usize| {
        let (petal, column) = if column == 0 { ((petal + 3) % 4, columns + 2 * row) } else { (petal, column) };
        (petal * size + before(row) + column - 1) as u32
    };
    let mut model = Model { film: Some(FILM), ..Model::default() };
    let cell = (OUTER - INNER) / rows as f64;
    let mut dice = Dice(1);
    for petal in 0..4 {
        let turned = |[x, y, z]: [f64; 3]| [[x, y, z], [-y, x, z], [-x, -y, z], [y, -x, z]][petal];
        for row in 0..=rows {
            let x = distance(row);
            let strip = rows / STRIPS;
            let height = strip.abs_diff((row + strip) % (2 * strip)) as f64 * cell * INCLINATION.sin();
            let closer = (INNER + (x - INNER) * INCLINATION.cos()) / x;
            for column in 1..=columns + 2 * row {
                let y = if column <= row {
                    -distance(row - column)
                } else if column < row + columns {
                    INNER * (2.0 * (column - row) as f64 / columns as f64 - 1.0)
                } else {
                    distance(column - row - columns)
                };
                let [dx, dy, dz] = [0, 1, 2].map(|_| 0.01 * cell * dice.roll());
                model.reference.push(turned([x, y, 0.0]));
                model.positions.push(turned([closer * x + dx, closer * y + dy, height + dz]));
            }
        }
        for row in 0..rows {
            let count = columns + 2 * row;
            let (low, high) = (|c| node(petal, row, c), |c| node(petal, row + 1, c));
            for c in 0..count {
                let [a, b, d, e] = [low(c), low(c + 1), high(c + 1), high(c + 2)];
                // Diagonals alternate, from the nearer slanted side on.
                let is_flipped = if c < count.div_ceil(2) { c % 2 == 1 } else { (count + 1 - c).is_multiple_of(2) };
                model.triangles.extend(if is_flipped { [[a, d, b], [b, d, e]] } else { [[a, d, e], [a, e, b]] });
            }
            model.triangles.extend([[low(0), high(0), high(1)], [low(count), high(count + 1), high(count + 2)]]);
        }
        for line in 1..STRIPS {
            let row = line * rows / STRIPS;
            for column in 0..columns + 2 * row {
                model.creases.nodes.push([node(petal, row, column), node(petal, row, column + 1)]);
                model.creases.fold_signs.push(if line % 2 == 0 { 1.0 } else { -1.0 });
            }
        }
    }
    model.extra_masses = vec![0.0; model.positions.len()];
    for petal in 0..4 {
        model.extra_masses[node(petal, rows, columns + 2 * rows) as usize] = TIP_MASS;
    }
    add_tethers(&mut model, [0, 1, 2, 3].map(|petal| node(petal, 0, columns)));
    model.velocities = Dice(2).vectors(model.positions.len(), 0.2);
    model
}

/// Tethers from the spool to the inner corners.
fn add_tethers(model: &mut Model, corners: [u32; 4]) {
    let rest_length = (2.0_f64.sqrt() * INNER - SPOOL) / SEGMENTS as f64;
    for corner in corners {
        let mut last = corner;
        let end = model.positions[corner as usize];
        let radius = end[0].hypot(end[1]);
        for segment in 1..=SEGMENTS {
            let at = segment as f64 / SEGMENTS as f64;
            let closer = 1.0 - at * (1.0 - SPOOL / radius);
            let next = model.positions.len() as u32;
            model.positions.push([closer * end[0], closer * end[1], (1.0 - at) * end[2]]);
            let (stiffness, strain_limit) = (TETHER.0 / rest_length, 1e9);
            model.cords.push(Cord { nodes: [last, next], stiffness, rest_length, strain_limit });
            model.extra_masses.push(TETHER.1 * rest_length);
            model.contacts.nodes.push(next);
            last = next;
        }
        model.fixed.push(last);
    }
}

/// The laws of model 1, without a strain limit of the springs.
pub fn laws() -> Vec<LawSpec> {
    vec![
        SpringParameters {
            buckling: 100.0,
            buckling_on_creases: 1000.0,
            buckling_length: None,
            crease_length: None,
            strain_limit: 1e9,
        }
        .into(),
        LawSpec::SpringDamping(0.02.into()),
        CreaseParameters {
            stiffness: 10.0,
            contact_penalty: 100.0,
            natural_angle: 0.0,
            fold_fraction: None,
            length_scale: None,
            collapse: 0.05,
        }
        .into(),
        AirDragParameters { pressure: 4.5, temperature: 293.0, air: AirMotion::Still }.into(),
        SpinParameters { frequency: 3.0, acceleration: 0.0, ..SpinParameters::default() }.into(),
        SpoolContactParameters { radius: SPOOL, stiffness: 200.0, half_height: None, membrane: false }.into(),
    ]
}

/// The sail with these laws, with a known limit of the step or without.
pub fn simulation(model: Model, method: &str, dt: Option<f64>, settings: Settings, limit: Option<Limit>) -> Simulation {
    let assembly = Assembly::new(model, settings.instructions).unwrap();
    let (specs, method) = (laws(), by_name(method).unwrap());
    let (spin, laws) = (spin_of(&specs), build(&specs, &assembly).unwrap());
    Simulation::with(Setup { assembly, laws, spin, method, dt, limit }, settings).unwrap()
}
