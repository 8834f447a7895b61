//! From instantiation to the end of an instance.

use std::ffi::{c_char, c_int, c_void};
use std::panic::catch_unwind;
use std::path::Path;
use std::ptr::null_mut;

use super::{ERROR, FATAL, Handle, Log, LogMessage, OK, call, panic_text, text};
use crate::behaviour::Refusal;
use crate::component::Component;
use crate::instance::{Instance, Interface};

#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// There is nothing to debug by: errors are logged whatever is chosen here.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetDebugLogging(
    instance: *mut c_void,
    _logging_on: u8,
    _category_count: usize,
    _categories: *const *const c_char,
) -> c_int {
    // SAFETY: as the standard obliges the tool
    unsafe { call(instance, |_| Ok(())) }
}

/// What every instantiation gets.
struct Given {
    token: *const c_char,
    resources: *const c_char,
    log: Log,
}

/// A new instance, or null with the reason in the log.
unsafe fn instantiate(given: Given, interface: Interface) -> *mut c_void {
    let Given { token, resources, log } = given;
    // SAFETY: as the standard obliges the tool
    let texts = unsafe { (text(token, "instantiationToken"), text(resources, "resourcePath")) };
    let made = catch_unwind(|| -> Result<Instance, Refusal> {
        let (component, content) = Component::load(Path::new(&texts.1?), &texts.0?)?;
        Instance::new(component, content, interface)
    });
    match made {
        Ok(Ok(instance)) => {
            Box::into_raw(Box::new(Handle { instance, log, texts: Vec::new(), is_broken: false })).cast()
        }
        Ok(Err(refusal)) => {
            log.write(ERROR, &refusal);
            null_mut()
        }
        Err(panic) => {
            log.write(FATAL, &format!("a mistake in this FMU: {}", panic_text(panic.as_ref())));
            null_mut()
        }
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    _instance_name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    _visible: u8,
    _logging_on: u8,
    environment: *mut c_void,
    message: Option<LogMessage>,
) -> *mut c_void {
    let given = Given { token, resources, log: Log { environment, message } };
    // SAFETY: as the standard obliges the tool
    unsafe { instantiate(given, Interface::ModelExchange) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _instance_name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    _visible: u8,
    _logging_on: u8,
    event_mode_used: u8,
    _early_return_allowed: u8,
    _intermediate_variables: *const u32,
    intermediate_variable_count: usize,
    environment: *mut c_void,
    message: Option<LogMessage>,
    _intermediate_update: *const c_void,
) -> *mut c_void {
    let log = Log { environment, message };
    if event_mode_used != 0 || intermediate_variable_count > 0 {
        log.write(ERROR, "co-simulation here has neither an event mode nor intermediate variables");
        return null_mut();
    }
    // SAFETY: as the standard obliges the tool
    unsafe { instantiate(Given { token, resources, log }, Interface::CoSimulation) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    _instance_name: *const c_char,
    _token: *const c_char,
    _resources: *const c_char,
    _visible: u8,
    _logging_on: u8,
    environment: *mut c_void,
    message: Option<LogMessage>,
    _clock_update: *const c_void,
    _lock: *const c_void,
    _unlock: *const c_void,
) -> *mut c_void {
    Log { environment, message }.write(ERROR, "this FMU has no scheduled execution");
    null_mut()
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(instance: *mut c_void) {
    if !instance.is_null() {
        // SAFETY: the tool frees what it got from an instantiation here, once
        drop(unsafe { Box::from_raw(instance.cast::<Handle>()) });
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    instance: *mut c_void,
    _tolerance_defined: u8,
    _tolerance: f64,
    start_s: f64,
    _stop_defined: u8,
    _stop_s: f64,
) -> c_int {
    // SAFETY: as the standard obliges the tool
    unsafe { call(instance, |handle| handle.instance.enter_initialisation(start_s)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ExitInitializationMode(instance: *mut c_void) -> c_int {
    // SAFETY: as the standard obliges the tool
    unsafe { call(instance, |handle| handle.instance.exit_initialisation()) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterEventMode(instance: *mut c_void) -> c_int {
    // SAFETY: as the standard obliges the tool
    unsafe { call(instance, |handle| handle.instance.enter_event_mode()) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Terminate(instance: *mut c_void) -> c_int {
    // SAFETY: as the standard obliges the tool
    unsafe { call(instance, |handle| handle.instance.terminate()) }
}

/// Also of an instance that a mistake has ended: what it computes with is made anew.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Reset(instance: *mut c_void) -> c_int {
    // SAFETY: as the standard obliges the tool
    let Some(handle) = (unsafe { instance.cast::<Handle>().as_mut() }) else { return ERROR };
    handle.is_broken = false;
    handle.instance.reset();
    OK
}
