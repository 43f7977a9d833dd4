//! A start from a given motion: one that is set, or that of another simulation of the same nodes, under other laws or
//! parameters.

use super::Simulation;
use crate::arrays::history::History;
use crate::arrays::state::{NodeVectors, State};
use crate::error::{Error, Result};
use crate::evaluation::ledger::Ledger;
use crate::model::checks::{finite, within};
use crate::model::hub_motion::{HubMotion, NUMBERS, driven};
use crate::model::mesh::check_finite;

/// Largest tilt, rate across the axis \[rad/s\] and displacement \[m\] with which a hub goes on upon its axis.
const UPRIGHT: f64 = 1e-9;

impl Simulation {
    /// Sets positions and velocities, in external order, and opens a new ledger. Held nodes stay at rest, and
    /// those that move as prescribed go on from there. Where no position is another one, creases keep their angles, and
    /// layers of the film the distances that they keep; else creases are on their own side.
    ///
    /// # Errors
    /// `LengthMismatch`, `NotFinite`, `StartsCrossed`.
    pub fn set_motion(&mut self, positions: &[[f64; 3]], velocities: &[[f64; 3]]) -> Result<()> {
        for (what, rows) in [("positions", positions), ("velocities", velocities)] {
            let expected = self.mechanics.masses.len();
            if rows.len() != expected {
                return Err(Error::LengthMismatch { what, found: rows.len(), expected, per: "node" });
            }
        }
        check_finite("the position", positions)?;
        check_finite("the velocity", velocities)?;
        let positions = self.numbering.internal_vectors(positions);
        self.mechanics.laws.iter().try_for_each(|law| law.check_start(&positions))?;
        self.continue_from_output();
        let (angles, shapes) = match positions == self.state.positions {
            true => (self.crease_angles(), self.internal_layer_shapes()),
            false => (None, Vec::new()),
        };
        self.state = State { positions, velocities: self.numbering.internal_vectors(velocities) };
        hold(&self.mechanics.inverse_masses, &mut self.state.velocities);
        self.integrator.restore_history(History::default());
        self.restart_moved(angles.as_deref(), &shapes);
        self.open_ledger();
        Ok(())
    }

    /// Starts from positions \[m\] and velocities \[m/s\], in external order, at a time \[s\] and with a hub that moves
    /// as the numbers `hub` say (`hub_state`): a free one goes on as it does, a driven one from its angle at the rate
    /// of this scene. Steps are counted from there, and the ledger is opened anew. `crease_angles` \[rad\] tell whole
    /// turns, which positions do not. Without them, each crease is on its own side. Layers of the film keep the
    /// distances of `layer_shapes`, in external order, and those of the start where there are none.
    ///
    /// # Errors
    /// `OutOfRange`, `LengthMismatch`, `NotFinite`, `StartsCrossed`; the simulation is then unchanged.
    pub fn start_from(
        &mut self,
        time: f64,
        hub: &[f64; NUMBERS],
        positions: &[[f64; 3]],
        velocities: &[[f64; 3]],
        crease_angles: Option<&[f64]>,
        layer_shapes: &[Vec<[f64; 3]>],
    ) -> Result<()> {
        finite("time at the start [s]", time)?;
        hub.iter().try_for_each(|number| finite("number of the state of the hub at the start", *number))?;
        let hub = HubMotion::from_numbers(hub).unwrap_or_default();
        for shape in layer_shapes {
            let (what, expected) = ("positions of a shape of layers", self.mechanics.masses.len());
            if shape.len() != expected {
                return Err(Error::LengthMismatch { what, found: shape.len(), expected, per: "node" });
            }
            check_finite("the position in a shape of layers", shape)?;
        }
        let shapes: Vec<_> = layer_shapes.iter().map(|shape| self.numbering.internal_vectors(shape)).collect();
        if !self.mechanics.spin.hub.as_ref().is_some_and(|hub| hub.is_body()) {
            let tilt = hub.attitude.i.hypot(hub.attitude.j).max(hub.change.xy().norm()).max(hub.centre.norm());
            let range = "a hub on an axis is upright there; start it in six degrees of freedom, with a mass";
            within("tilt of the hub, its rate or its displacement at the start", tilt, tilt < UPRIGHT, range)?;
        }
        self.set_motion(positions, velocities)?;
        self.output = None;
        // A start at a jump is after it, whatever rounding says.
        let jump = self.jumps.iter().copied().find(|&jump| self.is_same_time(jump, time));
        let time = jump.map_or(time, |jump| jump.max(time));
        self.count_anew(time);
        self.roll_back_adaptive(time);
        self.mechanics.spin = self.mechanics.spin.clone().through(time, hub.angle);
        if let Some(free) = &mut self.mechanics.spin.hub {
            free.go_on(&hub);
        }
        self.restart_moved(crease_angles, &shapes);
        self.open_ledger();
        Ok(())
    }

