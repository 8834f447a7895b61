//! The amber LED: dark at boot, one flash a second disarmed, steady armed, fast while the IMU is not usable.

use shared_control::imu_health::ImuHealth;
use shared_control::link::VehicleStatus;
use stm32f4xx_hal::gpio::{OpenDrain, Output, PE12};

/// What is shown.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Sign {
    /// Motors off, ready.
    Disarmed,
    /// Motors may turn.
    Armed,
    /// No IMU.
    NoImu,
}

impl Sign {
    /// What a status shows.
    pub fn of(status: &VehicleStatus) -> Self {
        match (status.arming.motors_turn(), status.imu_health) {
            (true, _) => Self::Armed,
            (false, ImuHealth::Good) => Self::Disarmed,
            (false, ImuHealth::Bad(_)) => Self::NoImu,
        }
    }
}

/// The LED, low active.
pub struct Led {
    pin: PE12<Output<OpenDrain>>,
    tick: u32,
}

impl Led {
    /// Dark.
    pub fn new(pin: PE12<Output<OpenDrain>>) -> Self {
        Self { pin, tick: 0 }
    }

    /// To be called ten times a second.
    pub fn update(&mut self, sign: Sign) {
        self.tick = self.tick.wrapping_add(1);
        let lit = match sign {
            Sign::Disarmed => self.tick.is_multiple_of(10),
            Sign::Armed => true,
            Sign::NoImu => self.tick.is_multiple_of(2),
        };
        if lit { self.pin.set_low() } else { self.pin.set_high() }
    }
}
