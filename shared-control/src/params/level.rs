//! How the IMUs sit on the vehicle, as level calibration stores it or an owner sets it.

use super::allowed::Allowed;
use crate::sensing::level_trim::LevelTrim;

/// One number of an IMU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LevelPart {
    /// [`LevelParams::roll_cdeg`].
    Roll,
    /// [`LevelParams::pitch_cdeg`].
    Pitch,
    /// [`LevelParams::down_mm_s2`].
    Down,
}

/// One IMU.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LevelParams {
    /// Roll that it shows while the vehicle is level, 1/100 degree.
    pub roll_cdeg: i16,
    /// Pitch that it shows while the vehicle is level, 1/100 degree.
    pub pitch_cdeg: i16,
    /// What its accelerometer says too much downwards, mm/s^2.
    pub down_mm_s2: i16,
}

/// Limits of a trim and of an offset, as [`LevelTrim`] has them.
const TRIM_CDEG: Allowed = Allowed::Signed(1000);
const OFFSET_MM_S2: Allowed = Allowed::Signed(1000);

impl LevelParams {
    /// To the nearest hundredth of a degree and millimetre per second squared.
    pub fn new(trim: &LevelTrim) -> Self {
        let nearest = |value: f32| if value < 0.0 { value - 0.5 } else { value + 0.5 } as i16;
        Self {
            roll_cdeg: nearest(100.0 * trim.roll_rad.to_degrees()),
            pitch_cdeg: nearest(100.0 * trim.pitch_rad.to_degrees()),
            down_mm_s2: nearest(1000.0 * trim.down_m_s2),
        }
    }

    /// What it means.
    pub fn trim(&self) -> LevelTrim {
        let radians = |cdeg: i16| (f32::from(cdeg) / 100.0).to_radians();
        LevelTrim {
            roll_rad: radians(self.roll_cdeg),
            pitch_rad: radians(self.pitch_cdeg),
            down_m_s2: f32::from(self.down_mm_s2) / 1000.0,
        }
    }

    /// A number, as the table has it.
    pub(super) fn get(&self, part: LevelPart) -> u16 {
        let value = match part {
            LevelPart::Roll => self.roll_cdeg,
            LevelPart::Pitch => self.pitch_cdeg,
            LevelPart::Down => self.down_mm_s2,
        };
        value as u16
    }

    /// Changes a number, to what the table allows.
    pub(super) fn set(&mut self, part: LevelPart, value: u16) {
        match part {
            LevelPart::Roll => self.roll_cdeg = value as i16,
            LevelPart::Pitch => self.pitch_cdeg = value as i16,
            LevelPart::Down => self.down_mm_s2 = value as i16,
        }
    }
}

/// Name, range, unit and meaning of a number of the first or the second IMU.
pub(super) const fn row(second: bool, part: LevelPart) -> (&'static str, Allowed, &'static str, &'static str) {
    const CDEG: &str = "1/100 deg";
    const ROLL: &str = "roll that the IMU shows while the vehicle is level";
    const PITCH: &str = "pitch that the IMU shows while the vehicle is level";
    const DOWN: &str = "what its accelerometer says too much downwards";
    match (second, part) {
        (false, LevelPart::Roll) => ("IMU1_ROLL_CDEG", TRIM_CDEG, CDEG, ROLL),
        (true, LevelPart::Roll) => ("IMU2_ROLL_CDEG", TRIM_CDEG, CDEG, ROLL),
        (false, LevelPart::Pitch) => ("IMU1_PITCH_CDEG", TRIM_CDEG, CDEG, PITCH),
        (true, LevelPart::Pitch) => ("IMU2_PITCH_CDEG", TRIM_CDEG, CDEG, PITCH),
        (false, LevelPart::Down) => ("IMU1_DOWN_MM_S2", OFFSET_MM_S2, "mm/s^2", DOWN),
        (true, LevelPart::Down) => ("IMU2_DOWN_MM_S2", OFFSET_MM_S2, "mm/s^2", DOWN),
    }
}
