//! Conversion of a checkpoint to a Python dictionary and back.

use membrane_core::evaluation::ledger::{EnergyTerms, Ledger, Scope};
use membrane_core::integrators::Controller;
use membrane_core::simulation::Simulation as Core;
use membrane_core::simulation::{AdaptiveProgress, Progress, SavedHistory};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{get, numbers, rows, vectors};
use crate::errors::wrong_value;

const WHAT: &str = "saved state";
/// Key of the history of the method.
const METHOD: &str = "history";

/// Key of the history of a law.
fn of_law(law: &str) -> String {
    format!("history_{law}")
}

fn save_history(saved: &Bound<'_, PyDict>, name: &str, (own, numbers): SavedHistory) -> PyResult<()> {
    let py = saved.py();
    saved.set_item(format!("{name}_count"), own.len())?;
    if !own.is_empty() {
        saved.set_item(format!("{name}_vectors"), vectors(py, &own.concat())?)?;
    }
    if !(own.is_empty() && numbers.is_empty()) {
        saved.set_item(format!("{name}_numbers"), PyArray1::from_vec(py, numbers))?;
    }
    Ok(())
}

fn history_of(saved: &Bound<'_, PyDict>, name: &str) -> PyResult<SavedHistory> {
    let key = |part: &str| format!("{name}_{part}");
    let count: usize = get(saved, WHAT, &key("count"))?;
    let mut histories = Vec::new();
    if count > 0 {
        let vectors = key("vectors");
        let all = rows(&vectors, &get::<Bound<'_, PyAny>>(saved, WHAT, &vectors)?)?;
        // The count is that of an array at hand: the memory of the histories is at most that of the array.
        if all.is_empty() || !all.len().is_multiple_of(count) {
            return Err(wrong_value(format!("saved state: {vectors} does not have {count} vectors per node")));
        }
        histories = all.chunks_exact(all.len() / count).map(<[_]>::to_vec).collect();
    }
    let name = key("numbers");
    let numbers = match saved.get_item(&name)? {
        None if count == 0 => Vec::new(),
        _ => numbers(&name, &get::<Bound<'_, PyAny>>(saved, WHAT, &name)?)?,
    };
    Ok((histories, numbers))
}

/// The names of the laws of a simulation.
pub(crate) fn names_of(core: &Core) -> Vec<&'static str> {
    core.laws().iter().map(|law| law.name()).collect()
}

/// The data of a checkpoint, by name.
pub(crate) fn saved_of<'py>(py: Python<'py>, progress: Progress, laws: &[&str]) -> PyResult<Bound<'py, PyDict>> {
    let saved = PyDict::new(py);
    saved.set_item("step_count", progress.step_count)?;
    saved.set_item("evaluation_count", progress.evaluation_count)?;
    saved.set_item("origin", progress.origin)?;
    // Of a run without jumps, states are those of earlier versions.
    if progress.origin_step > 0 {
        saved.set_item("origin_step", progress.origin_step)?;
    }
    if progress.ledger.changes.iter().any(|change| *change != 0.0) {
        saved.set_item("changes", PyArray1::from_vec(py, progress.ledger.changes))?;
    }
    saved.set_item("hub_phase", progress.hub_phase)?;
    saved.set_item("positions", vectors(py, &progress.positions)?)?;
    saved.set_item("velocities", vectors(py, &progress.velocities)?)?;
    saved.set_item("start_kinetic", progress.ledger.start.kinetic)?;
    saved.set_item("start_internal_kinetic", progress.ledger.start.internal_kinetic)?;
    saved.set_item("start_stored", PyArray1::from_vec(py, progress.ledger.start.stored))?;
    let mut work = progress.ledger.work;
    let turning_work = work.pop().unwrap_or_default();
    saved.set_item("work", PyArray1::from_vec(py, work))?;
    if let Some(start_turning) = progress.ledger.start_turning {
        saved.set_item("motor_numbers", PyArray1::from_slice(py, &[start_turning, turning_work]))?;
    }
    saved.set_item("swing", progress.ledger.largest_change)?;
    saved.set_item("start_shift", progress.ledger.start_shift)?;
    save_history(&saved, METHOD, progress.history)?;
    for (law, history) in laws.iter().zip(progress.law_histories) {
        if history != SavedHistory::default() {
            save_history(&saved, &of_law(law), history)?;
        }
    }
    if let Some(time) = progress.output_time {
        saved.set_item("output_time", time)?;
    }
    if let Some(AdaptiveProgress { step_end_time, controller }) = progress.adaptive {
        let output_time = progress.output_time.unwrap_or(step_end_time);
        let numbers = [step_end_time, output_time, controller.dt, controller.last_error];
        saved.set_item("adaptive_numbers", PyArray1::from_slice(py, &numbers))?;
        saved.set_item("adaptive_was_rejected", controller.was_rejected)?;
        saved.set_item("rejected_count", controller.rejected_count)?;
    }
    Ok(saved)
}

