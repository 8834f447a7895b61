//! What a card says of itself: CID, CSD, SCR, OCR. SD Physical Layer Simplified Specification 6.00, chapter 5.

/// Voltages of 2.7 to 3.6 V (section 5.1).
pub(super) const VOLTAGES: u32 = 0x00ff_8000;
/// Powered up, in answers of ACMD41.
pub(super) const POWERED_UP: u32 = 1 << 31;
/// High or extended capacity, which addresses sectors: in answers of ACMD41, and in its argument that the host can.
pub(super) const HIGH_CAPACITY: u32 = 1 << 30;

/// The identification, without its CRC (section 5.2): four words, most significant first, as they are sent.
pub(super) const CID: [u32; 4] = [0x0045_4d42, 0x4152_4420, 0x1000_0000, 0x0101_6a01];

/// Version 2.0 of the card's data (section 5.3.3), for a capacity in units of 512 Kbyte.
pub(super) fn csd(sectors: u32) -> [u32; 4] {
    let size = sectors / 1024 - 1;
    // structure 1; TAAC 1 ms; TRAN_SPEED 25 MHz; classes 0, 2, 4, 5, 7, 8, 10; block length 512
    [0x400e_0032, 0x5b59_0000 | size >> 16 & 0x3f, (size & 0xffff) << 16 | 0x7f80, 0x0a40_0001]
}

/// The configuration (section 5.6), eight bytes in the order in which they are sent: version 3.0X, both bus widths.
pub(super) const SCR: [u8; 8] = [0x02, 0x35, 0x80, 0x00, 0x00, 0x00, 0x00, 0x00];

#[cfg(test)]
mod tests {
    use super::*;

    /// The specification's formula: (C_SIZE + 1) * 512 Kbyte, C_SIZE in bits 69 to 48.
    #[test]
    fn the_capacity_can_be_read_back() {
        for sectors in [65_536, 131_072, 15_564_800] {
            let [_, second, third, _] = csd(sectors);
            let size = (second & 0x3f) << 16 | third >> 16;
            assert_eq!((size + 1) * 1024, sectors);
        }
    }
}
