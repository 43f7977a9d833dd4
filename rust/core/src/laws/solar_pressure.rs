//! Pressure of sunlight on the film, by its optical properties:
//!
//!     F = -P A cos a [(1 - r_s) s + (2 r_s cos a + 2/3 r_d + k) n]   [N],   P = 4.56e-6 Pa (1 au / r)^2
//!     k = (1 - r_s - r_d) (e_l B_l - e_d B_d) / (e_l + e_d)
//!
//! on a triangle of area A, a third on each node; s is the direction to the sun, fixed in inertial space, n the normal
//! of the side that is lit, cos a = n . s >= 0. The lit side reflects the share r_s as a mirror and r_d as Lambert's
//! law has it; the film absorbs the rest and emits it at once from both sides, lit and dark, of one temperature, with
//! the emissivities e and the shares B of emitted momentum along the normal. Source: McInnes, Solar Sailing (1999), ch.
//! 2; P is his 1368 W/m2 over the speed of light. (The total irradiance of Kopp and Lean (2011), 1360.8 W/m2, makes it
//! 4.54e-6 Pa.)
//!
//! With N twice the vector area of the triangle, on its front, q = N . s, and c = q/|N|, each node bears
//!
//!     F = -(P/6) [(1 - r_s) |q| s + (2 r_s |c| + 2/3 r_d + k) c N]
//!
//! by the coefficients of the front where q > 0, of the back where q < 0. F is continuous, and 0 edge-on; there, its
//! derivative jumps, but for a mirror on both sides. With u = N/|N| and b = 2/3 r_d + k it is
//!
//!     dF/dN = -(P/6) [(1 - r_s) sign(q) s s^T + (2 r_s |c| + b) c I + u ((4 r_s |c| + b) s - (4 r_s |c| + b) c u)^T]
//!
//! A region of the film may have optical properties of its own.
//!
//! No shadows: each triangle is lit as if it were alone. The load has no potential; its work is external.

use nalgebra::Vector3;
use serde::Deserialize;

use super::facet_load::{FacetLoad, FacetLoadLaw, LoadedFacets};
use super::{Context, Instant, Law, LawParameters};
use crate::arrays::jacobian::Block;
use crate::assembly::Assembly;
use crate::elements::facet::FacetSet;
use crate::error::Result;
use crate::model::checks::{finite, positive, within};
use crate::model::factor::Factor;
use crate::model::optics::{OpticalSide, Optics};
use crate::simd::lanes::{F64x8, SimdF64, Vec3, dot, scale, sum};

/// P at one astronomical unit \[Pa\].
const PRESSURE: f64 = 4.56e-6;
/// An astronomical unit \[m\].
const ASTRONOMICAL_UNIT: f64 = 149_597_870_700.0;
/// Twice an area below which its square has lost digits, and a triangle has no direction \[m2\].
const NO_AREA: f64 = 1e-150;

/// Parameters of the load.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SolarPressureParameters {
    /// A vector towards the sun in inertial space, of any length \[-\].
    pub sun: [f64; 3],
    /// r, from the sun \[m\].
    pub distance: f64,
    /// r_s of the side of the normals, which is the front.
    pub front_specular: f64,
    /// r_d of the front.
    pub front_diffuse: f64,
    /// e of the front.
    pub front_emissivity: f64,
    /// B of the front.
    pub front_lambert: f64,
    /// r_s of the back.
    pub back_specular: f64,
    /// r_d of the back.
    pub back_diffuse: f64,
    /// e of the back.
    pub back_emissivity: f64,
    /// B of the back.
    pub back_lambert: f64,
    /// Of the load.
    #[serde(default)]
    pub factor: Factor,
}

/// What a side does with the light that falls on it, of one facet or of a batch.
#[derive(Clone, Copy)]
struct Side<T = f64> {
    /// 1 - r_s.
    along_sun: T,
    /// 2 r_s.
    mirrored: T,
    /// 2/3 r_d + k.
    scattered: T,
}

