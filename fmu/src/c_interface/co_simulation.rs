//! The one call that lets time pass in co-simulation.

use std::ffi::{c_int, c_void};

use super::{Handle, call, put};

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    instance: *mut c_void,
    from_s: f64,
    duration_s: f64,
    _no_state_set_before: u8,
    event_handling_needed: *mut u8,
    terminate: *mut u8,
    early_return: *mut u8,
    reached_s: *mut f64,
) -> c_int {
    let work = |handle: &mut Handle| {
        let reached = handle.instance.step(from_s, duration_s)?;
        // SAFETY: as the standard obliges the tool
        unsafe {
            put(event_handling_needed, 0);
            put(terminate, 0);
            put(early_return, 0);
            put(reached_s, reached);
        }
        Ok(())
    };
    // SAFETY: as the standard obliges the tool
    unsafe { call(instance, work) }
}
