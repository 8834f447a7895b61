//! A bounded queue of bytes that takes a record whole or not at all.

/// At most `N` bytes, first in, first out.
#[derive(Clone, Debug)]
pub(super) struct Ring<const N: usize> {
    bytes: [u8; N],
    /// Where the oldest lies.
    start: usize,
    length: usize,
}

impl<const N: usize> Ring<N> {
    pub(super) const fn new() -> Self {
        Self { bytes: [0; N], start: 0, length: 0 }
    }

    pub(super) fn len(&self) -> usize {
        self.length
    }

    pub(super) fn clear(&mut self) {
        self.length = 0;
    }

    /// Takes a record; false, and nothing taken, where there is no room for it.
    pub(super) fn push(&mut self, record: &[u8]) -> bool {
        if record.len() > N - self.length {
            return false;
        }
        let at = Self::wrapped(self.start + self.length);
        let (before, after) = self.bytes.split_at_mut_checked(at).unwrap_or_default();
        let (fits, wraps) = record.split_at_checked(after.len()).unwrap_or((record, &[]));
        copy(fits, after);
        copy(wraps, before);
        self.length += record.len();
        true
    }

    /// Gives the oldest bytes, as many as there are and as `block` has room for.
    pub(super) fn take(&mut self, block: &mut [u8]) -> usize {
        let count = block.len().min(self.length);
        let (before, after) = self.bytes.split_at_checked(self.start).unwrap_or_default();
        let wanted = block.get_mut(..count).unwrap_or_default();
        let (first, rest) = wanted.split_at_mut_checked(after.len().min(count)).unwrap_or_default();
        copy(after, first);
        copy(before, rest);
        self.start = Self::wrapped(self.start + count);
        self.length -= count;
        count
    }

    /// Places up to twice the ring's length.
    const fn wrapped(at: usize) -> usize {
        if at < N { at } else { at - N }
    }
}

/// As many as there are and as there is room for.
fn copy(bytes: &[u8], places: &mut [u8]) {
    for (place, byte) in places.iter_mut().zip(bytes) {
        *place = *byte;
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Whatever is put in and taken out in whatever order: what was taken is what comes out, whole, in order.
        #[test]
        fn records_come_out_whole_and_in_order(
            turns in proptest::collection::vec((any::<bool>(), 0..9_usize), 1..200),
        ) {
            let mut ring = Ring::<16>::new();
            let (mut next, mut inside) = (0_u8, std::collections::VecDeque::new());
            for (puts, length) in turns {
                if puts {
                    let record: std::vec::Vec<u8> = (0..length).map(|at| next.wrapping_add(at as u8)).collect();
                    let fits = inside.len() + length <= 16;
                    prop_assert_eq!(ring.push(&record), fits);
                    if fits {
                        inside.extend(record);
                        next = next.wrapping_add(length as u8);
                    }
                } else {
                    let mut block = [0; 8];
                    let block = &mut block[..length.min(8)];
                    let count = ring.take(block);
                    prop_assert_eq!(count, block.len().min(inside.len()));
                    for byte in &block[..count] {
                        prop_assert_eq!(Some(*byte), inside.pop_front());
                    }
                }
                prop_assert_eq!(ring.len(), inside.len());
            }
        }
    }
}
