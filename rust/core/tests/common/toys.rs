//! A law and a method outside the lists, as a contributor would write them: every test over a list also tests the
//! recipes of CONTRIBUTING.md.

use std::ops::Range;

use membrane_core::arrays::history::History;
use membrane_core::arrays::jacobian::{Block, JacobianBlocks};
use membrane_core::arrays::state::{NodeVectors, State, rows};
use membrane_core::assembly::Assembly;
use membrane_core::integrators::{Integrator, Method, Options, Properties as MethodProperties, System};
use membrane_core::laws::{HistoryDependent, Instant, Kernels, Law, Linearisation, NodalLaw, Properties, WorkClass};

/// Friction that decreases with the distance covered by the nodes, F = -c v / (1 + wear): a law with a history.
pub struct WearingFriction {
    /// c of each node \[N s/m\].
    coefficients: Vec<f64>,
    /// Positions at the last accepted step, none before the first, and the wear there.
    last: Option<NodeVectors>,
    wear: f64,
    /// Factor of the power: 1, except in the test of a faulty law.
    pub fault: f64,
}

impl WearingFriction {
    pub fn new(assembly: &Assembly) -> Self {
        Self {
            coefficients: assembly.masses.iter().map(|mass| 5.0 * mass).collect(),
            last: None,
            wear: 0.0,
            fault: 1.0,
        }
    }

    fn factor(&self) -> f64 {
        1.0 / (1.0 + self.wear)
    }
}

impl NodalLaw for WearingFriction {
    fn add_to_rows(&mut self, range: Range<usize>, at: Instant<'_>, forces: [&mut [f64]; 3]) -> f64 {
        let mut power = 0.0;
        for (force, velocity) in forces.into_iter().zip(rows(at.velocities, range.clone())) {
            for ((f, v), c) in force.iter_mut().zip(velocity).zip(&self.coefficients[range.clone()]) {
                *f -= c * self.factor() * v;
                power -= self.fault * c * self.factor() * v * v;
            }
        }
        power
    }
}

impl Law for WearingFriction {
    fn properties(&self) -> Properties {
        let work_class = WorkClass::Dissipative;
        Properties { name: "wearing_friction", work_class, depends_on_velocity: true, is_internal: false }
    }

    fn kernels(&self) -> Kernels {
        Kernels::default()
    }

    fn nodal(&mut self) -> Option<&mut dyn NodalLaw> {
        Some(self)
    }

    fn linearisation(&self) -> Option<&dyn Linearisation> {
        Some(self)
    }

    fn history_dependent(&self) -> Option<&dyn HistoryDependent> {
        Some(self)
    }

    fn history_dependent_mut(&mut self) -> Option<&mut dyn HistoryDependent> {
        Some(self)
    }

    fn remedy(&self) -> &'static str {
        "use a smaller dt"
    }
}

impl HistoryDependent for WearingFriction {
    fn accept(&mut self, at: Instant<'_>) {
        if let Some(last) = &self.last {
            self.wear += 10.0 * (at.positions - last).amax();
        }
        self.last = Some(at.positions.clone());
    }

    fn history(&self) -> History {
        self.last
            .as_ref()
            .map_or_else(History::default, |last| History { vectors: vec![last.clone()], numbers: vec![self.wear] })
    }

    fn restore_history(&mut self, mut history: History) -> bool {
        (self.last, self.wear) = match (history.vectors.pop(), &history.numbers[..]) {
            (None, []) => (None, 0.0),
            (Some(last), [wear]) => (Some(last), *wear),
            _ => return false,
        };
        history.vectors.is_empty()
    }
}

impl Linearisation for WearingFriction {
    fn add_damping_product(&self, factor: f64, _at: Instant<'_>, p: &NodeVectors, out: &mut NodeVectors) {
        for (node, c) in self.coefficients.iter().enumerate() {
            (0..3).for_each(|axis| out[(node, axis)] += factor * c * self.factor() * p[(node, axis)]);
        }
    }

    fn add_jacobian(&self, _at: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        for (node, c) in self.coefficients.iter().enumerate() {
            jacobian.by_velocity(node as u32, node as u32, &(Block::identity() * (-c * self.factor())));
        }
    }
}