/// Front and back.
fn sides(Optics { front, back }: Optics) -> [Side; 2] {
    let emissivity = front.emissivity + back.emissivity;
    let to_back = front.emissivity * front.lambert - back.emissivity * back.lambert;
    let side = |lit: OpticalSide, recoil: f64| Side {
        along_sun: 1.0 - lit.specular,
        mirrored: 2.0 * lit.specular,
        scattered: 2.0 / 3.0 * lit.diffuse + (1.0 - lit.specular - lit.diffuse) * recoil / emissivity,
    };
    [side(front, to_back), side(back, -to_back)]
}

/// Front and back of each facet, by batch; `None` where no region has optical properties of its own.
fn own_sides(whole: Optics, facets: &FacetSet, assembly: &Assembly) -> Option<Vec<[Side<F64x8>; 2]>> {
    let films = assembly.film.as_ref().filter(|films| films.any(|film| film.optics.is_some()))?;
    let of_rows: Vec<[Side; 2]> =
        (0..assembly.mesh.triangles.len()).map(|row| sides(films.of(row).optics.unwrap_or(whole))).collect();
    let packed = |side: usize, value: fn(&Side) -> f64| facets.elements.pack(0.0, |row| value(&of_rows[row][side]));
    let of_side = |side: usize| {
        let along_sun = packed(side, |side| side.along_sun).into_iter();
        let others = packed(side, |side| side.mirrored).into_iter().zip(packed(side, |side| side.scattered));
        along_sun.zip(others).map(|(along_sun, (mirrored, scattered))| Side { along_sun, mirrored, scattered })
    };
    Some(of_side(0).zip(of_side(1)).map(|(front, back)| [front, back]).collect())
}

impl SolarPressureParameters {
    fn check(&self) -> Result<()> {
        for component in self.sun {
            finite("direction to the sun", component)?;
        }
        within("direction to the sun", 0.0, self.sun != [0.0; 3], "it must not be 0; (0, 0, 1) is along the axis")?;
        positive("distance from the sun [m]", self.distance)?;
        self.optics().check()
    }

    fn optics(&self) -> Optics {
        Optics {
            front: OpticalSide {
                specular: self.front_specular,
                diffuse: self.front_diffuse,
                emissivity: self.front_emissivity,
                lambert: self.front_lambert,
            },
            back: OpticalSide {
                specular: self.back_specular,
                diffuse: self.back_diffuse,
                emissivity: self.back_emissivity,
                lambert: self.back_lambert,
            },
        }
    }
}

impl LawParameters for SolarPressureParameters {
    fn build(&self, context: &Context<'_>) -> Result<Box<dyn Law>> {
        self.check()?;
        let [x, y, z] = self.sun;
        // Divided by the largest component first, so that no square of it overflows or vanishes.
        let largest = x.abs().max(y.abs()).max(z.abs());
        let [x, y, z] = [x / largest, y / largest, z / largest];
        let length = (x * x + y * y + z * z).sqrt();
        let distance = self.distance / ASTRONOMICAL_UNIT;
        let sixth = PRESSURE / distance / distance / 6.0;
        finite("pressure of sunlight at its distance [Pa]", sixth)?;
        let sun = [x / length, y / length, z / length];
        let (facets, optics) = (FacetSet::new(context.assembly), self.optics());
        let (sides, own) = (sides(optics), own_sides(optics, &facets, context.assembly));
        let load = SolarPressure { sun, sixth, sides, own, factor: self.factor.clone() };
        Ok(Box::new(LoadedFacets::new(load, facets, context.assembly)))
    }

    fn example() -> Self {
        Self {
            sun: [0.3, -0.5, 1.2],
            distance: 1e-3 * ASTRONOMICAL_UNIT,
            front_specular: 0.7,
            front_diffuse: 0.1,
            front_emissivity: 0.05,
            front_lambert: 0.8,
            back_specular: 0.2,
            back_diffuse: 0.3,
            back_emissivity: 0.6,
            back_lambert: 0.5,
            factor: Factor::example(),
        }
    }
}

