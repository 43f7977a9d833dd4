//! Regions of the membrane whose film has properties of its own.

use super::checks::{finite, non_negative, within};
use super::film::Film;
use super::mesh::Mesh;
use super::optics::Optics;
use super::orthotropy::Orthotropy;
use crate::error::{Error, Result};

/// The film of a region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RegionFilm {
    /// Material and thickness; Poisson's ratio is that of the whole film.
    pub film: Film,
    /// Mass per area beside that of the film, as of devices on it \[kg/m2\].
    pub areal_mass: f64,
    /// alpha of eq. (2) between creases; `None`: that of the law.
    pub buckling: Option<f64>,
    /// D in place of that of a plate of the film \[N m\].
    pub bending_stiffness: Option<f64>,
    /// Natural curvature kappa_xx, kappa_yy and kappa_xy in the reference; positive where the film curls towards the
    /// side of its normals \[1/m\].
    pub curvature: [f64; 3],
    /// Strain xx, yy and xy of the reference at which the film is free of stress: of a warm film above 0, of a taut one
    /// below.
    pub natural_strain: [f64; 3],
    /// In sunlight; `None`: those of the law.
    pub optics: Option<Optics>,
}

/// Triangles with a film of their own.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// What messages call it.
    pub name: String,
    /// No triangle belongs to two regions.
    pub triangles: Vec<u32>,
    /// Their film.
    pub film: RegionFilm,
}

/// The film of each triangle.
#[derive(Debug, Clone)]
pub struct FilmOfTriangles {
    /// That of the triangles of no region, then those of the regions.
    films: Vec<RegionFilm>,
    /// What messages call each.
    names: Vec<String>,
    /// Index of the film of each triangle; empty without regions.
    of: Vec<u32>,
    /// Of all films, whose moduli then are those along its direction.
    orthotropy: Option<Orthotropy>,
}

impl From<Film> for RegionFilm {
    fn from(film: Film) -> Self {
        let zeros = [0.0; 3];
        Self {
            film,
            areal_mass: 0.0,
            buckling: None,
            bending_stiffness: None,
            curvature: zeros,
            natural_strain: zeros,
            optics: None,
        }
    }
}

impl RegionFilm {
    /// Mass per area \[kg/m2\].
    pub fn areal_density(&self) -> f64 {
        self.film.density * self.film.thickness + self.areal_mass
    }

    /// E h \[N/m\].
    pub fn membrane_stiffness(&self) -> f64 {
        self.film.youngs_modulus * self.film.thickness
    }

    /// D \[N m\].
    pub fn bending_stiffness(&self) -> f64 {
        self.bending_stiffness.unwrap_or_else(|| self.film.bending_stiffness())
    }

    /// Second derivative of the natural shape along an offset in the reference, over its square: v . K v \[m\].
    pub fn natural_rise(&self, [x, y, _]: [f64; 3]) -> f64 {
        let [xx, yy, xy] = self.curvature;
        xx * x * x + yy * y * y + 2.0 * xy * x * y
    }

    /// A vector of the reference in the film free of stress \[m\].
    pub fn natural(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [xx, yy, xy] = self.natural_strain;
        [x + (xx * x + xy * y), y + (xy * x + yy * y), z]
    }

    /// Area of the film free of stress over that of the reference.
    pub fn natural_area(&self) -> f64 {
        let [xx, yy, xy] = self.natural_strain;
        (1.0 + xx) * (1.0 + yy) - xy * xy
    }

    /// What of it depends on directions in the reference.
    fn directed(&self) -> Option<&'static str> {
        let strain = (self.natural_strain != [0.0; 3]).then_some("natural strain");
        if self.is_curved() { Some("natural curvature") } else { strain }
    }

    /// Whether it has a natural curvature.
    pub fn is_curved(&self) -> bool {
        self.curvature != [0.0; 3]
    }

    fn check(&self, poisson_ratio: f64) -> Result<()> {
        self.film.check()?;
        let nu = self.film.poisson_ratio;
        within("Poisson's ratio of a region", nu, nu == poisson_ratio, "it must be that of the whole film")?;
        non_negative("mass per area of a region [kg/m2]", self.areal_mass)?;
        self.buckling.map_or(Ok(()), |alpha| non_negative("buckling parameter of a region", alpha))?;
        self.bending_stiffness
            .map_or(Ok(()), |rigidity| non_negative("bending stiffness of a region [N m]", rigidity))?;
        self.curvature.iter().try_for_each(|&value| finite("natural curvature of a region [1/m]", value))?;
        for value in self.natural_strain {
            within("natural strain of a region", value, value.abs() <= 0.5, "it must be -0.5 to 0.5")?;
        }
        let [xx, yy, xy] = self.natural_strain;
        let least = 0.5 * (xx + yy) - (0.25 * (xx - yy).powi(2) + xy * xy).sqrt();
        within("least natural strain of a region", least, least >= -0.5, "it must be -0.5 or above")?;
        self.optics.map_or(Ok(()), |optics| optics.check())
    }
}