    /// The motion of the hub with its rates, with which another simulation may go on, see `HubMotion`.
    pub fn hub_state(&self) -> [f64; NUMBERS] {
        let frame = self.mechanics.spin.at(self.time());
        let of_driven = || driven(frame.angle, frame.rate);
        self.mechanics.spin.hub.as_ref().map_or_else(of_driven, |hub| hub.state()).numbers()
    }

    /// The shapes whose distances layers of the film keep, in external order \[m\]; none without their contact.
    pub fn layer_shapes(&self) -> Vec<Vec<[f64; 3]>> {
        self.internal_layer_shapes().iter().map(|shape| self.numbering.external_vectors(shape)).collect()
    }

    fn internal_layer_shapes(&self) -> Vec<NodeVectors> {
        let laws = self.mechanics.laws.iter().filter_map(|law| law.history_dependent());
        laws.map(|law| law.layer_shapes()).find(|shapes| !shapes.is_empty()).unwrap_or_default().to_vec()
    }

    /// Starts the histories of the laws anew, and with them the prescribed motion of nodes, from where these are, the
    /// turns of creases as their angles tell, and the distances that layers keep.
    fn restart_moved(&mut self, crease_angles: Option<&[f64]>, layer_shapes: &[NodeVectors]) {
        self.mechanics.restore_histories(&[]);
        if !layer_shapes.is_empty() {
            let laws = self.mechanics.laws.iter_mut().filter_map(|law| law.history_dependent_mut());
            laws.for_each(|law| law.set_layer_shapes(layer_shapes));
        }
        if let Some(angles) = crease_angles {
            let laws = self.mechanics.laws.iter_mut().filter_map(|law| law.history_dependent_mut());
            laws.for_each(|law| law.set_crease_angles(angles));
        }
        self.start_moved();
    }

    /// Sets the nodes that move as prescribed to their motion, which starts from where they are unless it was restored.
    pub(super) fn start_moved(&mut self) {
        let time = self.time();
        self.mechanics.start_moved(self.state.at(time));
        self.mechanics.set_moved(time, &mut self.state, &mut vec![0.0; self.mechanics.laws.len()]);
    }

    /// Sets the nodes that move as prescribed to their motion at the end of a step.
    pub(super) fn set_moved(&mut self) {
        let time = self.step_end_time();
        self.mechanics.set_moved(time, &mut self.state, &mut self.ledger.work);
    }

    /// Opens the ledger anew, with the present motion as its start and as the last good state.
    pub(super) fn open_ledger(&mut self) {
        self.mechanics.weigh_hub(&self.state.positions);
        let turning = self.mechanics.turning_energy(self.state.at(self.time()));
        self.ledger = Ledger::open(self.mechanics.scope(), self.energy_terms(), turning);
        self.record_good(self.ledger.start.clone());
    }
}

/// Sets the velocities of held nodes to zero.
pub(super) fn hold(inverse_masses: &[f64], velocities: &mut NodeVectors) {
    for (i, &inverse) in inverse_masses.iter().enumerate() {
        if inverse == 0.0 {
            velocities.row_mut(i).fill(0.0);
        }
    }
}
