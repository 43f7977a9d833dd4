//! A law and its parameters, as they cross over from Python.

use membrane_core::laws::{
    AirDragParameters, AirMotion, CreaseParameters, DampingParameters, LawSpec, Spin, SpoolContactParameters,
    SpringParameters, TriangleParameters,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::get;
use crate::errors::wrong_value;

/// The law of a kind, from its parameters by name.
pub(crate) fn law_of(kind: &str, p: &Bound<'_, PyDict>) -> PyResult<LawSpec> {
    let owner = &format!("law {kind}");
    Ok(match kind {
        "springs" => LawSpec::Springs(SpringParameters {
            buckling: get(p, owner, "buckling")?,
            buckling_on_creases: get(p, owner, "buckling_on_creases")?,
            buckling_length: get(p, owner, "buckling_length")?,
            crease_length: get(p, owner, "crease_length")?,
            strain_limit: get(p, owner, "strain_limit")?,
        }),
        "triangles" => LawSpec::Triangles(TriangleParameters {
            compression: get(p, owner, "compression")?,
            buckling: get(p, owner, "buckling")?,
            buckling_on_creases: get(p, owner, "buckling_on_creases")?,
            buckling_length: get(p, owner, "buckling_length")?,
            crease_length: get(p, owner, "crease_length")?,
            strain_limit: get(p, owner, "strain_limit")?,
        }),
        "spring_damping" => LawSpec::SpringDamping(DampingParameters {
            ratio: get(p, owner, "ratio")?,
            length: get(p, owner, "length")?,
        }),
        "creases" => LawSpec::Creases(CreaseParameters {
            stiffness: get(p, owner, "stiffness")?,
            contact_penalty: get(p, owner, "contact_penalty")?,
            natural_angle: get(p, owner, "natural_angle")?,
            length_scale: get(p, owner, "length_scale")?,
            collapse: get(p, owner, "collapse")?,
        }),
        "air_drag" => LawSpec::AirDrag(AirDragParameters {
            pressure: get(p, owner, "pressure")?,
            temperature: get(p, owner, "temperature")?,
            air: match get::<String>(p, owner, "air")?.as_str() {
                "still" => AirMotion::Still,
                "turning" => AirMotion::Turning,
                other => {
                    return Err(wrong_value(format!(
                        "law air_drag: air = {other:?} is not known; choose still or turning"
                    )));
                }
            },
        }),
        "spin" => LawSpec::Spin(Spin {
            rate: std::f64::consts::TAU * get::<f64>(p, owner, "frequency")?,
            acceleration: std::f64::consts::TAU * get::<f64>(p, owner, "acceleration")?,
        }),
        "gravity" => LawSpec::Gravity(get(p, owner, "acceleration")?),
        "spool_contact" => LawSpec::SpoolContact(SpoolContactParameters {
            radius: get(p, owner, "radius")?,
            stiffness: get(p, owner, "stiffness")?,
            half_height: get(p, owner, "half_height")?,
            membrane: get(p, owner, "membrane")?,
        }),
        "mass_damping" => LawSpec::MassDamping(get(p, owner, "rate")?),
        other => return Err(wrong_value(format!("there is no law named {other:?}"))),
    })
}
