//! LSM303D, the accelerometer of the second IMU; its magnetometer stays off. Data sheet DocID023312 revision 2.

use super::counters::{LSM303D_GIVEN_UP, LSM303D_RESTORED};
use super::register_watch::{self, RegisterWatch, Watched};
use super::sensor_bus::{Chip, Flaw, INCREMENT, READ, SensorBus, SensorFault};

const WHO_AM_I: u8 = 0x0F;
const IDENTITY: u8 = 0x49;
const CTRL1: u8 = 0x20;
/// First register of a sample: STATUS_A, then three accelerations, each low byte first, as the L3GD20's.
const STATUS_A: u8 = 0x27;

/// Sends the address of a sample's first register.
pub const SAMPLE_ADDRESS: u8 = READ | INCREMENT | STATUS_A;

/// What is written, in this order, and must read back.
const SETTINGS: [(u8, u8); 6] = [
    (0x1F, 0x00), // CTRL0: no FIFO, no high-pass
    // 1600 Hz, so that each reading of the gyro finds a new one; words of one sample only; all axes
    (CTRL1, 0xAF),
    (0x21, 0x58), // CTRL2: low-pass 194 Hz, +-8 g
    (0x22, 0x00), // CTRL3: nothing on pin 1
    (0x23, 0x00), // CTRL4: nothing on pin 2
    (0x26, 0x03), // CTRL7: magnetometer off
];

/// Bits to clear and to set, in this order, in registers that are not in the data sheet: switches I2C off, for the
/// L3GD20's reason, as PX4 and ArduPilot both do it.
const I2C_OFF: [(u8, u8, u8); 4] = [(0x02, 0x00, 0x10), (0x02, 0x08, 0x00), (0x15, 0x00, 0x80), (0x02, 0x18, 0x00)];

/// Its filter settles in a few samples; its turn-on time is less than the gyro's, and not in the data sheet.
static WATCHED: Watched = Watched {
    identity: (WHO_AM_I, IDENTITY),
    power: CTRL1,
    settle_us: 10_000,
    wake_us: 20_000,
    restored: &LSM303D_RESTORED,
    given_up: &LSM303D_GIVEN_UP,
};

/// Checks who answers, writes the settings, reads them back. Returns the watch over them; what switches I2C off it
/// writes too, and does not read.
pub fn set_up(bus: &mut SensorBus) -> Result<RegisterWatch, SensorFault> {
    let chip = Chip::Lsm303d;
    let identity = bus.read(chip, WHO_AM_I);
    if identity != IDENTITY {
        return Err(SensorFault { chip, flaw: Flaw::Identity(identity) });
    }
    let i2c_off = I2C_OFF.map(|(register, clear, set)| {
        let value = bus.read(chip, register) & !clear | set;
        bus.write(chip, register, value);
        (register, value)
    });
    bus.write_all(chip, &SETTINGS);
    bus.verify(chip, &SETTINGS)?;
    Ok(RegisterWatch::new(&WATCHED, register_watch::settings(&[&i2c_off, &SETTINGS]), i2c_off.len()))
}