/// The load as a function of time and of the frame.
struct SolarPressure {
    /// s in inertial space.
    sun: [f64; 3],
    /// P/6 [Pa].
    sixth: f64,
    /// Front and back.
    sides: [Side; 2],
    /// See `own_sides`.
    own: Option<Vec<[Side<F64x8>; 2]>>,
    factor: Factor,
}

/// The load at an instant.
struct Light<'a> {
    load: &'a SolarPressure,
    /// s in the frame.
    sun: [f64; 3],
    /// P/6 [Pa].
    sixth: f64,
}

impl FacetLoad for Light<'_> {
    #[inline(always)]
    fn on_node<V: SimdF64>(&self, place: usize, presence: V, normal: Vec3<V>) -> Vec3<V> {
        let sun = self.sun.map(V::all);
        let flow = dot(normal, sun);
        let of_side = |front: V, back: V| flow.below(V::zero(), back, front);
        let lit = match &self.load.own {
            None => {
                let [front, back] = self.load.sides;
                Side {
                    along_sun: of_side(V::all(front.along_sun), V::all(back.along_sun)),
                    mirrored: of_side(V::all(front.mirrored), V::all(back.mirrored)),
                    scattered: of_side(V::all(front.scattered), V::all(back.scattered)),
                }
            }
            Some(own) => {
                let [front, back] = &own[place];
                Side {
                    along_sun: of_side(V::load(&front.along_sun), V::load(&back.along_sun)),
                    mirrored: of_side(V::load(&front.mirrored), V::load(&back.mirrored)),
                    scattered: of_side(V::load(&front.scattered), V::load(&back.scattered)),
                }
            }
        };
        let length = dot(normal, normal).sqrt().max(V::all(NO_AREA));
        let cosine = flow / length;
        let along_normal = (lit.mirrored * cosine.abs() + lit.scattered) * cosine;
        let strength = V::all(-self.sixth) * presence;
        scale(strength, sum(scale(lit.along_sun * flow.abs(), sun), scale(along_normal, normal)))
    }

    fn change(&self, (batch, lane): (usize, usize), normal: &Vector3<f64>, by: &Block) -> Block {
        let own = self.load.own.as_ref().map(|own| {
            own[batch].map(|Side { along_sun, mirrored, scattered }| Side {
                along_sun: along_sun.0[lane],
                mirrored: mirrored.0[lane],
                scattered: scattered.0[lane],
            })
        });
        let [front, back] = own.unwrap_or(self.load.sides);
        let sun = Vector3::from(self.sun);
        let unit = normal / normal.norm().max(NO_AREA);
        let cosine = unit.dot(&sun);
        let (side, sign) = if normal.dot(&sun) < 0.0 { (back, -1.0) } else { (front, 1.0) };
        let along_normal = (side.mirrored * cosine.abs() + side.scattered) * cosine;
        let steepness = 2.0 * side.mirrored * cosine.abs() + side.scattered;
        let by_normal = sun * sun.transpose() * (side.along_sun * sign)
            + Block::identity() * along_normal
            + unit * (sun - unit * cosine).transpose() * steepness;
        by_normal * by * -self.sixth
    }
}

impl FacetLoadLaw for SolarPressure {
    type Load<'a> = Light<'a>;
    const NAME: &'static str = "solar_pressure";
    const REMEDY: &'static str = "use a smaller dt, or check the distance from the sun";

    fn at<'a>(&'a self, at: Instant<'_>) -> Light<'a> {
        let sixth = self.sixth * self.factor.value(at.time);
        Light { load: self, sun: at.frame.components_of(self.sun), sixth }
    }

    fn factor(&self) -> &Factor {
        &self.factor
    }
}
