//! The system's allocator, with long arrays on the bounds of cache lines.
//!
//! A register of AVX-512 is as wide as a cache line. Where a column begins in the middle of one, every access takes two;
//! the system gives arrays of numbers that begin anywhere. Programs that want this say so:
//!
//!     #[global_allocator]
//!     static ALLOCATOR: membrane_core::simd::aligned::Aligned = membrane_core::simd::aligned::Aligned;
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};

/// Bytes in a cache line, and bytes from which an array is long.
const LINE: usize = 64;
const LONG: usize = 1024;

/// The allocator.
#[derive(Debug, Clone, Copy, Default)]
pub struct Aligned;

/// What is asked of the system. It depends on nothing but `layout`, so that memory goes back as it came.
fn asked(layout: Layout) -> Layout {
    if layout.size() < LONG { layout } else { layout.align_to(LINE).unwrap_or(layout) }
}

// SAFETY: blocks are the system's, of the same size and of at least the alignment that was asked for; `asked` gives the same
// for the same layout, so that `dealloc` names the layout that `alloc` did. `realloc` is the trait's own, by these two.
unsafe impl GlobalAlloc for Aligned {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promise; the size is unchanged, and so not zero.
        unsafe { System.alloc(asked(layout)) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as in `alloc`.
        unsafe { System.alloc_zeroed(asked(layout)) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        // SAFETY: `place` came from `alloc` with this layout, and so from the system with `asked(layout)`.
        unsafe { System.dealloc(place, asked(layout)) }
    }
}
