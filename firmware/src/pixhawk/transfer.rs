//! What the DMA moves on the sensors' bus: each transfer with its chip and length, and the buffers.

use super::counters::{FIRST_IMU, ImuCounters, SECOND_IMU};
use super::sensor_bus::Chip;
use super::{l3gd20, lsm303d, mpu6000};

/// Address and value of a register.
const REGISTER_BYTES: u16 = 2;

/// Of the longest transfer.
const BUFFER_BYTES: usize = mpu6000::SAMPLE_BYTES as usize;
/// An address; the rest only makes clocks.
type Request = [u8; BUFFER_BYTES];

const fn request(address: u8) -> Request {
    let mut bytes = [0; BUFFER_BYTES];
    bytes[0] = address;
    bytes
}

/// Buffers of the DMA. They must not lie on the stack, which is out of its reach.
pub struct Buffers {
    /// The answer.
    pub received: [u8; BUFFER_BYTES],
    /// What asks for a sample of it.
    pub mpu6000: Request,
    /// The same.
    pub l3gd20: Request,
    /// The same.
    pub lsm303d: Request,
    /// Address and value, written before each.
    pub register: Request,
}

impl Buffers {
    /// What is demanded of each sensor.
    pub const NEW: Self = Self {
        received: [0; BUFFER_BYTES],
        mpu6000: request(mpu6000::SAMPLE_ADDRESS),
        l3gd20: request(l3gd20::SAMPLE_ADDRESS),
        lsm303d: request(lsm303d::SAMPLE_ADDRESS),
        register: request(0),
    };
}

/// What the DMA is at.
#[derive(Clone, Copy)]
pub enum Transfer {
    /// A sample.
    Mpu6000,
    /// A sample of the gyro; that of the accelerometer follows.
    L3gd20,
    /// With what the gyro has said.
    Lsm303d([i16; 3]),
    /// A register.
    Register(Chip),
}

impl Transfer {
    /// Who is selected.
    pub fn chip(self) -> Chip {
        match self {
            Self::Mpu6000 => Chip::Mpu6000,
            Self::L3gd20 => Chip::L3gd20,
            Self::Lsm303d(_) => Chip::Lsm303d,
            Self::Register(chip) => chip,
        }
    }

    /// Length.
    pub fn bytes(self) -> u16 {
        match self {
            Self::Mpu6000 => mpu6000::SAMPLE_BYTES,
            Self::L3gd20 | Self::Lsm303d(_) => l3gd20::SAMPLE_BYTES,
            Self::Register(_) => REGISTER_BYTES,
        }
    }

    /// Where it is counted.
    pub fn counters(self) -> &'static ImuCounters {
        match self {
            Self::Mpu6000 | Self::Register(Chip::Mpu6000) => &FIRST_IMU,
            Self::L3gd20 | Self::Lsm303d(_) | Self::Register(_) => &SECOND_IMU,
        }
    }
}
