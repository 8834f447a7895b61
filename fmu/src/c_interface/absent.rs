//! What these FMUs have not, by name: the standard wants every function exported. Each says so and does nothing.

use std::ffi::{c_int, c_void};

use super::call;

macro_rules! absent {
    ($what:literal: $($name:ident($($type:ty),*);)+) => {$(
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(instance: *mut c_void, $(_: $type),*) -> c_int {
            // SAFETY: as the standard obliges the tool
            unsafe { call(instance, |_| Err(format!(concat!(stringify!($name), ": this FMU has no ", $what)))) }
        }
    )+};
}

/// Of types that no variable has; asking for nothing of it is no mistake.
macro_rules! other_types {
    ($($get:ident, $set:ident, $type:ty;)+) => {$(
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get(
            instance: *mut c_void, _: *const u32, references: usize, _: *mut $type, _: usize,
        ) -> c_int {
            // SAFETY: as the standard obliges the tool
            unsafe { call(instance, |_| no_such_variables(stringify!($get), references)) }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set(
            instance: *mut c_void, _: *const u32, references: usize, _: *const $type, _: usize,
        ) -> c_int {
            // SAFETY: as the standard obliges the tool
            unsafe { call(instance, |_| no_such_variables(stringify!($set), references)) }
        }
    )+};
}

fn no_such_variables(function: &str, references: usize) -> Result<(), String> {
    if references == 0 { Ok(()) } else { Err(format!("{function}: no variable has this type")) }
}

other_types! {
    fmi3GetFloat32, fmi3SetFloat32, f32;
    fmi3GetInt8, fmi3SetInt8, i8;
    fmi3GetUInt8, fmi3SetUInt8, u8;
    fmi3GetInt16, fmi3SetInt16, i16;
    fmi3GetUInt16, fmi3SetUInt16, u16;
    fmi3GetInt32, fmi3SetInt32, i32;
    fmi3GetUInt32, fmi3SetUInt32, u32;
    fmi3GetInt64, fmi3SetInt64, i64;
}

absent! { "binary variables":
    fmi3GetBinary(*const u32, usize, *mut usize, *mut *const u8, usize);
    fmi3SetBinary(*const u32, usize, *const usize, *const *const u8, usize);
}

absent! { "clocks":
    fmi3GetClock(*const u32, usize, *mut u8);
    fmi3SetClock(*const u32, usize, *const u8);
    fmi3GetIntervalDecimal(*const u32, usize, *mut f64, *mut c_int);
    fmi3GetIntervalFraction(*const u32, usize, *mut u64, *mut u64, *mut c_int);
    fmi3GetShiftDecimal(*const u32, usize, *mut f64);
    fmi3GetShiftFraction(*const u32, usize, *mut u64, *mut u64);
    fmi3SetIntervalDecimal(*const u32, usize, *const f64);
    fmi3SetIntervalFraction(*const u32, usize, *const u64, *const u64);
    fmi3SetShiftDecimal(*const u32, usize, *const f64);
    fmi3SetShiftFraction(*const u32, usize, *const u64, *const u64);
    fmi3ActivateModelPartition(u32, f64);
}

absent! { "event mode in co-simulation":
    fmi3EnterStepMode();
}

absent! { "structural parameters":
    fmi3EnterConfigurationMode();
    fmi3ExitConfigurationMode();
}

absent! { "dependencies of single elements":
    fmi3GetNumberOfVariableDependencies(u32, *mut usize);
    fmi3GetVariableDependencies(u32, *mut usize, *mut u32, *mut usize, *mut c_int, usize);
}

absent! { "partial derivatives":
    fmi3GetDirectionalDerivative(*const u32, usize, *const u32, usize, *const f64, usize, *mut f64, usize);
    fmi3GetAdjointDerivative(*const u32, usize, *const u32, usize, *const f64, usize, *mut f64, usize);
}

absent! { "derivatives of its outputs":
    fmi3GetOutputDerivatives(*const u32, usize, *const i32, *mut f64, usize);
}

absent! { "saved states as bytes":
    fmi3SerializedFMUStateSize(*mut c_void, *mut usize);
    fmi3SerializeFMUState(*mut c_void, *mut u8, usize);
    fmi3DeserializeFMUState(*const u8, usize, *mut *mut c_void);
}
