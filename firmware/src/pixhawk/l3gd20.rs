//! L3GD20 or L3GD20H, the gyro of the second IMU. Data sheets DocID022116 revision 2 and DocID023469 revision 2.
//!
//! Its data-ready pin is a level: high from a new sample until it has been read.

use shared_control::sensing::imu::AxisMap;

use super::counters::{L3GD20_GIVEN_UP, L3GD20_RESTORED};
use super::register_watch::{self, RegisterWatch, Watched};
use super::sensor_bus::{Chip, Flaw, INCREMENT, READ, SensorBus, SensorFault};

const WHO_AM_I: u8 = 0x0F;
const CTRL_REG1: u8 = 0x20;
const L3GD20: u8 = 0xD4;
const L3GD20H: u8 = 0xD7;
/// Not in the data sheets. PX4 and ArduPilot both set bit 5, which switches I2C off; else bus traffic for others, which
/// to this chip looks like I2C, may make it answer along.
const I2C_OFF: (u8, u8) = (0x05, 0x20);
/// First register of a sample: STATUS_REG, then three rotations, each low byte first.
const STATUS_REG: u8 = 0x27;

/// Sends the address of a sample's first register.
pub const SAMPLE_ADDRESS: u8 = READ | INCREMENT | STATUS_REG;
/// Address, status, three words; the LSM303D's acceleration is the same.
pub const SAMPLE_BYTES: u16 = 8;
/// All three axes of a sample are new.
const ALL_NEW: u8 = 0x08;

/// What is written, in this order, and must read back.
const SETTINGS: [(u8, u8); 6] = [
    (0x21, 0x00),      // CTRL_REG2: no high-pass
    (0x22, 0x08),      // CTRL_REG3: data-ready on its pin
    (0x23, 0xA0),      // CTRL_REG4: +-2000 deg/s, words of one sample only
    (0x24, 0x00),      // CTRL_REG5: no FIFO, low-pass 1 alone
    (0x2E, 0x00),      // FIFO_CTRL_REG: bypassed
    (CTRL_REG1, 0xFF), // 760 Hz, low-pass 100 Hz, on, all axes
];
/// LOW_ODR, which the L3GD20H alone has: full rate, data-ready active high, I2C off.
const SETTINGS_H: [(u8, u8); 1] = [(0x39, 0x08)];

/// Of either variant. Its turn-on time is 250 ms (table 4); after another range or filter its low-pass of 100 Hz
/// settles in a few samples.
const fn watched(identity: u8) -> Watched {
    Watched {
        identity: (WHO_AM_I, identity),
        power: CTRL_REG1,
        settle_us: 10_000,
        wake_us: 250_000,
        restored: &L3GD20_RESTORED,
        given_up: &L3GD20_GIVEN_UP,
    }
}
static WATCHED: Watched = watched(L3GD20);
static WATCHED_H: Watched = watched(L3GD20H);

/// Checks who answers, writes the settings, reads them back. Returns the axes of the one that is there, and the watch
/// over what was set.
pub fn set_up(bus: &mut SensorBus) -> Result<(AxisMap, RegisterWatch), SensorFault> {
    let chip = Chip::L3gd20;
    let identity = bus.read(chip, WHO_AM_I);
    let (axes, watched, settings_of_variant) = match identity {
        L3GD20 => (AxisMap::PIXHAWK1_L3GD20, &WATCHED, &[][..]),
        L3GD20H => (AxisMap::PIXHAWK1_L3GD20H, &WATCHED_H, &SETTINGS_H[..]),
        _ => return Err(SensorFault { chip, flaw: Flaw::Identity(identity) }),
    };
    let (register, bit) = I2C_OFF;
    let i2c_off = [(register, bus.read(chip, register) | bit)];
    let all = register_watch::settings(&[&i2c_off, &SETTINGS, settings_of_variant]);
    bus.write_all(chip, &all);
    bus.verify(chip, &all)?;
    Ok((axes, RegisterWatch::new(watched, all, 0)))
}

/// The three words of a transfer in counts; none if they are not new.
pub fn decode(bytes: &[u8; SAMPLE_BYTES as usize]) -> Option<[i16; 3]> {
    let [_, status, x0, x1, y0, y1, z0, z1] = *bytes;
    let word = |low, high| i16::from_le_bytes([low, high]);
    (status & ALL_NEW != 0).then_some([word(x0, x1), word(y0, y1), word(z0, z1)])
}
