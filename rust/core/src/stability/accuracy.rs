//! The accuracy of a limit.

use crate::linear::lanczos::Goal;

/// Nodes above which a limit need only be within 1 %: products of matrices then take as long as steps, and the search
/// for six digits takes hundreds of them.
const MANY_NODES: usize = 20_000;
/// Largest residuals, relative to the eigenvalue, of the first and of the last mode of a limit within 1 %. The step
/// depends on the root of the eigenvalue: it is too short by at most half of the last.
const FIRST_RESIDUAL: f64 = 0.02;
const LAST_RESIDUAL: f64 = 0.01;

/// The accuracy of a limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Accuracy {
    /// To about six digits.
    Thorough,
    /// To 1 %, from below: eigenvalues are estimated from above.
    Percent,
}

impl Accuracy {
    /// That of a scene of so many nodes.
    pub fn of(nodes: usize) -> Self {
        if nodes > MANY_NODES { Self::Percent } else { Self::Thorough }
    }

    /// That of a mode from which a search begins.
    pub(super) fn first(self) -> Goal {
        match self {
            Self::Thorough => Goal::Convergence,
            Self::Percent => Goal::Residual(FIRST_RESIDUAL),
        }
    }

    /// That of a second mode, from which the search for the one that sets the limit begins; `None` where the first
    /// serves.
    pub(super) fn guess(self) -> Option<Goal> {
        match self {
            Self::Thorough => None,
            Self::Percent => Some(Goal::Guess),
        }
    }

    /// That of the mode that sets the limit.
    pub(super) fn last(self) -> Goal {
        match self {
            Self::Thorough => Goal::Convergence,
            Self::Percent => Goal::Residual(LAST_RESIDUAL),
        }
    }

    /// Relative change of the step at which it has converged.
    pub(super) fn unchanged_step(self) -> f64 {
        match self {
            Self::Thorough => 1e-6,
            Self::Percent => 5e-3,
        }
    }
}
