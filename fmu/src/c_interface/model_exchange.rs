//! States, derivatives and stops for a foreign integrator.

use std::ffi::{c_int, c_void};

use super::{Handle, call, put, slice, slice_mut};
use crate::behaviour::Refusal;

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterContinuousTimeMode(instance: *mut c_void) -> c_int {
    // SAFETY: as the standard obliges the tool
    unsafe { call(instance, |handle| handle.instance.enter_continuous_time()) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetTime(instance: *mut c_void, time_s: f64) -> c_int {
    // SAFETY: as the standard obliges the tool
    unsafe { call(instance, |handle| handle.instance.set_time(time_s)) }
}

fn check_count(states: usize, given: usize) -> Result<(), Refusal> {
    if states == given { Ok(()) } else { Err(format!("{given} values for {states} continuous states")) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetContinuousStates(instance: *mut c_void, states: *const f64, count: usize) -> c_int {
    // SAFETY: as the standard obliges the tool
    let states = unsafe { slice(states, count) };
    let work = |handle: &mut Handle| {
        check_count(handle.instance.continuous("fmi3SetContinuousStates")?.state_count(), states.len())?;
        handle.instance.set_states(states)
    };
    // SAFETY: as the standard obliges the tool
    unsafe { call(instance, work) }
}

/// Gives the tool what `of` finds.
unsafe fn give(
    instance: *mut c_void,
    room: *mut f64,
    count: usize,
    of: impl FnOnce(&mut Handle) -> Result<Vec<f64>, Refusal>,
) -> c_int {
    // SAFETY: as the standard obliges the tool
    let room = unsafe { slice_mut(room, count) };
    let work = |handle: &mut Handle| {
        let found = of(handle)?;
        check_count(found.len(), room.len())?;
        room.copy_from_slice(&found);
        Ok(())
    };
    // SAFETY: as the standard obliges the tool
    unsafe { call(instance, work) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetContinuousStates(instance: *mut c_void, states: *mut f64, count: usize) -> c_int {
    // SAFETY: as the standard obliges the tool
    unsafe { give(instance, states, count, |handle| handle.instance.continuous("fmi3GetContinuousStates")?.states()) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetContinuousStateDerivatives(
    instance: *mut c_void,
    derivatives: *mut f64,
    count: usize,
) -> c_int {
    let of = |handle: &mut Handle| handle.instance.continuous("fmi3GetContinuousStateDerivatives")?.derivatives();
    // SAFETY: as the standard obliges the tool
    unsafe { give(instance, derivatives, count, of) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNominalsOfContinuousStates(
    instance: *mut c_void,
    nominals: *mut f64,
    count: usize,
) -> c_int {
    let of = |handle: &mut Handle| Ok(handle.instance.continuous("fmi3GetNominalsOfContinuousStates")?.nominals());
    // SAFETY: as the standard obliges the tool
    unsafe { give(instance, nominals, count, of) }
}

/// What has to be put right waits for a stop, so there are no indicators.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetEventIndicators(instance: *mut c_void, indicators: *mut f64, count: usize) -> c_int {
    // SAFETY: as the standard obliges the tool
    unsafe { give(instance, indicators, count, |_| Ok(Vec::new())) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNumberOfEventIndicators(instance: *mut c_void, count: *mut usize) -> c_int {
    let work = |_: &mut Handle| {
        // SAFETY: as the standard obliges the tool
        unsafe { put(count, 0) };
        Ok(())
    };
    // SAFETY: as the standard obliges the tool
    unsafe { call(instance, work) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNumberOfContinuousStates(instance: *mut c_void, count: *mut usize) -> c_int {
    let work = |handle: &mut Handle| {
        let states = handle.instance.continuous("fmi3GetNumberOfContinuousStates")?.state_count();
        // SAFETY: as the standard obliges the tool
        unsafe { put(count, states) };
        Ok(())
    };
    // SAFETY: as the standard obliges the tool
    unsafe { call(instance, work) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3CompletedIntegratorStep(
    instance: *mut c_void,
    _no_state_set_before: u8,
    enter_event_mode: *mut u8,
    terminate: *mut u8,
) -> c_int {
    let work = |handle: &mut Handle| {
        let wants_a_stop = handle.instance.continuous("fmi3CompletedIntegratorStep")?.wants_a_stop()?;
        // SAFETY: as the standard obliges the tool
        unsafe {
            put(enter_event_mode, u8::from(wants_a_stop));
            put(terminate, 0);
        }
        Ok(())
    };
    // SAFETY: as the standard obliges the tool
    unsafe { call(instance, work) }
}

/// All discrete states follow in fmi3UpdateDiscreteStates.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EvaluateDiscreteStates(instance: *mut c_void) -> c_int {
    // SAFETY: as the standard obliges the tool
    unsafe { call(instance, |_| Ok(())) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3UpdateDiscreteStates(
    instance: *mut c_void,
    need_another_update: *mut u8,
    terminate: *mut u8,
    nominals_changed: *mut u8,
    states_changed: *mut u8,
    next_time_defined: *mut u8,
    next_s: *mut f64,
) -> c_int {
    let work = |handle: &mut Handle| {
        let stop = handle.instance.stop()?;
        // SAFETY: as the standard obliges the tool
        unsafe {
            put(need_another_update, 0);
            put(terminate, 0);
            put(nominals_changed, 0);
            put(states_changed, u8::from(stop.states_changed));
            put(next_time_defined, u8::from(stop.next_s.is_some()));
            put(next_s, stop.next_s.unwrap_or(0.0));
        }
        Ok(())
    };
    // SAFETY: as the standard obliges the tool
    unsafe { call(instance, work) }
}
