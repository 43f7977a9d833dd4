//! The mass m in the coefficient c = 2 zeta sqrt(k m) of a dashpot.
//!
//!     mean      m = (m_i + m_j)/2             the form of the paper
//!     reduced   m = m_i m_j/(m_i + m_j)       zeta is the damping ratio of the two nodes as a free pair
//!
//! The elongation s of a free pair has the equation m_r s'' + c s' + k s = 0 with the reduced mass m_r, and therefore
//! the damping ratio c/(2 sqrt(k m_r)). With equal masses the mean is twice the reduced mass: the ratio is
//! sqrt(2) zeta. The reduced mass of a free node and a held one is that of the free node.

use serde::Deserialize;

/// The mass of the nodes of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DashpotMass {
    /// The mean of the nodes.
    Mean,
    /// The reduced mass of two nodes; half the harmonic mean of the nodes of a triangle.
    Reduced,
}

impl DashpotMass {
    /// m of an element, from the masses of its nodes \[kg\] and their inverses, 0 for held nodes \[1/kg\]. Zero where
    /// all are held.
    pub(crate) fn of(self, masses: &[f64], inverse_masses: &[f64]) -> f64 {
        let count = masses.len() as f64;
        match self {
            Self::Mean => masses.iter().sum::<f64>() / count,
            Self::Reduced => {
                let sum: f64 = inverse_masses.iter().sum();
                if sum > 0.0 { 0.5 * count / sum } else { 0.0 }
            }
        }
    }

    /// m of an element whose nodes all have this mass \[kg\] and are free.
    pub(crate) fn of_equal(self, mass: f64) -> f64 {
        match self {
            Self::Mean => mass,
            Self::Reduced => 0.5 * mass,
        }
    }
}