/// The checkpoint in a result of `saved_of`.
pub(crate) fn progress_of(saved: &Bound<'_, PyDict>, laws: &[&str]) -> PyResult<Progress> {
    let array = |key: &str| get::<Bound<'_, PyAny>>(saved, WHAT, key);
    let start = EnergyTerms {
        kinetic: get(saved, WHAT, "start_kinetic")?,
        internal_kinetic: get(saved, WHAT, "start_internal_kinetic")?,
        stored: numbers("start_stored", &array("start_stored")?)?,
    };
    // Older checkpoints have the key "memory".
    let of_method = if saved.contains("memory_count")? { "memory" } else { METHOD };
    let history = history_of(saved, of_method)?;
    let of_laws = laws.iter().map(|law| of_law(law)).map(|name| {
        if saved.contains(format!("{name}_count"))? { history_of(saved, &name) } else { Ok(SavedHistory::default()) }
    });
    let law_histories = of_laws.collect::<PyResult<Vec<_>>>()?;
    let mut output_time = if saved.contains("output_time")? { Some(get(saved, WHAT, "output_time")?) } else { None };
    let adaptive = if saved.contains("adaptive_numbers")? {
        let numbers = numbers("adaptive_numbers", &array("adaptive_numbers")?)?;
        let &[step_end_time, time, dt, last_error] = numbers.as_slice() else {
            return Err(wrong_value("saved state: adaptive_numbers does not have four numbers".to_owned()));
        };
        let was_rejected = get(saved, WHAT, "adaptive_was_rejected")?;
        let rejected_count = get(saved, WHAT, "rejected_count")?;
        let controller = Controller { dt, last_error, was_rejected, rejected_count };
        // Older checkpoints have the output time here alone.
        output_time = output_time.or(Some(time).filter(|time| *time != step_end_time));
        Some(AdaptiveProgress { step_end_time, controller })
    } else {
        None
    };
    let has_changes = saved.contains("changes")?;
    let changes = if has_changes { numbers("changes", &array("changes")?)? } else { vec![0.0; laws.len() + 1] };
    let origin_step = if saved.contains("origin_step")? { get(saved, WHAT, "origin_step")? } else { 0 };
    // Older checkpoints lack them.
    let motor = match saved.get_item("motor_numbers")? {
        None => None,
        Some(own) => match numbers("motor_numbers", &own)?.as_slice() {
            &[start_turning, turning_work] => Some((start_turning, turning_work)),
            _ => return Err(wrong_value("saved state: motor_numbers does not have two numbers".to_owned())),
        },
    };
    let mut work = numbers("work", &array("work")?)?;
    work.push(motor.map_or(0.0, |(_, turning_work)| turning_work));
    Ok(Progress {
        step_count: get(saved, WHAT, "step_count")?,
        origin_step,
        evaluation_count: get(saved, WHAT, "evaluation_count")?,
        origin: get(saved, WHAT, "origin")?,
        hub_phase: get(saved, WHAT, "hub_phase")?,
        positions: rows("positions", &array("positions")?)?,
        velocities: rows("velocities", &array("velocities")?)?,
        ledger: Ledger {
            // Follows from the scene.
            scope: Scope::default(),
            start,
            work,
            start_turning: motor.map(|(start_turning, _)| start_turning),
            largest_change: get(saved, WHAT, "swing")?,
            start_shift: get(saved, WHAT, "start_shift")?,
            changes,
        },
        history,
        law_histories,
        adaptive,
        output_time,
    })
}

/// Steps in a saved state above which it is taken as damaged: they would have taken centuries.
const MOST_STEPS: u64 = 1_000_000_000_000_000;
/// Largest size of a time \[s\], at which steps can still be counted.
const LONGEST: f64 = 1e15;

/// Refuses values that no simulation has: numbers that are not finite, and times or counts that cannot be continued.
pub(crate) fn check_values(progress: &Progress) -> PyResult<()> {
    let of = |(vectors, numbers): &SavedHistory| {
        vectors.iter().flatten().flatten().chain(numbers).all(|value| value.is_finite())
    };
    let ledger = &progress.ledger;
    let start = &ledger.start;
    let terms = [start.kinetic, start.internal_kinetic, ledger.largest_change, ledger.start_shift];
    let times = [progress.origin].into_iter().chain(progress.output_time);
    let control =
        progress.adaptive.iter().flat_map(|adaptive| [adaptive.step_end_time, adaptive.controller.last_error]);
    let wrong = |name: &str, why: String| {
        Err(wrong_value(format!("saved state: {name} {why}; it is damaged, give one that Simulation.save wrote")))
    };
    let not_finite = || "holds a value that is not finite".to_owned();
    if let Some(time) = times.chain(control).find(|time| time.is_nan() || time.abs() > LONGEST) {
        return wrong("origin, output_time or adaptive_numbers", format!("= {time}, which is no time of a run"));
    }
    for (name, count) in [("step_count", progress.step_count), ("evaluation_count", progress.evaluation_count / 100)] {
        if count > MOST_STEPS {
            return wrong(name, format!("= {count} is above {MOST_STEPS}"));
        }
    }
    for (name, rows) in [("positions", &progress.positions), ("velocities", &progress.velocities)] {
        if !rows.iter().flatten().all(|value| value.is_finite()) {
            return wrong(name, not_finite());
        }
    }
    let works = ledger.work.iter().chain(&ledger.start_turning).chain(&ledger.changes);
    if !terms.iter().chain(&ledger.start.stored).chain(works).all(|value| value.is_finite()) {
        return wrong(
            "the ledger (start_kinetic, start_stored, work, motor_numbers, swing, start_shift, changes)",
            not_finite(),
        );
    }
    if !of(&progress.history) {
        return wrong("history_vectors or history_numbers", not_finite());
    }
    if !progress.law_histories.iter().all(of) {
        return wrong("the history of a law", not_finite());
    }
    Ok(())
}
