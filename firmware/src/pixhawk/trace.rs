//! The last step, where a debugger or the emulated board finds it: symbol `FLIGHT_TRACE`.
#![allow(unsafe_code)] // a static that only its one owner writes and only the outside reads

use core::cell::UnsafeCell;
use core::ptr;
use core::sync::atomic::{Ordering, fence};

use shared_control::flight_core::{State, StepOutput};
use shared_control::record::trace::StepTrace;
use shared_control::signals::StepInput;

/// Memory that is read from outside the program.
#[repr(transparent)]
pub struct Published(UnsafeCell<StepTrace>);

// SAFETY: written through the one `Trace` alone, never read by the program
unsafe impl Sync for Published {}

#[unsafe(no_mangle)]
static FLIGHT_TRACE: Published = Published(UnsafeCell::new(StepTrace::EMPTY));

/// The one writer.
pub struct Trace {
    next: StepTrace,
}

impl Trace {
    /// To be made once.
    pub const fn new() -> Self {
        Self { next: StepTrace::EMPTY }
    }

    /// Publishes a step; its number last, so that a reader who sees it sees the rest.
    pub fn publish(&mut self, input: &StepInput, output: &StepOutput, state: &State) {
        self.next.record(input, output, state);
        let step = self.next.step;
        self.next.step = 0;
        let published = FLIGHT_TRACE.0.get();
        // SAFETY: the one writer; volatile, since nobody in the program reads it
        unsafe {
            published.write_volatile(self.next);
            fence(Ordering::Release);
            ptr::addr_of_mut!((*published).step).write_volatile(step);
        }
    }
}
