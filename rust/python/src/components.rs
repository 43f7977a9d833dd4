//! The components of a model and the settings of a run, from Python objects with these attributes.

use membrane_core::integrators::Tolerance;
use membrane_core::model::input::{
    Bridges, ContactSet, Cord, Creases, Film, Model, Motion, NegativeSprings, OwnCrease,
};
use membrane_core::model::optics::{OpticalSide, Optics};
use membrane_core::model::orthotropy::Orthotropy;
use membrane_core::model::regions::{Region, RegionFilm};
use membrane_core::model::schedule::Schedule;
use membrane_core::simd::dispatch::InstructionSet;
use membrane_core::simulation::Settings;
use pyo3::prelude::*;

use crate::arrays::{index_rows, indices, numbers, rows};
use crate::errors::{wrong_type, wrong_value};

/// An object, and its name for errors about its attributes.
struct Component<'py> {
    name: String,
    object: Bound<'py, PyAny>,
}

impl<'py> Component<'py> {
    fn new(name: &str, object: &Bound<'py, PyAny>) -> Self {
        Self { name: name.to_owned(), object: object.clone() }
    }

    fn attribute(&self, attribute: &str) -> PyResult<(String, Bound<'py, PyAny>)> {
        let name = format!("{}.{attribute}", self.name);
        let missing = |_| wrong_type(format!("{name} is missing: the object is {}", self.object.get_type()));
        Ok((name.clone(), self.object.getattr(attribute).map_err(missing)?))
    }

    fn component(&self, attribute: &str) -> PyResult<Self> {
        let (_, object) = self.attribute(attribute)?;
        Ok(Self { name: attribute.to_owned(), object })
    }

    fn value<T: for<'a> FromPyObject<'a, 'py>>(&self, attribute: &str) -> PyResult<T> {
        let (name, value) = self.attribute(attribute)?;
        value.extract().map_err(|_| wrong_type(format!("{name} = {value} is of the wrong type")))
    }

    /// An attribute by a reader of arrays.
    fn array<T>(&self, attribute: &str, read: fn(&str, &Bound<'py, PyAny>) -> PyResult<T>) -> PyResult<T> {
        let (name, value) = self.attribute(attribute)?;
        read(&name, &value)
    }
}

/// The model with the components of an object.
pub(crate) fn model_of(object: &Bound<'_, PyAny>) -> PyResult<Model> {
    let model = Component::new("model", object);
    let [nodes, surface, creases, bridges, contacts, layers] =
        ["nodes", "surface", "creases", "bridges", "contacts", "layers"].map(|name| model.component(name));
    let (nodes, surface, creases, bridges) = (nodes?, surface?, creases?, bridges?);
    let (film, negative_springs) = film_of(&model.component("film")?)?;
    Ok(Model {
        positions: nodes.array("positions", rows)?,
        velocities: nodes.array("velocities", rows)?,
        extra_masses: nodes.array("extra_masses", numbers)?,
        fixed: nodes.array("fixed", indices)?,
        loaded: nodes.array("loaded", indices)?,
        motions: motions_of(&model)?,
        reference: surface.array("reference", rows)?,
        triangles: surface.array("triangles", index_rows)?,
        film,
        negative_springs,
        orthotropy: orthotropy_of(&model.component("film")?)?,
        regions: regions_of(&model)?,
        creases: creases_of(&creases)?,
        cords: cords_of(&model.component("cords")?)?,
        winches: winches_of(&model)?,
        bridges: Bridges { nodes: bridges.array("nodes", index_rows)?, stiffness: bridges.value("stiffness")? },
        contacts: ContactSet { nodes: contacts?.array("nodes", indices)? },
        layers: layers?.array("triangles", indices)?,
    })
}

