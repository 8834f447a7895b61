//! Memory map of the STM32F427 (RM0090 section 2.3) and what the image finds there.

use rand_core::Rng;
use rand_pcg::Pcg64;

/// A region of the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// First address.
    pub start: u32,
    /// Length, bytes.
    pub size: u32,
}

impl Region {
    /// Is the whole range inside?
    pub fn contains(&self, address: u32, length: u32) -> bool {
        let (start, end) = (u64::from(self.start), u64::from(self.start) + u64::from(self.size));
        u64::from(address) >= start && u64::from(address) + u64::from(length) <= end
    }
}

/// The megabyte of flash that every revision of the chip can use.
pub const FLASH: Region = Region { start: 0x0800_0000, size: 0x10_0000 };
/// SRAM 1 to 3, reachable by DMA.
pub const RAM: Region = Region { start: 0x2000_0000, size: 0x3_0000 };
/// Core-coupled memory, out of reach for DMA.
pub const CCM: Region = Region { start: 0x1000_0000, size: 0x1_0000 };
/// System memory page with the unique ID and the flash size (section 45).
pub const SYSTEM: Region = Region { start: 0x1fff_7000, size: 0x1000 };
/// All peripherals on APB1, APB2 and AHB1.
pub const PERIPHERALS: Region = Region { start: 0x4000_0000, size: 0x8_0000 };
/// OTG_FS, on AHB2.
pub const USB: Region = Region { start: 0x5000_0000, size: 0x4_0000 };
/// Each bit of [`PERIPHERALS`] as a word.
pub const PERIPHERAL_BIT_BAND: Region = Region { start: 0x4200_0000, size: 0x100_0000 };
/// Private peripheral bus of the core.
pub const PRIVATE: Region = Region { start: 0xe000_0000, size: 0x10_0000 };

/// What the core and DMA read and write, peripherals aside.
pub trait Memory {
    /// Fills `bytes` from `address`; false if nothing is there.
    fn load(&mut self, address: u32, bytes: &mut [u8]) -> bool;
    /// Writes `bytes` to `address`; false if nothing is there.
    fn store(&mut self, address: u32, bytes: &[u8]) -> bool;
}

/// What RAM holds after power-on: nothing to rely on.
pub fn noise(size: u32, seed: u64) -> Vec<u8> {
    let mut generator = Pcg64::new(u128::from(seed), 0x0a02_bdbf_7bb3_c0a7);
    (0..size / 8).flat_map(|_| generator.next_u64().to_le_bytes()).collect()
}

/// The system memory page: erased, but for the unique ID (section 45.1) and the flash size in Kbyte (section 45.2).
pub fn system_page() -> Vec<u8> {
    let mut page = vec![0xff; SYSTEM.size as usize];
    page[0xa10..0xa1c].copy_from_slice(b"emulated F42");
    page[0xa22..0xa24].copy_from_slice(&2048u16.to_le_bytes());
    page
}

/// The word of the region and its bit that a bit-band address stands for (section 2.3.3).
pub fn bit_band_target(region: Region, offset: u32) -> (u32, u32) {
    let byte = offset / 32;
    let word = region.start + (byte & !3);
    (word, (byte & 3) * 8 + offset / 4 % 8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bit_band_addresses_are_those_of_the_manual() {
        // RM0090 2.3.3's formula: alias = base + byte offset * 32 + bit * 4; RCC_APB1ENR is 0x4002_3840, bit 28 PWREN
        let alias = 0x2_3840 * 32 + 28 * 4;
        assert_eq!(bit_band_target(PERIPHERALS, alias), (0x4002_3840, 28));
        assert_eq!(bit_band_target(PERIPHERALS, 0), (0x4000_0000, 0));
        // the next word, and a bit beyond its first byte
        assert_eq!(bit_band_target(PERIPHERALS, 0x2_3844 * 32 + 14 * 4), (0x4002_3844, 14));
    }

    #[test]
    fn noise_is_the_seeds() {
        assert_eq!(noise(64, 1), noise(64, 1));
        assert_ne!(noise(64, 1), noise(64, 2));
        assert_eq!(noise(RAM.size, 1).len(), RAM.size as usize);
    }

    #[test]
    fn regions_end_where_they_end() {
        assert!(RAM.contains(0x2002_ffff, 1));
        assert!(!RAM.contains(0x2002_ffff, 2));
        assert!(!RAM.contains(0x1fff_ffff, 1));
    }
}
