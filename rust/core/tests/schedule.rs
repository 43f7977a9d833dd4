//! Schedules: values at and between knots, derivatives and integral against differences and quadrature, errors.
#![allow(missing_docs, clippy::unwrap_used)]

use membrane_core::error::Error;
use membrane_core::model::schedule::{MOST_KNOTS, Schedule};
use serde_json::json;

const EASES: [f64; 5] = [0.0, 0.01, 0.2, 0.37, 0.5];

fn example(ease: f64) -> Schedule {
    Schedule::new(vec![-1.0, 0.5, 0.75, 4.0], vec![2.0, -1.0, -1.0, 7.5], ease).unwrap()
}

#[test]
fn knots_are_met_and_values_beyond_stay() {
    for ease in EASES {
        let schedule = example(ease);
        for (&time, &value) in schedule.times().iter().zip(schedule.values()) {
            assert_eq!(schedule.value(time), value);
        }
        assert_eq!([schedule.value(-1e9), schedule.value(1e9), schedule.last()], [2.0, 7.5, 7.5]);
        assert_eq!([schedule.rate(-2.0), schedule.rate(5.0), schedule.second(5.0)], [0.0; 3]);
        assert_eq!(schedule.largest(), 7.5);
        assert!((schedule.largest_rate() - 8.5 / 3.25 / (1.0 - ease)).abs() < 1e-14);
    }
}

#[test]
fn eased_segments_follow_the_formula() {
    let schedule = Schedule::new(vec![0.0, 1.0], vec![0.0, 1.0], 0.5).unwrap();
    // u = 1/2: p = (1/8 - 1/32) = 3/32, w = 1/2 of the full rate 2, slope 2 * 6/4 / (1/2).
    assert_eq!(schedule.value(0.25), 3.0 / 32.0);
    assert_eq!(schedule.value(0.75), 29.0 / 32.0);
    assert_eq!([schedule.value(0.5), schedule.rate(0.5), schedule.rate(0.25)], [0.5, 2.0, 1.0]);
    assert_eq!([schedule.second(0.25), schedule.second(0.75)], [6.0, -6.0]);
    let linear = Schedule::new(vec![0.0, 2.0], vec![1.0, 5.0], 0.0).unwrap();
    assert_eq!([linear.value(0.5), linear.rate(0.0), linear.rate(2.0), linear.integral(2.0)], [2.0, 2.0, 0.0, 6.0]);
}

#[test]
fn derivatives_and_integral_agree() {
    let step = 1e-5;
    for ease in EASES {
        let schedule = example(ease);
        for i in 0..700 {
            let time = -1.5 + 0.0083 * f64::from(i) + 1.3e-4;
            if schedule.times().iter().any(|knot| (time - knot).abs() < 2.0 * step) {
                continue;
            }
            let [before, after] = [time - step, time + step];
            let rate = (schedule.value(after) - schedule.value(before)) / (2.0 * step);
            assert!((rate - schedule.rate(time)).abs() < 2e-4, "{ease} {time}: {rate} {}", schedule.rate(time));
            let value = (schedule.integral(after) - schedule.integral(before)) / (2.0 * step);
            assert!((value - schedule.value(time)).abs() < 1e-6, "{ease} {time}");
            let second = (schedule.rate(after) - schedule.rate(before)) / (2.0 * step);
            let bound = if ease == 0.0 { 1e-9 } else { 2e-4 * schedule.largest_rate() / (ease * ease * 0.0625) };
            assert!((second - schedule.second(time)).abs() < bound, "{ease} {time} {second} {}", schedule.second(time));
        }
        assert_eq!(schedule.integral(-1.0), 0.0);
        assert_eq!(schedule.integral(-2.0), -2.0);
    }
}

