//! Readings of the elements of the laws, and of the load on the hub.

use nalgebra::Vector3;

use super::Simulation;
use crate::elements::stress::TriangleStress;
use crate::laws::{ContactStatistics, FilmStates, Inspection, Instant, LinkReadings};

/// The load of the sail on the hub, in the turning frame.
///
/// The sail is all nodes, held ones included; the hub holds these and touches others at the spool. The load is that of
/// all forces on the held nodes, inertial forces of the turning frame and of prescribed motion included, less the
/// forces of contact on all nodes: it balances the rate of change of the sail's momentum and angular momentum, less the
/// loads from outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HubLoad {
    /// Force \[N\].
    pub force: [f64; 3],
    /// Torque about the origin \[N m\].
    pub torque: [f64; 3],
    /// Sum of the magnitudes of the forces of contact on the nodes \[N\].
    pub contact: f64,
}

impl Simulation {
    /// Omega of the hub at present \[rad/s\].
    pub fn hub_rate(&self) -> f64 {
        self.instant().frame.rate
    }

    /// Quaternion (w, x, y, z) from components of the hub to those in space, and the displacement of its centre of mass
    /// \[m\].
    pub fn hub_pose(&self) -> ([f64; 4], [f64; 3]) {
        let [_, w, x, y, z, ..] = self.hub_state();
        let centre = self.mechanics.spin.hub.as_ref().map_or_else(Vector3::zeros, |hub| hub.motion.centre);
        ([w, x, y, z], centre.into())
    }

    /// Angular momenta of the hub and of all nodes \[kg m2/s\], in components along the axes of the hub: about the
    /// origin of a hub on an axis, about the fixed point in space where the centre of mass of another one began. Nodes
    /// held on the hub count as nodes. The inertia of a driven hub is not known: 0.
    pub fn momenta(&self) -> [Vector3<f64>; 2] {
        let frame = self.mechanics.spin.at(self.time());
        let (hub, still) = (self.mechanics.spin.hub.as_ref(), Vector3::zeros());
        let (rates, velocity) = frame.carried();
        // From the fixed point to the origin, in components of the hub.
        let start = hub
            .filter(|hub| hub.is_body())
            .map_or(still, |hub| hub.attitude().inverse() * hub.motion.centre - hub.centre());
        let own = hub.map_or(still, |hub| hub.own_momentum(start));
        let of_node = |node: usize| {
            let (x, v) = (self.state.positions.row(node).transpose(), self.state.velocities.row(node).transpose());
            self.mechanics.masses[node] * (start + x).cross(&(v + rates.cross(&x) + velocity))
        };
        [own, (0..self.mechanics.masses.len()).map(of_node).sum()]
    }

    /// Torque of the motor of a free hub about its axis; `None` of a driven one, whose motor exerts what its rate needs
    /// \[N m\].
    pub fn motor_torque(&self) -> Option<f64> {
        let spin = &self.mechanics.spin;
        spin.hub.as_ref().map(|hub| hub.motor_torque(spin.time_of(self.time())))
    }

    /// The laws that can be read, with their names.
    fn inspected(&self) -> impl Iterator<Item = (&'static str, &dyn Inspection)> {
        self.mechanics.laws.iter().filter_map(|law| Some((law.name(), law.inspection()?)))
    }

    /// Readings of the links of one law; `None` without links.
    pub fn links(&self, law: &str) -> Option<LinkReadings> {
        self.inspected().filter(|(name, _)| *name == law).find_map(|(_, law)| law.links(self.instant()))
    }

    /// Stress of each triangle of the film; `None` without a law of the film.
    pub fn film_stress(&self) -> Option<Vec<TriangleStress>> {
        self.inspected().find_map(|(_, law)| law.film_stress(self.instant()))
    }

    /// The largest principal stress of the film, at least 0; `None` without a law of the film or without triangles
    /// \[Pa\].
    pub fn largest_film_stress(&self) -> Option<f64> {
        self.inspected().find_map(|(_, law)| law.largest_film_stress(self.instant()))
    }

    /// State of a film of triangles; `None` without its law.
    pub fn film_states(&self) -> Option<FilmStates> {
        self.inspected().find_map(|(_, law)| law.film_states(self.instant()))
    }

    /// Angle of each crease; `None` without the law \[rad\].
    pub fn crease_angles(&self) -> Option<Vec<f64>> {
        self.inspected().find_map(|(_, law)| law.crease_angles(self.instant()))
    }

    /// What contact between layers has spent; zeros without its law.
    pub fn contact_statistics(&self) -> ContactStatistics {
        self.inspected().find_map(|(_, law)| law.contact_statistics()).unwrap_or_default()
    }

    /// Forces of contact that the hub exerts on the nodes, in external order \[N\].
    pub fn contact_forces(&mut self) -> Vec<[f64; 3]> {
        let at = Instant::new(self.state.at(self.time()), &self.mechanics.spin);
        let [_, contact] = self.mechanics.forces_with_contact(at);
        self.numbering.external_vectors(&contact)
    }

    /// The load of the sail on the hub.
    pub fn hub_load(&mut self) -> HubLoad {
        let at = Instant::new(self.state.at(self.time()), &self.mechanics.spin);
        let at = self.mechanics.with_accelerations(at);
        let [all, by_contact] = self.mechanics.forces_with_contact(at);
        let prescribed = self.mechanics.prescribed_inertia(at.time);
        let (mut force, mut torque, mut contact) = (Vector3::zeros(), Vector3::zeros(), 0.0);
        for (node, &inverse_mass) in self.mechanics.inverse_masses.iter().enumerate() {
            let of_node = |forces: &crate::arrays::state::NodeVectors| forces.row(node).transpose();
            let is_held = inverse_mass == 0.0;
            let own = if is_held { of_node(&all) } else { Vector3::zeros() } - of_node(&by_contact);
            force += own;
            torque += of_node(at.positions).cross(&own);
            contact += if is_held { 0.0 } else { of_node(&by_contact).norm() };
        }
        for (node, inertia) in prescribed {
            force -= inertia;
            torque -= at.positions.row(node).transpose().cross(&inertia);
        }
        HubLoad { force: force.into(), torque: torque.into(), contact }
    }
}
