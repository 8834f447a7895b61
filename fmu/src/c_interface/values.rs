//! Reading and writing variables. None is an array: one value a reference.

use std::ffi::{c_char, c_int, c_void};

use super::{Handle, c_text, call, slice, slice_mut, text};
use crate::behaviour::Refusal;
use crate::variable::Value;

/// Hands each referenced value to `take`, with its place among the references.
fn read(
    handle: &mut Handle,
    references: &[u32],
    count: usize,
    mut take: impl FnMut(&mut Handle, usize, Value) -> Option<()>,
) -> Result<(), Refusal> {
    check_count(references, count)?;
    for (place, reference) in references.iter().enumerate() {
        let value = handle.instance.get(*reference)?;
        let found = value.type_name();
        take(handle, place, value).ok_or_else(|| format!("value reference {reference} is a {found}"))?;
    }
    Ok(())
}

fn write(
    handle: &mut Handle,
    references: &[u32],
    values: impl ExactSizeIterator<Item = Result<Value, Refusal>>,
) -> Result<(), Refusal> {
    check_count(references, values.len())?;
    for (reference, value) in references.iter().zip(values) {
        handle.instance.set(*reference, value?)?;
    }
    Ok(())
}

fn check_count(references: &[u32], count: usize) -> Result<(), Refusal> {
    let expected = references.len();
    if count == expected { Ok(()) } else { Err(format!("{count} values for {expected} references to single values")) }
}

macro_rules! numbers {
    ($get:ident, $set:ident, $type:ty, $variant:ident) => {
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get(
            instance: *mut c_void,
            references: *const u32,
            reference_count: usize,
            values: *mut $type,
            count: usize,
        ) -> c_int {
            // SAFETY: as the standard obliges the tool
            let (references, values) = unsafe { (slice(references, reference_count), slice_mut(values, count)) };
            let count = values.len();
            let take = |_: &mut Handle, place: usize, value| match value {
                Value::$variant(value) => values.get_mut(place).map(|slot| *slot = value.into()),
                _ => None,
            };
            // SAFETY: as the standard obliges the tool
            unsafe { call(instance, |handle| read(handle, references, count, take)) }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set(
            instance: *mut c_void,
            references: *const u32,
            reference_count: usize,
            values: *const $type,
            count: usize,
        ) -> c_int {
            // SAFETY: as the standard obliges the tool
            let (references, values) = unsafe { (slice(references, reference_count), slice(values, count)) };
            let values = values.iter().map(|value| Ok(Value::$variant($variant(*value))));
            // SAFETY: as the standard obliges the tool
            unsafe { call(instance, |handle| write(handle, references, values)) }
        }
    };
}

fn Float(value: f64) -> f64 {
    value
}

fn Count(value: u64) -> u64 {
    value
}

fn Boolean(value: u8) -> bool {
    value != 0
}

numbers!(fmi3GetFloat64, fmi3SetFloat64, f64, Float);
numbers!(fmi3GetUInt64, fmi3SetUInt64, u64, Count);
numbers!(fmi3GetBoolean, fmi3SetBoolean, u8, Boolean);

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetString(
    instance: *mut c_void,
    references: *const u32,
    reference_count: usize,
    values: *mut *const c_char,
    count: usize,
) -> c_int {
    // SAFETY: as the standard obliges the tool
    let (references, values) = unsafe { (slice(references, reference_count), slice_mut(values, count)) };
    let count = values.len();
    let take = |handle: &mut Handle, place: usize, value| {
        let Value::Text(value) = value else { return None };
        let value = c_text(&value);
        // what it points to stays where it is when the list grows
        values.get_mut(place).map(|slot| *slot = value.as_ptr())?;
        handle.texts.push(value);
        Some(())
    };
    let work = |handle: &mut Handle| {
        handle.texts.clear();
        read(handle, references, count, take)
    };
    // SAFETY: as the standard obliges the tool
    unsafe { call(instance, work) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetString(
    instance: *mut c_void,
    references: *const u32,
    reference_count: usize,
    values: *const *const c_char,
    count: usize,
) -> c_int {
    // SAFETY: as the standard obliges the tool
    let (references, values) = unsafe { (slice(references, reference_count), slice(values, count)) };
    // SAFETY: as the standard obliges the tool
    let values = values.iter().map(|value| unsafe { text(*value, "fmi3SetString") }.map(Value::Text));
    // SAFETY: as the standard obliges the tool
    unsafe { call(instance, |handle| write(handle, references, values)) }
}
