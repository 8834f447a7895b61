//! What lasts of signing, as bytes for a memory that survives power loss.
//!
//! Two places take turns, so that a record that was being written when the power went leaves the one before.
//! Layout, little-endian: magic "QSIG", serial (4), ceiling (8), key (32, zeros for none), CRC-32 over all before.

use super::Key;
use crate::params::crc32;

/// Length of a record, bytes.
pub const SIGNING_RECORD_LEN: usize = 4 + 4 + 8 + 32 + 4;

const MAGIC: [u8; 4] = *b"QSIG";
const CHECKED: usize = SIGNING_RECORD_LEN - 4;

/// What lasts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SigningRecord {
    /// Grows by one with each that is written; its lowest bit says in which of the two places it lies.
    pub serial: u32,
    /// The key in force.
    pub key: Option<Key>,
    /// No timestamp above this one has had an effect.
    pub ceiling: u64,
}

impl SigningRecord {
    /// As bytes.
    #[inline(never)] // in each of the places that store it, it costs flash
    pub fn encode(&self) -> [u8; SIGNING_RECORD_LEN] {
        let key = self.key.map_or([0; 32], |key| *key.bytes());
        let mut record = [0; SIGNING_RECORD_LEN];
        let all = MAGIC.into_iter().chain(self.serial.to_le_bytes()).chain(self.ceiling.to_le_bytes()).chain(key);
        record.iter_mut().zip(all).for_each(|(place, byte)| *place = byte);
        let crc = crc32(record.get(..CHECKED).unwrap_or_default());
        record.iter_mut().skip(CHECKED).zip(crc.to_le_bytes()).for_each(|(place, byte)| *place = byte);
        record
    }

    /// Of bytes; `None` where they are no whole record.
    pub fn decode(record: &[u8; SIGNING_RECORD_LEN]) -> Option<Self> {
        let (checked, crc) = record.split_last_chunk::<4>()?;
        let (magic, rest) = checked.split_first_chunk::<4>()?;
        let (serial, rest) = rest.split_first_chunk::<4>()?;
        let (ceiling, rest) = rest.split_first_chunk::<8>()?;
        let key = Key::new(*rest.first_chunk::<32>()?);
        let whole = *magic == MAGIC && crc32(checked) == u32::from_le_bytes(*crc);
        whole.then_some(Self { serial: u32::from_le_bytes(*serial), key, ceiling: u64::from_le_bytes(*ceiling) })
    }

    /// The later of two places; one without a key where neither holds a record.
    pub fn latest(places: [Option<Self>; 2]) -> Self {
        let [first, second] = places;
        let is_later = |one: &Self, other: &Self| one.serial.wrapping_sub(other.serial) < 1 << 31;
        match (first, second) {
            (Some(first), Some(second)) if is_later(&first, &second) => first,
            (_, Some(second)) => second,
            (first, None) => first.unwrap_or_default(),
        }
    }
}
