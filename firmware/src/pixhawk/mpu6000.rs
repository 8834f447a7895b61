//! MPU6000, gyro and accelerometer of the first IMU. Register map RM-MPU-6000A-00 revision 4.2.

use shared_control::setup::IMU_RATE_HZ;

use super::clock;
use super::counters::{FIRST_IMU_GIVEN_UP, FIRST_IMU_RESTORED};
use super::register_watch::{self, RegisterWatch, Watched};
use super::sensor_bus::{Chip, Flaw, READ, SensorBus, SensorFault};

/// Sleep, reset, clock.
const PWR_MGMT_1: u8 = 0x6B;
const SIGNAL_PATH_RESET: u8 = 0x68;
const WHO_AM_I: u8 = 0x75;
const IDENTITY: u8 = 0x68;
/// Not in the register map: product in the high half, revision in the low one.
const PRODUCT_ID: u8 = 0x0C;
/// Revision C, as an engineering sample and as sold (PX4's `mpu6000` and ArduPilot's `Invensense` drivers).
const REVISION_C: [u8; 4] = [0x14, 0x15, 0x54, 0x55];
/// First register of a sample: INT_STATUS, then acceleration, temperature, rotation, each high byte first.
const INT_STATUS: u8 = 0x3A;
const DATA_READY: u8 = 1;

/// After a reset of the device, and after one of its signal paths, ms; a little more than the map asks.
const RESET_MS: u32 = 101;

/// Sends the address of a sample's first register.
pub const SAMPLE_ADDRESS: u8 = READ | INT_STATUS;
/// Address, status, three accelerations, temperature, three rotations.
pub const SAMPLE_BYTES: u16 = 16;

/// Two samples after its ranges were set again; its gyro takes 30 ms to wake (product specification 6.1).
static WATCHED: Watched = Watched {
    identity: (WHO_AM_I, IDENTITY),
    power: PWR_MGMT_1,
    settle_us: 2_000,
    wake_us: 50_000,
    restored: &FIRST_IMU_RESTORED,
    given_up: &FIRST_IMU_GIVEN_UP,
};

/// What is written, in this order, and must read back.
const fn settings(accel_config: u8) -> [(u8, u8); 9] {
    [
        (PWR_MGMT_1, 0x01),                     // awake, clock from the gyro
        (0x6C, 0x00),                           // PWR_MGMT_2: all axes on
        (0x6A, 0x10),                           // USER_CTRL: I2C off, or bus traffic for others may switch it on
        (0x1A, 0x00),                           // CONFIG: 256 Hz, the least delay; gyro at 8 kHz
        (0x19, (8000 / IMU_RATE_HZ - 1) as u8), // SMPLRT_DIV
        (0x1B, 0x18),                           // GYRO_CONFIG: +-2000 deg/s
        (0x1C, accel_config),
        (0x37, 0x10),       // INT_PIN_CFG: 50 us pulse, cleared by any read
        (0x38, DATA_READY), // INT_ENABLE
    ]
}

/// Setting for +-8 g, 4096 counts per g. Revision C has half the counts of the later ones at every setting, so that the
/// one that is +-4 g in the register map is the one for +-8 g there.
fn accel_config(product: u8) -> u8 {
    if REVISION_C.contains(&product) { 0x08 } else { 0x10 }
}

/// So often is it reset until it answers: it may come up badly, with zeros for all that is read (PX4 tries as often).
const ATTEMPTS: usize = 5;

/// Resets it, checks who answers, writes the settings, reads them back; again, if that fails. Returns the watch
/// over what was set.
pub fn set_up(bus: &mut SensorBus) -> Result<RegisterWatch, SensorFault> {
    let mut outcome = attempt(bus);
    for _ in 1..ATTEMPTS {
        if outcome.is_err() {
            outcome = attempt(bus);
        }
    }
    outcome
}

fn attempt(bus: &mut SensorBus) -> Result<RegisterWatch, SensorFault> {
    let chip = Chip::Mpu6000;
    // register map 4.28: on SPI the signal paths are reset after the device, with 100 ms for each
    bus.write(chip, PWR_MGMT_1, 0x80);
    clock::wait_us(RESET_MS * 1000);
    let identity = bus.read(chip, WHO_AM_I);
    if identity != IDENTITY {
        return Err(SensorFault { chip, flaw: Flaw::Identity(identity) });
    }
    bus.write(chip, SIGNAL_PATH_RESET, 0x07);
    clock::wait_us(RESET_MS * 1000);
    let settings = settings(accel_config(bus.read(chip, PRODUCT_ID)));
    bus.write_all(chip, &settings);
    // the gyro's oscillator takes over
    clock::wait_us(50 * 1000);
    bus.verify(chip, &settings)?;
    Ok(RegisterWatch::new(&WATCHED, register_watch::settings(&[&settings]), 0))
}

/// Rotation and acceleration of a transfer in counts; none if they are not new.
pub fn decode(bytes: &[u8; SAMPLE_BYTES as usize]) -> Option<([i16; 3], [i16; 3])> {
    let [_, status, ax1, ax0, ay1, ay0, az1, az0, _, _, gx1, gx0, gy1, gy0, gz1, gz0] = *bytes;
    let word = |high, low| i16::from_be_bytes([high, low]);
    let gyro = [word(gx1, gx0), word(gy1, gy0), word(gz1, gz0)];
    let accel = [word(ax1, ax0), word(ay1, ay0), word(az1, az0)];
    (status & DATA_READY != 0).then_some((gyro, accel))
}
