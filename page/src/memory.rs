//! Memory in a browser: the standard library's allocator, but where a page's memory is used up the page is given the
//! reason before the computation ends. The standard library would end it without a word.
#![allow(unsafe_code)] // an allocator

use std::alloc::{GlobalAlloc, Layout, System};

use crate::boundary;

/// What the page is given; it needs no memory.
const RAN_OUT: &str = r#"{"failure":"out of memory"}"#;

/// The standard library's allocator, its refusals said.
struct Speaking;

#[global_allocator]
static ALLOCATOR: Speaking = Speaking;

/// What an allocation gave, and a word where it gave nothing.
fn said(place: *mut u8) -> *mut u8 {
    if place.is_null() {
        boundary::say(RAN_OUT);
    }
    place
}

// SAFETY: each call goes on to the standard library's allocator as it came.
unsafe impl GlobalAlloc for Speaking {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's.
        said(unsafe { System.alloc(layout) })
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's.
        said(unsafe { System.alloc_zeroed(layout) })
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, bytes: usize) -> *mut u8 {
        // SAFETY: the caller's.
        said(unsafe { System.realloc(place, layout, bytes) })
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        // SAFETY: the caller's.
        unsafe { System.dealloc(place, layout) }
    }
}
