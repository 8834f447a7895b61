//! The C interface of FMI 3.0: pointers in, pointers out, and nothing else. What a call means is the instance's.
//!
//! Every function answers with a status. A refusal goes to the tool's log with its reason; a panic, which would be a
//! mistake of this library, is caught here, logged, and ends the instance (fmi3Fatal), not the tool.
//!
//! Signatures: `fmi3FunctionTypes.h` of the FMI 3.0 standard. Booleans from outside are read as bytes, as another value
//! than 0 and 1 would be no `bool`.
#![allow(unsafe_code)] // names without mangling, and pointers of the importing tool
#![allow(non_snake_case)] // the standard's names

mod absent;
mod co_simulation;
mod life_cycle;
mod model_exchange;
mod saved_state;
mod values;

use std::any::Any;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::behaviour::Refusal;
use crate::instance::Instance;

const OK: c_int = 0;
const ERROR: c_int = 3;
const FATAL: c_int = 4;

/// fmi3LogMessageCallback.
type LogMessage = unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char);

/// Categories, as the description has them.
const ERROR_CATEGORY: &CStr = c"logStatusError";
const FATAL_CATEGORY: &CStr = c"logStatusFatal";

/// The importing tool's log. Errors go there whether debug logging is on or not: they are no debugging.
#[derive(Clone, Copy)]
struct Log {
    environment: *mut c_void,
    message: Option<LogMessage>,
}

impl Log {
    fn write(&self, status: c_int, text: &str) {
        let Some(message) = self.message else { return };
        let category = if status == FATAL { FATAL_CATEGORY } else { ERROR_CATEGORY };
        let text = c_text(text);
        // SAFETY: the tool gave function and environment for this; both texts live until it returns
        unsafe { message(self.environment, status, category.as_ptr(), text.as_ptr()) }
    }
}

/// What an fmi3Instance points to.
struct Handle {
    instance: Instance,
    log: Log,
    /// Texts that the tool reads until its next call.
    texts: Vec<CString>,
    is_broken: bool,
}

impl Handle {
    fn run(&mut self, work: impl FnOnce(&mut Handle) -> Result<(), Refusal>) -> c_int {
        if self.is_broken {
            return FATAL;
        }
        match catch_unwind(AssertUnwindSafe(|| work(self))) {
            Ok(Ok(())) => OK,
            Ok(Err(refusal)) => {
                self.log.write(ERROR, &refusal);
                ERROR
            }
            Err(panic) => {
                self.is_broken = true;
                self.log.write(FATAL, &format!("a mistake in this FMU: {}", panic_text(panic.as_ref())));
                FATAL
            }
        }
    }
}

fn panic_text(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("a panic without words")
}

/// Does some work on an instance.
///
/// # Safety
/// The pointer is null, or comes from an instantiation here and has not been freed.
unsafe fn call(instance: *mut c_void, work: impl FnOnce(&mut Handle) -> Result<(), Refusal>) -> c_int {
    // SAFETY: as the caller promises
    match unsafe { instance.cast::<Handle>().as_mut() } {
        Some(handle) => handle.run(work),
        None => ERROR,
    }
}

/// So many values from the tool; none where there is no pointer.
///
/// # Safety
/// A pointer that is not null leads to so many values, which stay as they are while they are read.
unsafe fn slice<'a, T>(values: *const T, count: usize) -> &'a [T] {
    // SAFETY: as the caller promises
    if values.is_null() { &[] } else { unsafe { std::slice::from_raw_parts(values, count) } }
}

/// Room for so many values of the tool's; none where there is no pointer.
///
/// # Safety
/// A pointer that is not null leads to so many values, which nobody else touches meanwhile.
unsafe fn slice_mut<'a, T>(values: *mut T, count: usize) -> &'a mut [T] {
    // SAFETY: as the caller promises
    if values.is_null() { &mut [] } else { unsafe { std::slice::from_raw_parts_mut(values, count) } }
}

/// Puts a value where the tool wants it, if it does.
///
/// # Safety
/// A pointer that is not null leads to room for the value.
unsafe fn put<T>(place: *mut T, value: T) {
    if !place.is_null() {
        // SAFETY: as the caller promises
        unsafe { place.write(value) }
    }
}

/// A text of the tool's.
///
/// # Safety
/// A pointer that is not null leads to a text that ends with a zero.
unsafe fn text(pointer: *const c_char, what: &str) -> Result<String, Refusal> {
    if pointer.is_null() {
        return Err(format!("{what}: no text"));
    }
    // SAFETY: as the caller promises
    let text = unsafe { CStr::from_ptr(pointer) };
    text.to_str().map(str::to_owned).map_err(|_| format!("{what}: not UTF-8"))
}

/// A text for the tool, up to the first zero in it.
fn c_text(text: &str) -> CString {
    let text = text.split('\0').next().unwrap_or_default();
    CString::new(text).unwrap_or_default()
}
