//! A tree of boxes, and the pairs of boxes that have a point in common.
//!
//! Boxes are halved by their centres along the axis on which these lie widest apart, down to leaves of eight: a binary
//! tree of equal depth, whatever the boxes. Two subtrees are compared only if the bounds of both meet.

use std::ops::ControlFlow;

/// Boxes of a leaf.
pub(super) const LEAF: usize = 8;

/// A box along the axes, by its least and its largest coordinates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounds {
    pub(crate) low: [f64; 3],
    pub(crate) high: [f64; 3],
}

impl Bounds {
    const EMPTY: Self = Self { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };

    /// The smallest box around points.
    pub(crate) fn of(points: &[[f64; 3]]) -> Self {
        points.iter().fold(Self::EMPTY, |bounds, &point| bounds.with(&Self { low: point, high: point }))
    }

    fn with(self, other: &Self) -> Self {
        let (mut low, mut high) = (self.low, self.high);
        for axis in 0..3 {
            low[axis] = low[axis].min(other.low[axis]);
            high[axis] = high[axis].max(other.high[axis]);
        }
        Self { low, high }
    }

    pub(crate) fn meets(&self, other: &Self) -> bool {
        (0..3).all(|axis| self.low[axis] <= other.high[axis] && other.low[axis] <= self.high[axis])
    }
}

/// The boxes of a leaf, coordinate by coordinate; those that it lacks are empty.
#[derive(Clone)]
struct Leaf {
    low: [[f64; LEAF]; 3],
    high: [[f64; LEAF]; 3],
}

impl Leaf {
    const EMPTY: Self = Self { low: [[f64::INFINITY; LEAF]; 3], high: [[f64::NEG_INFINITY; LEAF]; 3] };

    fn set(&mut self, lane: usize, bounds: &Bounds) {
        for axis in 0..3 {
            self.low[axis][lane] = bounds.low[axis];
            self.high[axis][lane] = bounds.high[axis];
        }
    }

    fn get(&self, lane: usize) -> Bounds {
        Bounds { low: self.low.map(|along| along[lane]), high: self.high.map(|along| along[lane]) }
    }

    /// One bit for each box, set where it meets another one.
    fn meeting(&self, other: &Bounds) -> u32 {
        // The widest gap along an axis; differences of doubles that are not equal are not 0.
        let mut gap = [f64::NEG_INFINITY; LEAF];
        for axis in 0..3 {
            for lane in 0..LEAF {
                let above = self.low[axis][lane] - other.high[axis];
                let below = other.low[axis] - self.high[axis][lane];
                let wider = if above > below { above } else { below };
                gap[lane] = if wider > gap[lane] { wider } else { gap[lane] };
            }
        }
        let mut bits = 0;
        for lane in 0..LEAF {
            bits |= u32::from(gap[lane] <= 0.0) << lane;
        }
        bits
    }
}

/// A subtree: its node, and its leaves.
#[derive(Clone, Copy)]
struct Subtree {
    node: usize,
    first_leaf: usize,
    leaves: usize,
}

impl Subtree {
    /// The two halves; a node is followed by those of its first half, then by those of the second.
    fn halves(self) -> [Self; 2] {
        let leaves = self.leaves / 2;
        let second =
            Self { node: self.node + 2 * leaves, first_leaf: self.first_leaf + leaves, leaves: self.leaves - leaves };
        [Self { node: self.node + 1, leaves, ..self }, second]
    }
}

/// Boxes, found by overlap. Their coordinates are finite, and twice these do not overflow.
#[derive(Default)]
pub(crate) struct BoxTree {
    centres: Vec<Centre>,
    order: Vec<u32>,
    leaves: Vec<Leaf>,
    nodes: Vec<Bounds>,
}

impl BoxTree {
    /// The tree of some boxes.
    pub(crate) fn new(boxes: &[Bounds]) -> Self {
        let mut tree = Self::default();
        tree.put_in_order(boxes);
        // Leaves may take the place of the centres.
        tree.centres = Vec::new();
        tree.fill(boxes);
        tree
    }

    /// Becomes the tree of other boxes, and allocates no memory where it has had as many.
    pub(crate) fn rebuild(&mut self, boxes: &[Bounds]) {
        self.put_in_order(boxes);
        self.fill(boxes);
    }

    fn put_in_order(&mut self, boxes: &[Bounds]) {
        let Self { centres, order, .. } = self;
        centres.clear();
        centres.extend(boxes.iter().zip(0..).map(|(bounds, index)| Centre::of(bounds, index)));
        halve(centres);
        order.clear();
        order.extend(centres.iter().map(|centre| centre.index));
    }

    /// Fills the leaves in this order, and finds the bounds of all nodes.
    fn fill(&mut self, boxes: &[Bounds]) {
        let Self { order, leaves, nodes, .. } = self;
        leaves.clear();
        leaves.resize(order.len().div_ceil(LEAF), Leaf::EMPTY);
        for (slot, &index) in order.iter().enumerate() {
            leaves[slot / LEAF].set(slot % LEAF, &boxes[index as usize]);
        }
        nodes.resize((2 * leaves.len()).saturating_sub(1), Bounds::EMPTY);
        if let Some(root) = self.root() {
            self.bound(root);
        }
    }

    /// The index of the box in each slot; eight slots in turn are a leaf.
    pub(crate) fn order(&self) -> &[u32] {
        &self.order
    }

