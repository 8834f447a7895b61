//! An instance's state kept and taken again. It is kept in memory: no bytes are made of it.

use std::ffi::{c_int, c_void};

use super::{call, put};
use crate::instance::Saved;

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFMUState(instance: *mut c_void, state: *mut *mut c_void) -> c_int {
    let work = |handle: &mut super::Handle| {
        // SAFETY: as the standard obliges the tool
        let room = unsafe { state.as_mut() }.ok_or("fmi3GetFMUState: no room for it")?;
        let saved = handle.instance.save();
        // SAFETY: a state that is not null came from here and has not been freed
        match unsafe { room.cast::<Saved>().as_mut() } {
            Some(earlier) => *earlier = saved,
            None => *room = Box::into_raw(Box::new(saved)).cast(),
        }
        Ok(())
    };
    // SAFETY: as the standard obliges the tool
    unsafe { call(instance, work) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFMUState(instance: *mut c_void, state: *mut c_void) -> c_int {
    let work = |handle: &mut super::Handle| {
        // SAFETY: a state that is not null came from here and has not been freed
        let saved = unsafe { state.cast::<Saved>().as_ref() }.ok_or("fmi3SetFMUState: no state")?;
        handle.instance.restore(saved);
        Ok(())
    };
    // SAFETY: as the standard obliges the tool
    unsafe { call(instance, work) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeFMUState(instance: *mut c_void, state: *mut *mut c_void) -> c_int {
    let work = |_: &mut super::Handle| {
        // SAFETY: as the standard obliges the tool
        let Some(room) = (unsafe { state.as_ref() }) else { return Ok(()) };
        if !room.is_null() {
            // SAFETY: a state that is not null came from here and is freed once
            drop(unsafe { Box::from_raw(room.cast::<Saved>()) });
            // SAFETY: as the standard obliges the tool
            unsafe { put(state, std::ptr::null_mut()) };
        }
        Ok(())
    };
    // SAFETY: as the standard obliges the tool
    unsafe { call(instance, work) }
}