/// The motions that nodes follow.
fn motions_of(model: &Component<'_>) -> PyResult<Vec<Motion>> {
    let motions: Vec<Bound<'_, PyAny>> = model.value("motions")?;
    let motion_of = |(row, object)| {
        let motion = Component::new(&format!("motions[{row}]"), object);
        let [x, y, z, turn] = ["x", "y", "z", "turn"].map(|name| schedule_of(&motion, name));
        Ok(Motion { nodes: motion.array("nodes", indices)?, displacement: [x?, y?, z?], turn: turn? })
    };
    motions.iter().enumerate().map(motion_of).collect()
}

/// A schedule, or `None`.
fn schedule_of(motion: &Component<'_>, name: &str) -> PyResult<Option<Schedule>> {
    let (name, object) = motion.attribute(name)?;
    if object.is_none() {
        return Ok(None);
    }
    schedule(&Component::new(&name, &object)).map(Some)
}

fn schedule(component: &Component<'_>) -> PyResult<Schedule> {
    let (times, values, ease) = (component.value("times")?, component.value("values")?, component.value("ease")?);
    Schedule::new(times, values, ease).map_err(|error| wrong_value(format!("{}: {error}", component.name)))
}

/// The film, or `None`.
fn film_of(film: &Component<'_>) -> PyResult<(Option<Film>, NegativeSprings)> {
    if film.object.is_none() {
        return Ok((None, NegativeSprings::default()));
    }
    let negative_springs = match film.value::<String>("negative_springs")?.as_str() {
        "refuse" => NegativeSprings::Refuse,
        "clip" => NegativeSprings::Clip,
        "keep" => NegativeSprings::Keep,
        "unused" => NegativeSprings::Unused,
        other => {
            return Err(wrong_value(format!(
                "film.negative_springs = {other:?} is not known; choose refuse, clip or keep"
            )));
        }
    };
    let film = Film {
        youngs_modulus: film.value("youngs_modulus")?,
        poisson_ratio: film.value("poisson_ratio")?,
        density: film.value("density")?,
        thickness: film.value("thickness")?,
    };
    Ok((Some(film), negative_springs))
}

/// The moduli of a film that has two, or `None`.
fn orthotropy_of(film: &Component<'_>) -> PyResult<Option<Orthotropy>> {
    if film.object.is_none() {
        return Ok(None);
    }
    let moduli = film.component("orthotropy")?;
    if moduli.object.is_none() {
        return Ok(None);
    }
    let (direction, across, shear) = (moduli.value("direction")?, moduli.value("across")?, moduli.value("shear")?);
    Ok(Some(Orthotropy { direction, across, shear }))
}

/// Regions whose film has properties of its own.
fn regions_of(model: &Component<'_>) -> PyResult<Vec<Region>> {
    let regions: Vec<Bound<'_, PyAny>> = model.value("regions")?;
    let region_of = |(row, object)| {
        let region = Component::new(&format!("regions[{row}]"), object);
        let film = Film {
            youngs_modulus: region.value("youngs_modulus")?,
            poisson_ratio: region.value("poisson_ratio")?,
            density: region.value("density")?,
            thickness: region.value("thickness")?,
        };
        let film = RegionFilm {
            film,
            areal_mass: region.value("areal_mass")?,
            buckling: region.value("buckling")?,
            bending_stiffness: region.value("bending_stiffness")?,
            curvature: region.value("curvature")?,
            natural_strain: region.value("natural_strain")?,
            optics: optics_of(&region)?,
        };
        Ok(Region { name: region.value("name")?, triangles: region.array("triangles", indices)?, film })
    };
    regions.iter().enumerate().map(region_of).collect()
}

/// Optical properties of a region, or `None`.
fn optics_of(region: &Component<'_>) -> PyResult<Option<Optics>> {
    let optics = region.component("optics")?;
    if optics.object.is_none() {
        return Ok(None);
    }
    let side = |name: &str| {
        Ok::<_, PyErr>(OpticalSide {
            specular: optics.value(&format!("{name}_specular"))?,
            diffuse: optics.value(&format!("{name}_diffuse"))?,
            emissivity: optics.value(&format!("{name}_emissivity"))?,
            lambert: optics.value(&format!("{name}_lambert"))?,
        })
    };
    Ok(Some(Optics { front: side("front")?, back: side("back")? }))
}