impl FilmOfTriangles {
    /// The films of so many triangles, each checked.
    ///
    /// # Errors
    /// `OutOfRange`, `TriangleOutOfRange`, `RegionsOverlap`.
    pub fn new(film: Film, orthotropy: Option<Orthotropy>, regions: &[Region], triangle_count: usize) -> Result<Self> {
        film.check()?;
        orthotropy.map_or(Ok(()), |moduli| moduli.check(film.poisson_ratio))?;
        let (mut films, mut names) = (vec![RegionFilm::from(film)], vec!["the film".to_owned()]);
        let mut of = vec![0; if regions.is_empty() { 0 } else { triangle_count }];
        for (region, index) in regions.iter().zip(1_u32..) {
            region.film.check(film.poisson_ratio)?;
            films.push(region.film);
            names.push(region.name.clone());
            for (row, &triangle) in region.triangles.iter().enumerate() {
                let triangle = triangle as usize;
                let Some(place) = of.get_mut(triangle) else {
                    return Err(Error::TriangleOutOfRange { what: "region", row, triangle, triangle_count });
                };
                let other = std::mem::replace(place, index) as usize;
                if other != 0 {
                    let (first, second) = (names[other].clone(), region.name.clone());
                    return Err(Error::RegionsOverlap { triangle, first, second });
                }
            }
        }
        Ok(Self { films, names, of, orthotropy })
    }

    /// Refuses properties that depend on directions in x and y on triangles that are tilted to that plane.
    ///
    /// # Errors
    /// `TiltedFilm`.
    pub fn check_directions(&self, mesh: &Mesh) -> Result<()> {
        let has_directions = |&row: &usize| self.orthotropy.is_some() || self.of(row).directed().is_some();
        let Some(triangle) = (0..mesh.triangles.len()).filter(has_directions).find(|&row| !mesh.is_level(row)) else {
            return Ok(());
        };
        let directed = self.of(triangle).directed();
        let of_region = directed.map(|property| format!("the {property} of {}", self.name_of(triangle)));
        let what = of_region.unwrap_or_else(|| "the direction of the two moduli of the film".to_owned());
        Err(Error::TiltedFilm { triangle, what })
    }

    /// What messages call the film of a triangle.
    pub fn name_of(&self, triangle: usize) -> &str {
        &self.names[self.index_of(triangle)]
    }

    fn index_of(&self, triangle: usize) -> usize {
        self.of.get(triangle).map_or(0, |&index| index as usize)
    }

    /// The film of a triangle.
    pub fn of(&self, triangle: usize) -> &RegionFilm {
        &self.films[self.index_of(triangle)]
    }

    /// That of the triangles of no region.
    pub fn of_no_region(&self) -> &RegionFilm {
        &self.films[0]
    }

    /// The moduli, where the film has two.
    pub fn orthotropy(&self) -> Option<&Orthotropy> {
        self.orthotropy.as_ref()
    }

    /// Refuses two moduli for a law whose elements have one.
    ///
    /// # Errors
    /// `TwoModuli`.
    pub fn require_one_modulus(&self, law: &'static str, what: &'static str, remedy: &'static str) -> Result<()> {
        let refused = |moduli: &Orthotropy| Err(Error::TwoModuli { law, what, across: moduli.across, remedy });
        self.orthotropy.as_ref().map_or(Ok(()), refused)
    }

    /// Whether there are regions.
    pub fn has_regions(&self) -> bool {
        self.films.len() > 1
    }

    /// Whether a property holds for some region.
    pub fn any(&self, property: impl Fn(&RegionFilm) -> bool) -> bool {
        self.films.iter().any(property)
    }
}