#[test]
fn two_knots_at_one_time_are_a_jump() {
    for ease in EASES {
        let schedule =
            Schedule::new(vec![0.0, 0.0, 1.0, 1.0, 2.0, 2.0], vec![5.0, 1.0, 3.0, -3.0, -4.0, 7.0], ease).unwrap();
        let before = |time: f64| time.next_down();
        for (time, value) in [(before(0.0), 5.0), (0.0, 1.0), (1.0, -3.0), (2.0, 7.0), (9.0, 7.0)] {
            assert_eq!(schedule.value(time), value);
        }
        for (time, value, rate) in [(before(1.0), 3.0, 2.0), (before(2.0), -4.0, -1.0)] {
            assert!((schedule.value(time) - value).abs() < 1e-14);
            assert!((schedule.rate(time) - if ease == 0.0 { rate } else { 0.0 }).abs() < 1e-12);
        }
        assert_eq!([schedule.integral(0.0), schedule.integral(1.0), schedule.integral(3.0)], [0.0, 2.0, 5.5]);
        assert_eq!(schedule.jumps().collect::<Vec<_>>(), [0.0, 1.0, 2.0]);
        assert!((schedule.largest_rate() - 2.0 / (1.0 - ease)).abs() < 1e-14);
    }
}

#[test]
fn rates_are_continuous_with_easing() {
    for ease in [0.01, 0.2, 0.5] {
        let schedule = example(ease);
        for &knot in schedule.times() {
            for near in [knot - 1e-9, knot + 1e-9] {
                assert!(schedule.rate(near).abs() < 1e-6);
                assert!(schedule.second(near).abs() < 1e-9 * 60.0 * schedule.largest_rate() / (ease * ease * 0.0625));
            }
        }
    }
}

#[test]
fn bad_knots_are_refused_with_their_place() {
    let new = |times: &[f64], values: &[f64], ease| Schedule::new(times.to_vec(), values.to_vec(), ease);
    let refused = [
        (new(&[], &[], 0.0), "number of times"),
        (new(&[0.0, 1.0], &[0.0], 0.0), "values of a schedule has 1 rows but 2"),
        (new(&[0.0, 1.0], &[0.0, 1.0], 0.51), "ease"),
        (new(&[0.0, 1.0], &[0.0, 1.0], f64::NAN), "ease"),
        (new(&[1.0, 1.0, 1.0], &[0.0, 1.0, 2.0], 0.0), "times[2]"),
        (new(&[0.0, -1.0], &[0.0, 1.0], 0.0), "times[1]"),
        (new(&[0.0, f64::NAN], &[0.0, 1.0], 0.0), "times[1]"),
        (new(&[0.0, 1.0], &[0.0, f64::INFINITY], 0.0), "values[1]"),
        (new(&[0.0, 1e-320], &[0.0, 1.0], 0.0), "times[1]"),
        (new(&[0.0, 1.0], &[0.0, 1.0], 1e-310), "times[1]"),
        (new(&[-1.7e308, 1.7e308], &[0.0, 1.0], 0.0), "times[1]"),
        (new(&[0.0, 1e200], &[1e200, 1e200], 0.0), "times[1]"),
        (new(&vec![0.0; MOST_KNOTS + 1], &vec![0.0; MOST_KNOTS + 1], 0.0), "number of times"),
    ];
    for (found, place) in refused {
        let text = found.expect_err(place).to_string();
        assert!(text.contains(place), "{text}");
    }
    assert!(matches!(new(&[1.0, 0.0], &[0.0, 1.0], 0.0), Err(Error::Knot { index: 1, .. })));
}

#[test]
fn knots_are_read_from_data() {
    let table = json!({"times": [0.0, 1.0], "values": [2.0, 3.0], "ease": 0.25});
    let read: Schedule = serde_json::from_value(table).unwrap();
    assert_eq!(read, Schedule::new(vec![0.0, 1.0], vec![2.0, 3.0], 0.25).unwrap());
    for wrong in [
        json!({"times": [0.0], "values": [2.0]}),
        json!({"times": [0.0], "values": [2.0], "ease": 0.1, "kind": "cubic"}),
        json!({"times": [1.0, 0.0], "values": [2.0, 3.0], "ease": 0.25}),
    ] {
        assert!(serde_json::from_value::<Schedule>(wrong).is_err());
    }
}
