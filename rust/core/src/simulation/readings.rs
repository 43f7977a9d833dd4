//! Readings of the elements of the laws, and of the load on the hub.

use super::Simulation;
use crate::elements::stress::TriangleStress;
use crate::laws::{FilmStates, Inspection, Instant, LinkReadings};

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

    /// Forces of contact that the hub exerts on the nodes, in external order \[N\].
    pub fn contact_forces(&mut self) -> Vec<[f64; 3]> {
        let at = Instant::new(self.state.at(self.time()), &self.mechanics.spin);
        let [_, contact] = self.mechanics.forces_with_contact(at);
        self.numbering.external_vectors(&contact)
    }

    /// The load of the sail on the hub.
    pub fn hub_load(&mut self) -> HubLoad {
        let at = Instant::new(self.state.at(self.time()), &self.mechanics.spin);
        let [all, by_contact] = self.mechanics.forces_with_contact(at);
        let prescribed = self.mechanics.prescribed_inertia(at.time);
        let (mut force, mut torque, mut contact) = (nalgebra::Vector3::zeros(), nalgebra::Vector3::zeros(), 0.0);
        for (node, &inverse_mass) in self.mechanics.inverse_masses.iter().enumerate() {
            let of_node = |forces: &crate::arrays::state::NodeVectors| forces.row(node).transpose();
            let is_held = inverse_mass == 0.0;
            let own = if is_held { of_node(&all) } else { nalgebra::Vector3::zeros() } - of_node(&by_contact);
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