/// The semi-implicit method of Euler: v' = v + dt a(t, x, v), x' = x + dt v'; order 1, stable to omega dt = 2.
pub const SEMI_IMPLICIT_EULER: Method = Method {
    name: "semi_implicit_euler",
    make: |options: &Options| {
        let accelerations = NodeVectors::zeros(options.nodes);
        Box::new(SemiImplicitEuler { accelerations, powers: vec![0.0; options.works] })
    },
};

struct SemiImplicitEuler {
    accelerations: NodeVectors,
    powers: Vec<f64>,
}

impl Integrator for SemiImplicitEuler {
    fn properties(&self) -> MethodProperties {
        MethodProperties {
            name: "semi_implicit_euler",
            order: 1,
            frequency_error: (1.0 / 24.0, 2),
            evaluations_per_step: 1,
            evaluations_at_start: 0,
            conserves_energy: false,
            predicts_velocity: false,
            is_implicit: false,
            damping_weight: None,
        }
    }

    fn amplification(&self, omega: f64, damping: f64, dt: f64) -> f64 {
        let (z, c) = ((omega * dt).powi(2), damping * dt);
        // The eigenvalues of the amplification matrix of (x, dt v), from half its trace and its determinant: a complex
        // pair, or two real ones.
        let (half_trace, determinant) = (1.0 - 0.5 * (z + c), 1.0 - c);
        let discriminant = half_trace * half_trace - determinant;
        if discriminant < 0.0 { determinant.sqrt() } else { half_trace.abs() + discriminant.sqrt() }
    }

    fn step(&mut self, system: &mut dyn System, time: f64, dt: f64, state: &mut State, work: &mut [f64]) {
        system.accelerate(state.at(time), &mut self.accelerations, &mut self.powers);
        state.velocities += &self.accelerations * dt;
        state.positions += &state.velocities * dt;
        work.iter_mut().zip(&self.powers).for_each(|(work, power)| *work += dt * power);
    }
}

/// A circulatory load F = c m (-y, x, 0): it depends on positions alone and has no potential.
pub struct Circulation {
    /// c m of each node \[N/m\].
    coefficients: Vec<f64>,
    /// Factor of the power: 1, except in the test of a faulty law.
    fault: f64,
}

impl Circulation {
    pub fn new(assembly: &Assembly, rate: f64, fault: f64) -> Self {
        Self { coefficients: assembly.masses.iter().map(|mass| rate * mass).collect(), fault }
    }
}

impl NodalLaw for Circulation {
    fn add_to_rows(&mut self, range: Range<usize>, at: Instant<'_>, [fx, fy, _]: [&mut [f64]; 3]) -> f64 {
        let [x, y, _] = rows(at.positions, range.clone());
        let [u, v, _] = rows(at.velocities, range.clone());
        let mut power = 0.0;
        for (i, c) in self.coefficients[range].iter().enumerate() {
            let force = [-c * y[i], c * x[i]];
            fx[i] += force[0];
            fy[i] += force[1];
            power += self.fault * (force[0] * u[i] + force[1] * v[i]);
        }
        power
    }
}

impl Law for Circulation {
    fn properties(&self) -> Properties {
        let work_class = WorkClass::External;
        Properties { name: "circulation", work_class, depends_on_velocity: false, is_internal: false }
    }

    fn kernels(&self) -> Kernels {
        Kernels::default()
    }

    fn nodal(&mut self) -> Option<&mut dyn NodalLaw> {
        Some(self)
    }

    fn linearisation(&self) -> Option<&dyn Linearisation> {
        Some(self)
    }

    fn remedy(&self) -> &'static str {
        "use a smaller dt"
    }
}

impl Linearisation for Circulation {
    fn add_jacobian(&self, _at: Instant<'_>, jacobian: &mut dyn JacobianBlocks) {
        for (node, c) in self.coefficients.iter().enumerate() {
            let block = Block::new(0.0, -c, 0.0, *c, 0.0, 0.0, 0.0, 0.0, 0.0);
            jacobian.by_position(node as u32, node as u32, &block);
        }
    }
}
