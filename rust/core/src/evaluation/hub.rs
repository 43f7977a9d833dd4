//! The free hub in the evaluations of a method: what the sail exerts on it, and the powers that turn with it.
//!
//! Forces within the whole of hub and sail have no sum and no torque. What acts on the hub is therefore the reaction to
//! the forces on all free nodes but those from outside, whatever law and whatever contact transmits it:
//!
//!     F = -sum m a + F_out,    tau = -sum m (x - c) x a + tau_out + tau_motor
//!
//! with sums over free nodes, a the forces in space over m, and F_out and tau_out those of the loads from outside on
//! all nodes and on the hub itself, which their laws report (`Law::outside_load`).

use nalgebra::Vector3;

use super::mechanics::Mechanics;
use crate::arrays::state::{NodeVectors, PhasePoint, columns};
use crate::integrators::evaluate;
use crate::laws::{Instant, WorkClass};
use crate::model::load::Load;
use crate::simd::lanes::SimdF64;
use crate::simd::map::{Formula, each};

/// m (x a_y - y a_x), with x and y from a centre.
struct Moment {
    centre: [f64; 2],
}

impl Formula<5, 0> for Moment {
    #[inline(always)]
    fn row<V: SimdF64>(&self, _: [V; 5], _: [V; 0]) -> [V; 0] {
        []
    }

    #[inline(always)]
    fn summand<V: SimdF64>(&self, [mass, x, y, ax, ay]: [V; 5], _: [V; 0]) -> V {
        let (cx, cy) = (V::all(self.centre[0]), V::all(self.centre[1]));
        mass * ((x - cx) * ay - (y - cy) * ax)
    }
}

/// m a.
struct Weighted;

impl Formula<2, 0> for Weighted {
    #[inline(always)]
    fn row<V: SimdF64>(&self, _: [V; 2], _: [V; 0]) -> [V; 0] {
        []
    }

    #[inline(always)]
    fn summand<V: SimdF64>(&self, [mass, a]: [V; 2], _: [V; 0]) -> V {
        mass * a
    }
}

impl Mechanics {
    /// Makes the held nodes parts of the free hub, at their positions.
    pub(crate) fn weigh_hub(&mut self, positions: &NodeVectors) {
        let Self { spin, held, masses, .. } = self;
        if let Some(hub) = &mut spin.hub {
            hub.weigh(held.iter().map(|&node| (masses[node], positions.row(node).transpose())));
        }
    }

    /// The law of the frame, where the hub is free: its history is the motion of the hub.
    pub(crate) fn hub_law(&self) -> Option<&'static str> {
        self.hub_row.map(|row| self.laws[row].name())
    }

    /// Inverse masses for bounds of the step \[1/kg\]: nodes held on a free hub share its inertia as if each were free.
    /// The hub is such nodes bound to each other, and no frequency grows by a bond. See `Hub::shares`.
    pub(crate) fn inverse_masses_of_bounds(&self, positions: &NodeVectors) -> Vec<f64> {
        let mut all = self.inverse_masses.clone();
        if let Some(hub) = &self.spin.hub {
            let places = self.held.iter().map(|&node| positions.row(node).transpose());
            self.held.iter().zip(hub.shares(places)).for_each(|(&node, share)| all[node] = share.recip());
        }
        all
    }

    /// See `System::hub_load`.
    pub(super) fn load_on_hub(&self, at: PhasePoint<'_>, accelerations: &NodeVectors) -> Load {
        let Some(hub) = &self.spin.hub else { return Load::default() };
        let (x, a, masses) = (columns(at.positions), columns(accelerations), self.masses.as_slice());
        let centre = hub.centre();
        let moment = |i: usize, j: usize| {
            let formula = Moment { centre: [centre[i], centre[j]] };
            each(self.instructions, &formula, [masses, x[i], x[j], a[i], a[j]], [])
        };
        let mut outside = Load::default();
        self.outside_loads.iter().for_each(|load| outside += *load);
        let outside = outside.about(&centre);
        let about_axis = outside.torque.z + hub.motor_torque(self.spin.time_of(at.time)) - moment(0, 1);
        if !hub.is_body() {
            return Load { torque: Vector3::new(0.0, 0.0, about_axis), ..Load::default() };
        }
        let sum = |k: usize| -each(self.instructions, &Weighted, [masses, a[k]], []);
        Load {
            force: Vector3::new(sum(0), sum(1), sum(2)) + outside.force,
            torque: Vector3::new(outside.torque.x - moment(1, 2), outside.torque.y - moment(2, 0), about_axis),
        }
    }

    /// See `System::hub_power`.
    pub(super) fn add_hub_power(&self, time: f64, powers: &mut [f64]) {
        let (Some(row), Some(hub)) = (self.hub_row, &self.spin.hub) else { return };
        let (rates, velocity) = (hub.rates(), hub.velocity_of_origin());
        powers[row] += rates.z * hub.motor_torque(self.spin.time_of(time));
        for ((power, load), law) in powers.iter_mut().zip(&self.outside_loads).zip(&self.laws) {
            if law.properties().work_class != WorkClass::Conservative {
                *power += load.power(&rates, &velocity);
            }
        }
    }

    /// Sets the accelerations of the frame of a free hub, for readings.
    pub(crate) fn with_accelerations<'a>(&mut self, mut at: Instant<'a>) -> Instant<'a> {
        if self.hub_row.is_none() {
            return at;
        }
        let (mut accelerations, mut powers) = (NodeVectors::zeros(self.masses.len()), vec![0.0; self.laws.len() + 1]);
        let point = PhasePoint { time: at.time, positions: at.positions, velocities: at.velocities };
        let count = self.evaluation_count;
        evaluate(self, point, &mut accelerations, &mut powers);
        self.evaluation_count = count;
        let load = self.load_on_hub(point, &accelerations);
        if let (Some(frame), Some(hub)) = (&mut at.frame.hub, &self.spin.hub) {
            let [turning, _, of_origin] = hub.accelerations(&load);
            frame.accelerations = [turning, of_origin];
            at.frame.acceleration = turning.z;
        }
        at
    }
}
