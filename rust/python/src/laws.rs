//! Conversion of laws and their parameters from Python.

use membrane_core::laws::LawSpec;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};
use serde::Deserialize;
use serde_json::{Map, Value};

use crate::errors::{wrong_type, wrong_value};

/// The law of a kind, from its parameters by name.
pub(crate) fn law_of(kind: &str, parameters: &Bound<'_, PyDict>) -> PyResult<LawSpec> {
    let mut values = Map::new();
    values.insert("kind".to_owned(), kind.into());
    for (name, value) in parameters {
        let name: String = name.extract()?;
        let found = value_of(&value, DEEPEST)
            .ok_or_else(|| wrong_type(format!("law {kind}: {name} = {value} is no number")))?;
        values.insert(name, found);
    }
    let values = Value::Object(values);
    LawSpec::deserialize(&values).map_err(|error| {
        let error = error.to_string();
        let place =
            faulty(&values, &error).map_or_else(String::new, |(name, value)| format!("{name} = {}: ", shown(value)));
        wrong_value(format!("law {kind}: {place}{error}"))
    })
}

/// The parameter that an error is about: the one without which it is another error.
fn faulty<'a>(values: &'a Value, error: &str) -> Option<(&'a String, &'a Value)> {
    values.as_object()?.iter().filter(|(name, _)| *name != "kind").find(|(name, _)| {
        let mut others = values.clone();
        others.as_object_mut().map(|table| table.remove(*name));
        LawSpec::deserialize(&others).err().is_none_or(|other| other.to_string() != error)
    })
}

/// A value as messages show it: short.
fn shown(value: &Value) -> String {
    let text = value.to_string();
    if text.chars().count() <= 60 { text } else { text.chars().take(57).chain("...".chars()).collect() }
}

/// The deepest nesting of a parameter: a schedule is a table of lists. A list that holds itself has no end.
const DEEPEST: usize = 8;

/// A parameter as plain data; `None` for other types, a number that is not finite, or deeper nesting.
fn value_of(value: &Bound<'_, PyAny>, depth: usize) -> Option<Value> {
    if value.is_none() {
        return Some(Value::Null);
    }
    // Python's bool is an int, hence this order.
    if let Ok(flag) = value.extract::<bool>() {
        return Some(Value::Bool(flag));
    }
    if value.is_instance_of::<PyFloat>() || value.is_instance_of::<PyInt>() {
        return serde_json::Number::from_f64(value.extract().ok()?).map(Value::Number);
    }
    if value.is_instance_of::<PyString>() {
        return value.extract().ok().map(Value::String);
    }
    let depth = depth.checked_sub(1)?;
    if let Ok(table) = value.cast::<PyDict>() {
        let items = table.iter().map(|(key, item)| Some((key.extract::<String>().ok()?, value_of(&item, depth)?)));
        return items.collect::<Option<Map<String, Value>>>().map(Value::Object);
    }
    if value.is_instance_of::<PyTuple>() || value.is_instance_of::<PyList>() {
        let items = value.try_iter().ok()?.map(|item| value_of(&item.ok()?, depth));
        return items.collect::<Option<Vec<Value>>>().map(Value::Array);
    }
    None
}
