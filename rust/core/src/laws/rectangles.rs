//! In-plane elasticity by rectangles: springs along their four sides and both diagonals, which buckle.
//!
//! The constants are those of `model::rectangles`: for strains along either side and for shear the energy is that of
//! the film in plane stress, at any Poisson's ratio; for both strains at once it differs by their coupling, except at
//! nu = 1/3. Of the film's energy a uniform strain in all directions ("cap") stores the share (3 - nu)/(2 + 2 nu), and
//! stretch along one side with the same shortening along the other ("saddle") (1 + nu)/(2 - 2 nu).
//!
//! Force, buckling by eq. (2), energy and tangent are those of `springs`, with the same kernels. The second diagonals,
//! which are no edges of the mesh, buckle as the first ones.

use serde::Deserialize;

use super::buckling::{Buckling, Mean};
use super::springs::{FilmTriangles, Spring, SpringParameters, Springs};
use super::{Context, FilmElements, Law, LawParameters};
use crate::assembly::Assembly;
use crate::error::Result;
use crate::model::checks::positive;
use crate::model::mesh::{dot, sub};
use crate::model::rectangles::Rectangles;

/// Parameters of the rectangles: those of springs.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(transparent)]
pub struct RectangleParameters(pub SpringParameters);

impl LawParameters for RectangleParameters {
    fn film(&self) -> Option<FilmElements> {
        Some(FilmElements::Rectangles)
    }

    fn springs(&self, context: &Context<'_>) -> Option<Result<Springs>> {
        Some(self.of_rectangles(context))
    }

    fn build(&self, context: &Context<'_>) -> Result<Box<dyn Law>> {
        Ok(Box::new(self.of_rectangles(context)?))
    }

    fn example() -> Self {
        Self(SpringParameters::example())
    }
}

/// Spring constant of each spring; 0 without film \[N/m\].
///
/// # Errors
/// `SlenderRectangles`.
pub(super) fn stiffness(rectangles: &Rectangles, assembly: &Assembly) -> Result<Vec<f64>> {
    let Some(films) = &assembly.film else { return Ok(vec![0.0; rectangles.ends.len()]) };
    rectangles.stiffness(|triangle| films.of(triangle).film)
}

impl RectangleParameters {
    fn of_rectangles(self, context: &Context<'_>) -> Result<Springs> {
        let SpringParameters { buckling, buckling_on_creases, buckling_length, crease_length, strain_limit } = self.0;
        positive("strain limit of the rectangles", strain_limit)?;
        let (parameter, on_creases, length) = (buckling, buckling_on_creases, buckling_length);
        let assembly = context.assembly;
        Springs::require_one_modulus("rectangles", assembly)?;
        let rectangles = assembly.mesh.rectangles(&assembly.hinges)?;
        let links = context.networks.rectangles(&rectangles, assembly);
        let Some(films) = &assembly.film else { return Ok(Springs::in_batches("rectangles", links, &[])) };
        let constants = stiffness(&rectangles, assembly)?;
        let parts = rectangles.side_constants(|triangle| films.of(triangle).film);
        let mut lengths = Buckling { parameter, on_creases, length, crease_length }.shortenings(assembly, &parts)?;
        for (rectangle, ends) in rectangles.all.iter().zip(&rectangles.ends[assembly.mesh.edges.len()..]) {
            let [i, j] = ends.map(|node| assembly.mesh.reference[node as usize]);
            let mut rest_length = Mean::default();
            for (triangle, legs) in rectangle.halves {
                let span = films.of(triangle as usize).natural(sub(j, i));
                rest_length.add(dot(span, span).sqrt(), parts[triangle as usize][legs[0]]);
            }
            let [.., [diagonal, _]] = rectangle.springs;
            lengths.push((rest_length.value(), lengths[diagonal as usize].1));
        }
        let springs = constants.into_iter().zip(lengths);
        let springs = springs.map(|(stiffness, (rest_length, shortening))| Spring {
            stiffness,
            rest_length,
            critical_length: rest_length - shortening,
            strain_limit,
        });
        let mut own = Springs::in_batches("rectangles", links, &springs.collect::<Vec<_>>());
        own.film = FilmTriangles::of_rectangles(&rectangles, assembly);
        Ok(own)
    }
}
