//! Whose register is looked at when: behind a sample of the first IMU one of its, behind one of the second one of its
//! gyro and its accelerometer by turns; of an IMU that is silent one a step.

use super::register_watch::RegisterWatch;
use super::sensor_bus::Chip;
use super::transfer::Transfer;

/// The first IMU has a sample every 1 ms, the second every 1.3 ms: silent after so long.
const SILENT_US: [u32; 2] = [3_000, 5_000];

/// The watches over all chips that passed their checks.
pub struct Watches {
    mpu6000: Option<RegisterWatch>,
    l3gd20: Option<RegisterWatch>,
    lsm303d: Option<RegisterWatch>,
    /// When each IMU sent last.
    heard_us: [u32; 2],
    gyro_is_next: bool,
    first_is_next: bool,
}

impl Watches {
    /// Over nobody.
    pub const NONE: Self =
        Self { mpu6000: None, l3gd20: None, lsm303d: None, heard_us: [0; 2], gyro_is_next: true, first_is_next: true };

    /// Over those that passed, from now on.
    pub fn new(first: Option<RegisterWatch>, second: Option<[RegisterWatch; 2]>, now_us: u32) -> Self {
        let (l3gd20, lsm303d) = second.map_or((None, None), |[gyro, accelerometer]| (Some(gyro), Some(accelerometer)));
        Self { mpu6000: first, l3gd20, lsm303d, heard_us: [now_us; 2], ..Self::NONE }
    }

    /// The one over a chip.
    pub fn of(&mut self, chip: Chip) -> Option<&mut RegisterWatch> {
        match chip {
            Chip::Mpu6000 => self.mpu6000.as_mut(),
            Chip::L3gd20 => self.l3gd20.as_mut(),
            Chip::Lsm303d => self.lsm303d.as_mut(),
        }
    }

    /// A sample of the first IMU has come. May it be used?
    pub fn trust_first(&mut self, now_us: u32) -> bool {
        self.heard_us[0] = now_us;
        self.mpu6000.as_mut().is_none_or(|watch| watch.trusts(now_us))
    }

    /// The same of the second, which needs both of its chips.
    pub fn trust_second(&mut self, now_us: u32) -> bool {
        self.heard_us[1] = now_us;
        let both = [self.l3gd20.as_mut(), self.lsm303d.as_mut()];
        both.map(|watch| watch.is_none_or(|watch| watch.trusts(now_us))) == [true; 2]
    }

    /// Whose turn it is behind a transfer.
    pub fn behind(&mut self, ended: Transfer) -> Option<Chip> {
        match ended {
            Transfer::Mpu6000 => Some(Chip::Mpu6000),
            Transfer::Lsm303d(_) => {
                self.gyro_is_next = !self.gyro_is_next;
                Some(if self.gyro_is_next { Chip::Lsm303d } else { Chip::L3gd20 })
            }
            Transfer::Register(chip) => self.of(chip)?.is_busy().then_some(chip),
            Transfer::L3gd20 => None,
        }
    }

    /// A chip whose IMU says nothing any more: it may have been reset, and be switched off, which nothing else would
    /// find out. The second IMU's gyro sets the pace of both of its chips.
    pub fn silent(&mut self, now_us: u32) -> Option<Chip> {
        let [first, second] = [0, 1].map(|imu| now_us.wrapping_sub(self.heard_us[imu]) >= SILENT_US[imu]);
        self.first_is_next = !self.first_is_next;
        let chip = match (first, second) {
            (true, true) if self.first_is_next => Chip::Mpu6000,
            (_, true) => Chip::L3gd20,
            (true, false) => Chip::Mpu6000,
            (false, false) => return None,
        };
        self.of(chip)?.is_silent();
        Some(chip)
    }
}
