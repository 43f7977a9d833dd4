//! Regions of the film and creases with properties of their own.

use membrane_core::model::input::{Model, OwnCrease};
use membrane_core::model::optics::{OpticalSide, Optics};
use membrane_core::model::regions::{Region, RegionFilm};

use super::FILM;

/// A model whose film has two regions beside the rest, and whose creases differ.
pub fn patched(mut model: Model) -> Model {
    let film = super::Film { youngs_modulus: 5e9, density: 1700.0, thickness: 12e-6, ..FILM };
    let side = |specular, diffuse, emissivity| OpticalSide { specular, diffuse, emissivity, lambert: 0.6 };
    let thick = RegionFilm {
        areal_mass: 0.02,
        buckling: Some(30.0),
        curvature: [20.0, -5.0, 8.0],
        natural_strain: [0.01, -0.02, 0.005],
        optics: Some(Optics { front: side(0.1, 0.2, 0.8), back: side(0.4, 0.1, 0.3) }),
        ..RegionFilm::from(film)
    };
    let stiff = RegionFilm { bending_stiffness: Some(3e-7), curvature: [-9.0, 0.0, 2.0], ..RegionFilm::from(FILM) };
    let count = model.triangles.len() as u32;
    let of = |remainder: u32| (0..count).filter(|triangle| (triangle / 3) % 3 == remainder).collect();
    let region = |name: &str, row, film| Region { name: name.to_owned(), triangles: of(row), film };
    model.regions = vec![region("thick", 0, thick), region("stiff", 1, stiff)];
    let own = |row: usize| match row % 3 {
        0 => OwnCrease::default(),
        1 => OwnCrease { stiffness: Some(4.0), contact_penalty: Some(7.0), natural_angle: None },
        _ => OwnCrease { natural_angle: Some(2.4), ..OwnCrease::default() },
    };
    model.creases.own = (0..model.creases.nodes.len()).map(own).collect();
    model
}
