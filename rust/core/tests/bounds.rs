//! Strain bounds of films, and the mass of a square of film.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use common::{FILM, films, sheet};
use membrane_core::arrays::state::{NodeVectors, PhasePoint};
use membrane_core::assembly::Assembly;
use membrane_core::laws::{
    Instant, LawSpec, RectangleParameters, SpringParameters, TriangleParameters, build, spin_of,
};
use membrane_core::simd::dispatch::InstructionSet;

/// The excess of a film of this law, as text, in a sheet with an affine displacement gradient.
fn excess(law: &LawSpec, gradient: [[f64; 2]; 2]) -> Option<String> {
    let mut model = sheet(4, 3, 0.01);
    for p in &mut model.positions {
        let [x, y, _] = *p;
        *p = [x + gradient[0][0] * x + gradient[0][1] * y, y + gradient[1][0] * x + gradient[1][1] * y, 0.0];
    }
    let assembly = Assembly::new(model, InstructionSet::Baseline).unwrap();
    let positions = assembly.numbering.internal_vectors(&assembly.model.positions);
    let velocities = NodeVectors::zeros(positions.nrows());
    let laws = build(std::slice::from_ref(law), &assembly).unwrap();
    let spin = spin_of(&[]);
    let at = Instant::new(PhasePoint { time: 0.0, positions: &positions, velocities: &velocities }, &spin);
    laws[0].inspection().unwrap().first_excess(at).map(|excess| excess.what)
}

#[test]
fn a_film_is_at_fault_just_beyond_its_strain_bound_in_any_direction_of_its_edges() {
    // A stretch of the sheet along x, along y, and along the diagonals of its squares.
    for law in films() {
        let bound = 0.05;
        let law = match law {
            LawSpec::Springs(other) => LawSpec::Springs(SpringParameters { strain_limit: bound, ..other }),
            LawSpec::Triangles(other) => LawSpec::Triangles(TriangleParameters { strain_limit: bound, ..other }),
            LawSpec::Rectangles(RectangleParameters(other)) => {
                LawSpec::Rectangles(RectangleParameters(SpringParameters { strain_limit: bound, ..other }))
            }
            other => other,
        };
        for along in [[[1.0, 0.0], [0.0, 0.0]], [[0.0, 0.0], [0.0, 1.0]], [[0.5, 0.5], [0.5, 0.5]]] {
            let by = |strain: f64| along.map(|row| row.map(|entry| strain * entry));
            assert_eq!(excess(&law, by(0.99 * bound)), None, "{}", law.kind());
            let text = excess(&law, by(1.02 * bound)).unwrap();
            assert!(
                (text.contains("5.1 %") || text.contains("5.100 %")) && text.contains("5.000 %"),
                "{}: {text}",
                law.kind()
            );
        }
        assert_eq!(excess(&law, [[-0.3, 0.0], [0.0, -0.3]]), None, "{}", law.kind());
    }
}

#[test]
fn triangles_without_a_film_are_refused_with_their_number() {
    let bare = membrane_core::model::input::Model { film: None, ..sheet(2, 2, 0.01) };
    let error = Assembly::new(bare, InstructionSet::Baseline).map(|_| ()).unwrap_err().to_string();
    assert_eq!(error, "the model has 8 triangles and no film; give it one, or leave the triangles out");
}

#[test]
fn a_square_of_film_has_the_mass_of_its_area() {
    let assembly = Assembly::new(sheet(2, 2, 0.01), InstructionSet::Baseline).unwrap();
    let mass = assembly.square_of_film(Some(0.011)).unwrap();
    assert!((mass / (FILM.density * FILM.thickness * 0.011 * 0.011) - 1.0).abs() < 1e-14, "{mass:e}");
    assert_eq!(assembly.square_of_film(None), None);
    let bare = Assembly::new(
        membrane_core::model::input::Model { film: None, triangles: vec![], ..sheet(2, 2, 0.01) },
        InstructionSet::Baseline,
    );
    assert!(bare.map_or(true, |bare| bare.square_of_film(Some(0.011)).is_none()));
}
