//! Tests of the hub alone.

use super::*;

fn body(inertia: [f64; 3], start: [f64; 3]) -> Hub {
    Hub::new(Freedom::Body { mass: 2.0, inertia }, start.into(), None)
}

#[test]
fn a_symmetric_top_nutates_at_the_rate_of_its_momentum_over_its_transverse_inertia() {
    let mut hub = body([61.0, 61.0, 91.0], [0.1, 0.0, 1.0]);
    let momentum = hub.momentum();
    let (period, steps) = (std::f64::consts::TAU * 61.0 / momentum.norm(), 7);
    (0..steps).for_each(|_| {
        hub.drift(period / f64::from(steps));
    });
    // After a turn about the momentum its axis is where it was.
    assert!((hub.attitude() * Vector3::z() - Vector3::z()).norm() < 1e-13);
    assert!((hub.attitude() * hub.momentum() - momentum).norm() < 1e-12);
}

#[test]
fn any_top_keeps_its_momentum_and_its_energy_at_order_two() {
    let error = |steps: u32| {
        let mut hub = body([1.0, 2.0, 3.5], [0.3, 0.8, 0.5]);
        let (momentum, mut largest) = (hub.momentum(), 0.0_f64);
        for _ in 0..steps {
            hub.drift(10.0 / f64::from(steps));
            assert!((hub.attitude() * hub.momentum() - momentum).norm() < 1e-12);
            largest = largest.max(hub.frame().energy.abs());
        }
        largest
    };
    let (coarse, fine) = (error(400), error(800));
    assert!(coarse > 1e-7 && (coarse / fine - 4.0).abs() < 0.2, "{coarse} {fine}");
}

#[test]
fn nodes_held_anywhere_leave_the_momentum_of_a_free_top_as_it_is() {
    for (x, y, z) in [(0.4, 0.0, 0.1), (0.4, 0.1, 0.0), (0.0, 0.4, 0.1), (0.4, -0.2, 0.1), (0.3, 0.2, 0.4)] {
        let mut hub = body([6.0, 6.0, 9.0], [0.3, 0.1, 1.0]);
        hub.weigh([(0.5, Vector3::new(x, y, z))].into_iter());
        let momentum = hub.momentum();
        (0..50).for_each(|_| {
            hub.drift(0.02);
        });
        let change = (hub.attitude() * hub.momentum() - momentum).norm();
        assert!(change < 1e-12, "{x} {y} {z}: {change}");
    }
}

#[test]
fn a_hub_that_lets_a_node_go_keeps_the_motion_of_its_origin() {
    let held = [(0.5, Vector3::new(0.4, 0.1, 0.0)), (0.3, Vector3::new(-0.2, 0.3, 0.1))];
    let mut hub = body([6.0, 6.0, 9.0], [0.3, 0.1, 1.0]);
    hub.weigh(held.into_iter());
    hub.drift(0.3);
    let mut next = body([6.0, 6.0, 9.0], [0.0; 3]);
    next.weigh(held[..1].iter().copied());
    next.go_on(&hub.state());
    let origin = |hub: &Hub| hub.motion.centre - hub.attitude() * hub.centre();
    assert!((next.velocity_of_origin() - hub.velocity_of_origin()).norm() < 1e-15);
    assert!((origin(&next) - origin(&hub)).norm() < 1e-15);
    assert!((next.centre() - hub.centre()).norm() > 1e-3);
    let of_released = |hub: &Hub| hub.velocity_of_origin() + hub.rates().cross(&held[1].1);
    assert!((of_released(&next) - of_released(&hub)).norm() < 1e-15);
}

#[test]
fn held_nodes_are_weighed_about_the_common_centre() {
    let mut hub = body([0.5, 0.6, 0.7], [0.0; 3]);
    hub.weigh([(2.0, Vector3::new(1.0, 0.0, 0.0))].into_iter());
    assert_eq!((hub.mass, hub.centre), (4.0, Vector3::new(0.5, 0.0, 0.0)));
    let expected = Matrix3::from_diagonal(&Vector3::new(0.5, 0.6 + 1.0, 0.7 + 1.0));
    assert!((hub.inertia - expected).norm() < 1e-15);
}

#[test]
fn numbers_give_the_motion_back() {
    let mut hub = body([1.0, 2.0, 3.5], [0.3, 0.8, 0.5]);
    hub.kick(&Load { force: Vector3::x(), torque: Vector3::y() }, 0.1);
    hub.drift(0.3);
    assert_eq!(HubMotion::from_numbers(&hub.motion.numbers()), Some(hub.motion));
    assert_eq!(HubMotion::from_numbers(&[0.0; 3]), None);
    assert_eq!(HubMotion::from_numbers(&[f64::NAN; NUMBERS]), None);
}
