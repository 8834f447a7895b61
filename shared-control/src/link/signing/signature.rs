//! A frame's signature: the first six bytes of SHA-256 over key, frame, link and timestamp.

use sha2::block_api::compress256;

/// Bytes of a signature on the line: link, timestamp (6 bytes), signature (6 bytes).
pub const SIGNATURE_LEN: usize = 13;
/// Bytes of a block of SHA-256.
const BLOCK_LEN: usize = 64;
/// Where the length lies in the last block: big-endian, bits.
const LENGTH_AT: usize = BLOCK_LEN - 8;
/// How SHA-256 begins (FIPS 180-4, section 5.3.3).
const BEGIN: [u32; 8] =
    [0x6a09_e667, 0xbb67_ae85, 0x3c6e_f372, 0xa54f_f53a, 0x510e_527f, 0x9b05_688c, 0x1f83_d9ab, 0x5be0_cd19];

/// What both ends share. It is not printed.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Key([u8; 32]);

impl Key {
    /// The key of these bytes; none of zeros, which mean on the link that nothing is signed.
    pub fn new(bytes: [u8; 32]) -> Option<Self> {
        (bytes != [0; 32]).then_some(Self(bytes))
    }

    /// Its bytes.
    pub fn bytes(&self) -> &[u8; 32] {
        &self.0
    }
}

impl core::fmt::Debug for Key {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("Key")
    }
}

/// The 13 bytes that follow a frame's CRC. `frame` is the frame from its first byte to its CRC, in parts.
#[inline(never)] // once in the flash, not wherever a frame is written
pub fn signature(key: &Key, frame: &[&[u8]], link_id: u8, timestamp: u64) -> [u8; SIGNATURE_LEN] {
    let [t0, t1, t2, t3, t4, t5, ..] = timestamp.to_le_bytes();
    let stamp = [link_id, t0, t1, t2, t3, t4, t5];
    let mut hash = Sha256::new();
    hash.add(&key.0);
    for part in frame {
        hash.add(part);
    }
    hash.add(&stamp);
    let [s0, s1, s2, s3, s4, s5] = hash.first_bytes();
    [link_id, t0, t1, t2, t3, t4, t5, s0, s1, s2, s3, s4, s5]
}

/// Link and timestamp of the bytes behind a frame's CRC.
pub fn stamp_of(signature: &[u8; SIGNATURE_LEN]) -> (u8, u64) {
    let [link_id, t0, t1, t2, t3, t4, t5, ..] = *signature;
    (link_id, u64::from_le_bytes([t0, t1, t2, t3, t4, t5, 0, 0]))
}

/// Signs what one sender writes.
#[derive(Clone, Copy, Debug)]
pub struct Signer {
    key: Key,
    link_id: u8,
    next: u64,
}

impl Signer {
    /// A signer of one link.
    pub fn new(key: Key, link_id: u8) -> Self {
        Self { key, link_id, next: 0 }
    }

    /// The key that it signs with.
    pub fn key(&self) -> Key {
        self.key
    }

    /// The clock says this: no timestamp from now on is earlier.
    pub fn set_clock(&mut self, now: u64) {
        self.next = self.next.max(now);
    }

    /// Signs a frame; no two have the same timestamp.
    #[inline(never)] // as above
    pub fn sign(&mut self, frame: &[u8]) -> [u8; SIGNATURE_LEN] {
        let signature = signature(&self.key, &[frame], self.link_id, self.next);
        self.next = self.next.saturating_add(1);
        signature
    }
}

/// SHA-256 of bytes that come in parts. The rounds are the crate's; its own way to split bytes into blocks can panic.
struct Sha256 {
    state: [u32; 8],
    block: heapless::Vec<u8, BLOCK_LEN>,
    length: u64,
}

impl Sha256 {
    fn new() -> Self {
        Self { state: BEGIN, block: heapless::Vec::new(), length: 0 }
    }

    fn add(&mut self, bytes: &[u8]) {
        self.length = self.length.wrapping_add(bytes.len() as u64);
        for byte in bytes {
            self.push(*byte);
        }
    }

    fn push(&mut self, byte: u8) {
        // never full: a whole block is taken at once
        let _ = self.block.push(byte);
        if let Some(block) = self.block.as_slice().first_chunk::<BLOCK_LEN>() {
            compress256(&mut self.state, core::slice::from_ref(block));
            self.block.clear();
        }
    }

    fn first_bytes(mut self) -> [u8; 6] {
        let bits = self.length.wrapping_mul(8);
        self.push(0x80);
        // at most a block
        for _ in 0..BLOCK_LEN {
            if self.block.len() == LENGTH_AT {
                break;
            }
            self.push(0);
        }
        for byte in bits.to_be_bytes() {
            self.push(byte);
        }
        let [first, second, ..] = self.state.map(u32::to_be_bytes);
        [first[0], first[1], first[2], first[3], second[0], second[1]]
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use sha2::Digest;
    use std::vec::Vec;

    /// The crate's own hash of the whole is the reference, over lengths on either side of each block's end.
    #[test]
    fn a_signature_is_the_begin_of_the_hash() {
        let key = Key::new(core::array::from_fn(|at| at as u8 + 1)).unwrap();
        for length in 0..200 {
            let frame: Vec<u8> = (0..length).map(|at| (7 * at) as u8).collect();
            let (left, right) = frame.split_at(length / 3);
            let timestamp = 0x0605_0403_0201;
            let found = signature(&key, &[left, right], 9, timestamp);
            let mut all = key.bytes().to_vec();
            all.extend(&frame);
            all.extend([9, 1, 2, 3, 4, 5, 6]);
            assert_eq!(found[..7], [9, 1, 2, 3, 4, 5, 6]);
            assert_eq!(found[7..], sha2::Sha256::digest(&all)[..6], "{length}");
            assert_eq!(stamp_of(&found), (9, timestamp));
        }
    }

    #[test]
    fn no_two_frames_have_the_same_timestamp_and_the_clock_never_goes_back() {
        let mut signer = Signer::new(Key::new([1; 32]).unwrap(), 0);
        let mut stamps = Vec::new();
        for now in [100, 100, 50, 200] {
            signer.set_clock(now);
            stamps.push(stamp_of(&signer.sign(b"frame")).1);
        }
        assert_eq!(stamps, [100, 101, 102, 200]);
        assert_eq!(Key::new([0; 32]), None);
        assert_eq!(std::format!("{:?}", signer.key()), "Key");
    }
}