    /// Calls `visit` with a slot, the first slot of a leaf, and a bit for each slot of this leaf whose box meets that
    /// of the former: each pair of boxes once, in any order, and also slots and leaves without a pair.
    pub(crate) fn visit_pairs<B>(&self, visit: &mut impl FnMut(usize, usize, u32) -> ControlFlow<B>) -> ControlFlow<B> {
        self.root().map_or(ControlFlow::Continue(()), |root| self.visit_within(root, visit))
    }

    fn root(&self) -> Option<Subtree> {
        let leaves = self.leaves.len();
        (leaves > 0).then_some(Subtree { node: 0, first_leaf: 0, leaves })
    }

    /// Finds the bounds of a subtree and of all below.
    fn bound(&mut self, tree: Subtree) -> Bounds {
        let bounds = if tree.leaves == 1 {
            (0..LEAF).fold(Bounds::EMPTY, |bounds, lane| bounds.with(&self.leaves[tree.first_leaf].get(lane)))
        } else {
            let [first, second] = tree.halves();
            let first = self.bound(first);
            first.with(&self.bound(second))
        };
        self.nodes[tree.node] = bounds;
        bounds
    }

    /// Pairs within a subtree.
    fn visit_within<B>(
        &self,
        tree: Subtree,
        visit: &mut impl FnMut(usize, usize, u32) -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        if tree.leaves == 1 {
            let (leaf, slot) = (&self.leaves[tree.first_leaf], LEAF * tree.first_leaf);
            return (0..LEAF).try_for_each(|lane| {
                let later = !1 << lane;
                visit(slot + lane, slot, leaf.meeting(&leaf.get(lane)) & later)
            });
        }
        let [first, second] = tree.halves();
        self.visit_within(first, visit)?;
        self.visit_within(second, visit)?;
        self.visit_between(first, second, visit)
    }

    /// Pairs of which each subtree has one.
    fn visit_between<B>(
        &self,
        first: Subtree,
        second: Subtree,
        visit: &mut impl FnMut(usize, usize, u32) -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        if !self.nodes[first.node].meets(&self.nodes[second.node]) {
            return ControlFlow::Continue(());
        }
        if first.leaves == 1 && second.leaves == 1 {
            let (leaf, other) = (&self.leaves[first.first_leaf], &self.leaves[second.first_leaf]);
            return (0..LEAF).try_for_each(|lane| {
                let bounds = leaf.get(lane);
                if !bounds.meets(&self.nodes[second.node]) {
                    return ControlFlow::Continue(());
                }
                visit(LEAF * first.first_leaf + lane, LEAF * second.first_leaf, other.meeting(&bounds))
            });
        }
        if first.leaves >= second.leaves {
            let [one, other] = first.halves();
            self.visit_between(one, second, visit)?;
            self.visit_between(other, second, visit)
        } else {
            let [one, other] = second.halves();
            self.visit_between(first, one, visit)?;
            self.visit_between(first, other, visit)
        }
    }
}

/// Twice the centre of a box.
struct Centre {
    twice: [f64; 3],
    index: u32,
}

impl Centre {
    fn of(bounds: &Bounds, index: u32) -> Self {
        Self { twice: std::array::from_fn(|axis| bounds.low[axis] + bounds.high[axis]), index }
    }
}

/// Orders centres such that each subtree has those of one side.
fn halve(centres: &mut [Centre]) {
    let leaves = centres.len().div_ceil(LEAF);
    if leaves < 2 {
        return;
    }
    let Bounds { low, high } = centres
        .iter()
        .fold(Bounds::EMPTY, |bounds, &Centre { twice, .. }| bounds.with(&Bounds { low: twice, high: twice }));
    let width = |axis: usize| high[axis] - low[axis];
    let axis = (1..3).fold(0, |widest, axis| if width(axis) > width(widest) { axis } else { widest });
    let middle = leaves / 2 * LEAF;
    centres.select_nth_unstable_by(middle, |a, b| a.twice[axis].total_cmp(&b.twice[axis]));
    let (first, second) = centres.split_at_mut(middle);
    halve(first);
    halve(second);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Boxes without an order.
    fn boxes(count: usize) -> Vec<Bounds> {
        let number = |k: usize, axis: usize| ((31 * k + 17 * axis + count) as f64 * 12.9898).sin();
        let point = |k: usize| [0, 1, 2].map(|axis| number(k, axis));
        (0..count).map(|k| Bounds::of(&[point(k), point(k).map(|value| value + 0.3 * number(k, 3).abs())])).collect()
    }

    #[test]
    fn a_tree_that_is_rebuilt_has_the_pairs_of_its_boxes() {
        let mut tree = BoxTree::default();
        for count in [100, 37, 0, 1, 150, 8] {
            let boxes = boxes(count);
            tree.rebuild(&boxes);
            let mut found = Vec::new();
            let _: ControlFlow<()> = tree.visit_pairs(&mut |slot, leaf, meeting| {
                let others = (0..LEAF).filter(|lane| meeting >> lane & 1 == 1).map(|lane| leaf + lane);
                found.extend(others.map(|other| [slot, other].map(|slot| tree.order()[slot] as usize)));
                ControlFlow::Continue(())
            });
            found.iter_mut().for_each(|pair| pair.sort_unstable());
            found.sort_unstable();
            let pairs = (0..count).flat_map(|one| (one + 1..count).map(move |other| [one, other]));
            let expected: Vec<_> = pairs.filter(|pair| boxes[pair[0]].meets(&boxes[pair[1]])).collect();
            assert!(count < 100 || expected.len() > 100);
            assert_eq!(found, expected, "{count}");
        }
    }
}
