//! The first list: pairs of all elements, by a tree of boxes around them and their ways.

use std::ops::ControlFlow;

use super::look::{LEVELS, Narrow};
use super::pairs::{Lines, Listed, Pairs, Step};
use super::surface::Surface;
use crate::arrays::state::columns;
use crate::contact::box_tree::{Bounds, BoxTree};
use crate::simd::dispatch::InstructionSet;

/// Boxes around elements and their ways, their tree, and pairs of some: memory that each first list uses again.
#[derive(Default)]
pub(super) struct Elements {
    boxes: Vec<Bounds>,
    tree: BoxTree,
    found: Pairs,
}

/// The pairs that may come nearer than a bound and a skin: of elements whose boxes, around them and their ways, meet.
pub(super) struct First<'a> {
    pub(super) surface: &'a Surface,
    pub(super) lines: Lines<'a>,
    pub(super) bound: f64,
    pub(super) skin: f64,
}

impl First<'_> {
    /// Finds them, of nodes that go these ways, by levels.
    pub(super) fn find(
        &self,
        ways: Step<'_>,
        of: &mut Elements,
        instructions: InstructionSet,
        into: &mut [Pairs; LEVELS],
    ) {
        const AT_ONCE: usize = 4096;
        let Self { surface, lines, bound, skin } = *self;
        let (x, v) = (columns(ways.positions), columns(ways.velocities));
        let half = 0.5 * (bound + skin);
        let Elements { boxes, tree, found } = of;
        boxes.clear();
        boxes.extend(surface.elements.iter().map(|element| {
            let [a, b, c] = element.corners.map(|node| {
                let now: [f64; 3] = std::array::from_fn(|axis| x[axis][node as usize]);
                [now, std::array::from_fn(|axis| now[axis] + lines.duration * v[axis][node as usize])]
            });
            let Bounds { low, high } = Bounds::of([a, b, c].as_flattened());
            Bounds { low: low.map(|least| least - half), high: high.map(|most| most + half) }
        }));
        let is_finite = boxes.iter().all(|bounds| bounds.low.iter().chain(&bounds.high).all(|value| value.is_finite()));
        if !is_finite {
            // A motion that diverges is found by the monitor.
            return;
        }
        tree.rebuild(boxes);
        let mut narrow = |found: &mut Pairs| {
            let from = std::slice::from_ref(&*found);
            instructions.dispatch(Narrow { surface, from, lines, bound, skin, into: &mut *into });
            found.clear();
        };
        let _: ControlFlow<()> = tree.visit_pairs(&mut |slot, leaf, mut meeting| {
            while meeting != 0 {
                let other = leaf + meeting.trailing_zeros() as usize;
                meeting &= meeting - 1;
                let [first, second] = [slot, other].map(|slot| tree.order()[slot] as usize);
                surface.visit_pairs(first, second, &mut |pair| found.push(Listed { pair, kept: 0.0 }));
            }
            if found.most() >= AT_ONCE {
                narrow(found);
            }
            ControlFlow::Continue(())
        });
        narrow(found);
    }
}
