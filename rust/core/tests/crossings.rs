//! Crossings of triangles: known pairs, all pairs one by one, and the end of a search.

#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

use std::convert::Infallible;
use std::ops::ControlFlow;

use membrane_core::Error;
use membrane_core::contact::{Crossings, crossings};

type Points = Vec<[f64; 3]>;

fn found(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Crossings {
    match crossings(positions, triangles, usize::MAX, || ControlFlow::<Infallible>::Continue(())).unwrap() {
        ControlFlow::Continue(found) => found,
    }
}

/// Counts of the floor and a second triangle: crossing, overlapping, touching.
fn with_floor(second: [[f64; 3]; 3]) -> [u64; 3] {
    let mut positions = vec![[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
    positions.extend(second);
    let Crossings { count, overlapping, touching, .. } = found(&positions, &[[0, 1, 2], [3, 4, 5]]);
    [count, overlapping, touching]
}

/// Coordinates from -size to size, many of them alike, by a linear congruential generator.
fn tangle(count: usize, size: u64) -> (Points, Vec<[u32; 3]>) {
    let mut seed = 1_u64;
    let mut number = |below: u64| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) % below
    };
    let positions = (0..count).map(|_| [0; 3].map(|_: u8| number(2 * size + 1) as f64 - size as f64)).collect();
    let triangles = (0..count).map(|_| {
        let first = number(count as u64) as u32;
        [0, 1, 2].map(|k| (first + k * (1 + number(3) as u32)) % count as u32)
    });
    (positions, triangles.filter(|[a, b, c]| a != b && b != c && a != c).collect())
}

#[test]
fn a_node_crosses_the_plane_at_the_last_bit() {
    let least = f64::from_bits(1);
    assert_eq!(with_floor([[1.0, 1.0, -least], [1.0, 1.0, 1.0], [2.0, 2.0, 1.0]]), [1, 0, 0]);
    assert_eq!(with_floor([[1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [2.0, 2.0, 1.0]]), [0, 0, 1]);
    assert_eq!(with_floor([[1.0, 1.0, least], [1.0, 1.0, 1.0], [2.0, 2.0, 1.0]]), [0, 0, 0]);
}

#[test]
fn layers_in_one_plane_overlap() {
    assert_eq!(with_floor([[1.0, 1.0, 0.0], [5.0, 1.0, 0.0], [1.0, 5.0, 0.0]]), [0, 1, 0]);
    assert_eq!(with_floor([[4.0, 0.0, 0.0], [4.0, 4.0, 0.0], [0.0, 4.0, 0.0]]), [0, 0, 1]);
}

#[test]
fn all_magnitudes_of_doubles_are_exact() {
    for power in [-1074, -600, 0, 600, 1020] {
        let unit = 2.0_f64.powi(power / 2) * 2.0_f64.powi(power - power / 2);
        let positions: Points = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, -1], [1, 1, 1], [5, 5, 0]]
            .map(|p| p.map(|x| f64::from(x) * unit))
            .into();
        assert_eq!(found(&positions, &[[0, 1, 2], [3, 4, 5]]).pairs, [[0, 1]], "2^{power}");
    }
    let far = [[1e300, 0.0, 0.0], [-1e300, 1e300, 0.0], [-1e300, -1e300, 0.0]];
    let near = [[0.0, 0.0, -1e-300], [1e-300, 0.0, 1e-300], [0.0, 1e-300, 1e-300]];
    assert_eq!(found(&[far, near].concat(), &[[0, 1, 2], [3, 4, 5]]).pairs, [[0, 1]]);
}

#[test]
fn a_small_node_among_large_ones_is_exact_in_either_order() {
    // Two triangles of one plane and on one side of a common side, in a line but for the rounding of the small node.
    let small = [4.963_480_696_735_527_4e-80, 1.489_029_167_013_162e-79, 0.0];
    let positions = [[0.0; 3], [1e300, 3e300, 0.0], [1e300, 0.0, 0.0], small];
    for triangles in [[[0, 1, 2], [0, 1, 3]], [[0, 1, 3], [0, 1, 2]]] {
        let Crossings { count, overlapping, touching, .. } = found(&positions, &triangles);
        assert_eq!([count, overlapping, touching], [0, 1, 0], "{triangles:?}");
    }
}

#[test]
fn the_tree_misses_no_pair() {
    for size in [1, 2, 5, 40] {
        let (positions, triangles) = tangle(200, size);
        let all = found(&positions, &triangles);
        let mut one_by_one = Crossings::default();
        for first in 0..triangles.len() {
            for second in first + 1..triangles.len() {
                let pair = found(&positions, &[triangles[first], triangles[second]]);
                one_by_one.pairs.extend(pair.pairs.iter().map(|_| [first as u32, second as u32]));
                one_by_one.count += pair.count;
                one_by_one.overlapping += pair.overlapping;
                one_by_one.touching += pair.touching;
                one_by_one.candidates += pair.candidates;
            }
        }
        assert!(all.count > 0 && all.touching > 0 && all.candidates < 20_000, "{all:?}");
        assert_eq!(all, one_by_one);
    }
}

#[test]
fn all_are_counted_and_some_listed() {
    let (positions, triangles) = tangle(200, 40);
    let all = found(&positions, &triangles);
    let proceed = || ControlFlow::<Infallible>::Continue(());
    for limit in [0, 1, 10] {
        let ControlFlow::Continue(some) = crossings(&positions, &triangles, limit, proceed).unwrap();
        assert_eq!(some, Crossings { pairs: all.pairs[..limit].to_vec(), ..all.clone() });
    }
}

#[test]
fn a_search_can_be_ended() {
    let triangles = vec![[0, 1, 2]; 1000];
    let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut calls = 0;
    let ended = crossings(&positions, &triangles, 10, || {
        calls += 1;
        if calls == 3 { ControlFlow::Break("enough") } else { ControlFlow::Continue(()) }
    });
    assert_eq!(ended, Ok(ControlFlow::Break("enough")));
    assert_eq!(calls, 3);
}

#[test]
fn nothing_crosses_nothing() {
    assert_eq!(found(&[], &[]), Crossings::default());
    assert_eq!(found(&[[0.0; 3]; 3], &[[0, 1, 2]]), Crossings::default());
    assert_eq!(found(&[[0.0; 3]; 6], &[[0, 1, 2], [3, 4, 5]]), Crossings { candidates: 1, ..Crossings::default() });
}

#[test]
fn bad_input_is_refused() {
    let proceed = || ControlFlow::<Infallible>::Continue(());
    for value in [f64::NAN, f64::INFINITY] {
        let positions = [[0.0; 3], [0.0, value, 0.0], [1.0; 3]];
        let error = crossings(&positions, &[[0, 1, 2]], 1, proceed);
        assert!(matches!(error, Err(Error::NotFinite { node: 1, .. })), "{error:?}");
    }
    let error = crossings(&[[0.0; 3]; 2], &[[0, 1, 2]], 1, proceed);
    assert!(matches!(error, Err(Error::IndexOutOfRange { node: 2, .. })), "{error:?}");
}
