//! The largest step at which a method amplifies no solution of an oscillator.

use crate::integrators::Integrator;

/// The oscillator x'' = -omega^2 x - damping x'.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mode {
    pub(super) omega: f64,
    pub(super) damping: f64,
}

/// The largest step up to which `integrator` amplifies no solution of the oscillator \[s\].
pub(super) fn largest_step(integrator: &dyn Integrator, mode: Mode) -> f64 {
    if integrator.properties().is_implicit {
        return f64::INFINITY;
    }
    let Mode { omega, damping } = mode;
    // Modulus of the larger root of lambda^2 + damping lambda + omega^2.
    let half = 0.5 * damping;
    let modulus = if half > omega { half + (half * half - omega * omega).sqrt() } else { omega };
    if modulus == 0.0 {
        return f64::INFINITY;
    }
    let stable = |z: f64| integrator.amplification(omega, damping, z / modulus) <= 1.0 + 1e-12;
    // A search from zero for the first unstable point, then bisection: further stable intervals may lie beyond.
    let mut high = 0.01;
    while stable(high) && high < 1e3 {
        high += 0.01;
    }
    let mut low = high - 0.01;
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if stable(middle) { low = middle } else { high = middle }
    }
    low / modulus
}

/// The limits of `integrator` on the imaginary axis, in omega dt, and on the negative real one, in damping dt.
pub fn axis_limits(integrator: &dyn Integrator) -> [f64; 2] {
    [Mode { omega: 1.0, damping: 0.0 }, Mode { omega: 0.0, damping: 1.0 }].map(|mode| largest_step(integrator, mode))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrators::{Options, by_name};

    #[test]
    fn limits_on_the_axes_are_those_of_the_textbook() {
        let known =
            [("rk4", 8.0_f64.sqrt(), 2.785_293_563_4), ("leapfrog", 2.0, 1.0), ("dopri5", 0.997_189, 3.306_568)];
        for (name, on_imaginary_axis, on_real_axis) in known {
            let method = (by_name(name).unwrap().make)(&Options::default());
            let [imaginary, real] = axis_limits(method.as_ref());
            assert!((imaginary - on_imaginary_axis).abs() < 1e-4, "{name}: {imaginary}");
            assert!((real - on_real_axis).abs() < 1e-4, "{name}: {real}");
        }
    }

    #[test]
    fn damping_shortens_the_step_of_leapfrog_by_the_closed_form() {
        let leapfrog = (by_name("leapfrog").unwrap().make)(&Options::default());
        for ratio in [0.0, 0.02, 0.1, 0.5, 1.0, 2.0, 10.0] {
            let found = largest_step(leapfrog.as_ref(), Mode { omega: 3.0, damping: 6.0 * ratio });
            let exact = 2.0 * ((4.0 * ratio * ratio + 1.0).sqrt() - 2.0 * ratio) / 3.0;
            assert!((found / exact - 1.0).abs() < 1e-5, "zeta {ratio}: {found} {exact}");
        }
    }
}