/// The creases; what of a column is not a number belongs to the law.
fn creases_of(creases: &Component<'_>) -> PyResult<Creases> {
    let columns = ["stiffness", "contact_penalty", "natural_angle"].map(|name| creases.array(name, numbers));
    let [stiffness, contact_penalty, natural_angle] = columns;
    let (stiffness, contact_penalty, natural_angle) = (stiffness?, contact_penalty?, natural_angle?);
    if [&contact_penalty, &natural_angle].iter().any(|column| column.len() != stiffness.len()) {
        return Err(wrong_value("the arrays of the creases must have equally many rows".to_owned()));
    }
    let given = |value: f64| (!value.is_nan()).then_some(value);
    let own = |row: usize| OwnCrease {
        stiffness: given(stiffness[row]),
        contact_penalty: given(contact_penalty[row]),
        natural_angle: given(natural_angle[row]),
    };
    Ok(Creases {
        nodes: creases.array("nodes", index_rows)?,
        fold_signs: creases.array("fold_signs", numbers)?,
        fold_angles: creases.array("fold_angles", numbers)?,
        own: (0..stiffness.len()).map(own).collect(),
    })
}

/// The segments of the cords.
fn cords_of(cords: &Component<'_>) -> PyResult<Vec<Cord>> {
    let nodes = cords.array("nodes", index_rows)?;
    let names = ["stiffness", "rest_length", "strain_limit", "critical_strain"];
    let columns = names.into_iter().map(|name| cords.array(name, numbers)).collect::<PyResult<Vec<_>>>()?;
    if columns.iter().any(|column| column.len() != nodes.len()) {
        return Err(wrong_value("the arrays of the cords must have equally many rows".to_owned()));
    }
    let cord = |(row, nodes)| Cord {
        nodes,
        stiffness: columns[0][row],
        rest_length: columns[1][row],
        strain_limit: columns[2][row],
        critical_strain: columns[3][row],
        winch: None,
    };
    let mut found: Vec<Cord> = nodes.into_iter().enumerate().map(cord).collect();
    for [segment, winch] in cords.array("winch", index_rows)? {
        let Some(cord) = found.get_mut(segment as usize) else {
            return Err(wrong_value(format!("cords.winch: there is no segment {segment}")));
        };
        cord.winch = Some(winch as usize);
    }
    Ok(found)
}

/// The schedules of the winches.
fn winches_of(model: &Component<'_>) -> PyResult<Vec<Schedule>> {
    let winches: Vec<Bound<'_, PyAny>> = model.value("winches")?;
    winches
        .iter()
        .enumerate()
        .map(|(row, object)| schedule(&Component::new(&format!("winches[{row}]"), object)))
        .collect()
}

/// The settings of an object; without `instructions`, the widest of the machine.
pub(crate) fn settings_of(object: &Bound<'_, PyAny>, instructions: Option<&str>) -> PyResult<Settings> {
    let settings = Component::new("settings", object);
    Ok(Settings {
        margin: settings.value("margin")?,
        check_interval: settings.value("check_interval")?,
        energy_tolerance: settings.value("energy_tolerance")?,
        loss_tolerance: settings.value("loss_tolerance")?,
        tolerance: Tolerance {
            relative: settings.value("tolerance")?,
            length: settings.value("tolerance_length")?,
            speed: settings.value("tolerance_speed")?,
        },
        spectral_radius: settings.value("spectral_radius")?,
        substeps: settings.value("substeps")?,
        frozen_at: settings.value("frozen_at")?,
        instructions: instructions.map_or_else(|| Ok(InstructionSet::widest()), instructions_of)?,
    })
}

fn instructions_of(name: &str) -> PyResult<InstructionSet> {
    InstructionSet::ALL.into_iter().find(|set| set.name() == name).ok_or_else(|| {
        let known = InstructionSet::ALL.map(InstructionSet::name).join(", ");
        wrong_value(format!("there are no instructions named {name:?}; choose one of: {known}"))
    })
}
