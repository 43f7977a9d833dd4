//! The system's allocator, with long arrays aligned to cache lines.
//!
//! A register of AVX-512 is as wide as a cache line. In a column that begins in the middle of a line every access
//! touches two lines. The system's allocator does not align arrays to lines; this one does. Its use in a program:
//!
//!     #[global_allocator]
//!     static ALLOCATOR: membrane_core::simd::aligned::Aligned = membrane_core::simd::aligned::Aligned;
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};

/// Size of a cache line, and size from which arrays are aligned to one \[bytes\].
const LINE: usize = 64;
const LONG: usize = 1024;

/// The allocator.
#[derive(Debug, Clone, Copy, Default)]
pub struct Aligned;

/// The layout requested from the system: a function of `layout` alone, hence the same for release.
fn requested(layout: Layout) -> Layout {
    if layout.size() < LONG { layout } else { layout.align_to(LINE).unwrap_or(layout) }
}

// SAFETY: blocks are the system's, of the caller's size and at least the caller's alignment. `requested` gives equal
// layouts for equal arguments, so that `dealloc` uses the layout of `alloc`. `realloc` is composed of these two.
unsafe impl GlobalAlloc for Aligned {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's contract; the size is unchanged, therefore not zero.
        unsafe { System.alloc(requested(layout)) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as in `alloc`.
        unsafe { System.alloc_zeroed(requested(layout)) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        // SAFETY: `place` came from `alloc` with this layout, that is from the system with `requested(layout)`.
        unsafe { System.dealloc(place, requested(layout)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_from_a_kilobyte_on_are_aligned_to_cache_lines_and_keep_their_size() {
        for (size, alignment, expected) in [(LONG - 8, 8, 8), (LONG, 8, LINE), (10 * LONG, 8, LINE), (LONG, 256, 256)] {
            let layout = Layout::from_size_align(size, alignment).unwrap();
            assert_eq!((requested(layout).size(), requested(layout).align()), (size, expected));
        }
    }
}
